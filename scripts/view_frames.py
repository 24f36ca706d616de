#!/usr/bin/env python3
"""What rviz/match_filter.rviz cannot follow by itself: frames with z up, and the size of the scene. Broadcasts
match_filter_world at the fixed frame, x ahead, and match_filter_view, from which rviz looks at the camera: its heading, at a
distance that grows with the median depth of the points. Publishes a grid on the ground, whose cells are a round number of
units.

Parameters: ~fixed_frame, ~optical (the fixed frame has optical axes). Topics: match_markers, inlier_points; ~grid."""
import math

import numpy as np
import rospy
import tf2_ros
from geometry_msgs.msg import Point, Quaternion, TransformStamped
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

UPRIGHT = Quaternion(0.5, -0.5, 0.5, 0.5)  # from optical axes
# Of the view in match_filter.rviz.
VIEW_DISTANCE, VIEW_PITCH = 4.0, 0.4
DISTANCE_OF_SCENE = 1.4  # from the eye to the camera, median depths
FIRST_CLOUDS = 5  # from which the first scene is known
NEW_SCENE = 2.0  # factor of the median depth from which on the view follows: a view that always moves is no view
CELL_OF_SCENE = 0.25  # most, median depths
CELLS = 40
TF_LATE = rospy.Duration(0.2)  # of a camera's place behind its markers
GROUND = 95  # percentile of the points' height below the camera


def round_cell(limit):
    """The largest of 1, 2, 5 and their multiples by ten that is not above the limit."""
    power = 10.0 ** math.floor(math.log10(limit))
    return max(step * power for step in (1, 2, 5) if step * power <= limit * 1.0001)


def points_of(cloud):
    """N x 3, optical axes."""
    names = {field.name: field.offset for field in cloud.fields}
    bytes_ = np.frombuffer(cloud.data, np.uint8).reshape(-1, cloud.point_step)
    return np.column_stack([bytes_[:, names[axis]:names[axis] + 4].copy().view("<f4") for axis in "xyz"])


def heading_of(rotation):
    """Of the optical axis in a frame with z up, radians about z."""
    x, y, z, w = rotation.x, rotation.y, rotation.z, rotation.w
    ahead = 2 * (x * z + w * y), 2 * (y * z - w * x)  # the third column of the matrix
    return math.atan2(ahead[1], ahead[0])


class View:
    def __init__(self):
        self.fixed_frame = rospy.get_param("~fixed_frame", "odom")
        self.depth, self.ground, self.depths, self.grounds, self.shown, self.centre = 0.0, 0.0, [], [], None, None
        self.buffer = tf2_ros.Buffer()
        self.listener = tf2_ros.TransformListener(self.buffer)
        self.broadcaster = tf2_ros.TransformBroadcaster()
        self.fixed_broadcaster = tf2_ros.StaticTransformBroadcaster()
        self.grid = rospy.Publisher("~grid", Marker, queue_size=1, latch=True)
        world = self.transform(self.fixed_frame, "match_filter_world", rospy.Time.now())
        world.transform.rotation = UPRIGHT if rospy.get_param("~optical", True) else Quaternion(0, 0, 0, 1)
        self.fixed_broadcaster.sendTransform(world)
        rospy.Subscriber("inlier_points", PointCloud2, self.on_points, queue_size=2)
        rospy.Subscriber("match_markers", MarkerArray, self.on_markers, queue_size=2)

    @staticmethod
    def transform(parent, child, stamp):
        result = TransformStamped(child_frame_id=child)
        result.header.frame_id, result.header.stamp = parent, stamp
        return result

    def on_points(self, cloud):
        points = points_of(cloud)
        if not len(points):
            return
        self.depths = (self.depths + [float(np.median(points[:, 2]))])[-FIRST_CLOUDS:]
        self.grounds = (self.grounds + [float(np.percentile(points[:, 1], GROUND))])[-FIRST_CLOUDS:]
        depth = float(np.median(self.depths))
        if depth > 0 and not self.depth / NEW_SCENE < depth < self.depth * NEW_SCENE:
            self.depth, self.ground, self.centre = depth, float(np.median(self.grounds)), None

    def on_markers(self, message):
        header = message.markers[0].header
        if header.stamp == self.shown:  # tf takes one transform a moment
            return
        try:
            place = self.buffer.lookup_transform("match_filter_world", header.frame_id, header.stamp, TF_LATE).transform
        except tf2_ros.TransformException:
            return
        self.shown = header.stamp
        self.follow_with_grid(place.translation)
        heading = heading_of(place.rotation)
        view = self.transform("match_filter_world", "match_filter_view", header.stamp)
        # rviz looks at the frame from VIEW_DISTANCE behind and above it: ahead of the camera it is seen from nearer.
        ahead = VIEW_DISTANCE - DISTANCE_OF_SCENE * self.depth if self.depth else 0.0
        forward = ahead * math.cos(VIEW_PITCH)
        view.transform.translation.x = place.translation.x + forward * math.cos(heading)
        view.transform.translation.y = place.translation.y + forward * math.sin(heading)
        view.transform.translation.z = place.translation.z - ahead * math.sin(VIEW_PITCH)
        view.transform.rotation = Quaternion(0, 0, math.sin(heading / 2), math.cos(heading / 2))
        self.broadcaster.sendTransform(view)

    def follow_with_grid(self, place):
        """Draws the grid where it is not yet, or no longer, around the camera."""
        if not self.depth:
            return
        cell = round_cell(CELL_OF_SCENE * self.depth)
        x, y = round(place.x / cell) * cell, round(place.y / cell) * cell
        if self.centre and max(abs(x - self.centre[0]), abs(y - self.centre[1])) < CELLS / 4 * cell:
            return
        if self.centre is None:
            rospy.loginfo("the cells of the grid are %g wide: metres with a metric ~scale, else units of the translation", cell)
        self.centre = x, y
        self.draw_grid(x, y, place.z - self.ground, cell)

    def draw_grid(self, x, y, z, cell):
        grid = Marker(ns="grid", type=Marker.LINE_LIST, color=ColorRGBA(0.5, 0.5, 0.53, 0.7))
        grid.header.frame_id = "match_filter_world"
        grid.pose.orientation.w, grid.scale.x = 1, 0.01 * cell
        half = CELLS / 2 * cell
        for k in range(CELLS + 1):
            at = k * cell - half
            grid.points += [Point(x + at, y - half, z), Point(x + at, y + half, z)]
            grid.points += [Point(x - half, y + at, z), Point(x + half, y + at, z)]
        self.grid.publish(grid)


rospy.init_node("view_frames")
View()
rospy.spin()
