#!/usr/bin/env python3
"""Example relay: RTAB-Map with the match filter's keypoints and odometry in place of its own. It publishes rgbd_image
(rtabmap_msgs/RGBDImage) and odom_rtabmap (nav_msgs/Odometry) with the same stamp, ~rate times a second. Needs rectified
images, ~scale: depth and rtabmap_msgs of introlab/rtabmap_ros.
    roslaunch gms_ransac example_rtabmap.launch"""
import argparse
import struct
import sys
import zlib

import numpy as np
import rospy
from message_filters import Cache, Subscriber, TimeSynchronizer
from nav_msgs.msg import Odometry
from rospy.numpy_msg import numpy_msg
from sensor_msgs.msg import CameraInfo, Image

from gms_ransac.msg import Keypoints

try:
    from rtabmap_msgs.msg import KeyPoint, Point2f, Point3f, RGBDImage
except ImportError:
    sys.exit("rtabmap_relay: rtabmap_msgs is missing; it is a package of introlab/rtabmap_ros")

DEPTH_TOLERANCE = 0.025  # seconds between an image and its depth, as in the match filter
SMALLEST_VARIANCE = 1e-9  # RTAB-Map does not take zero
CERTAIN = SMALLEST_VARIANCE * np.eye(6)  # covariance of no motion
UNKNOWN_VARIANCE = 999  # of a velocity that the match filter does not know
CV_8UC1, CV_32FC1 = 0, 5


def cross_matrix(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def pose_of(odom):
    """Position, rotation matrix and 6 x 6 covariance of an Odometry."""
    p, q = odom.pose.pose.position, odom.pose.pose.orientation
    axis = cross_matrix((q.x, q.y, q.z))
    rotation = np.eye(3) + 2 * q.w * axis + 2 * axis @ axis
    return np.array((p.x, p.y, p.z)), rotation, np.reshape(odom.pose.covariance, (6, 6))


def motion_covariance(before, now):
    """6 x 6 covariance of the motion between two poses of one odometry, in the axes of the later pose: what the later
    covariance holds beyond the earlier one. An earlier error of the rotation moves the later position too."""
    carry = np.eye(6)
    carry[:3, 3:] = -cross_matrix(now[0] - before[0])
    to_frame = np.kron(np.eye(2), now[1].T)
    grown = to_frame @ (now[2] - carry @ before[2] @ carry.T) @ to_frame.T
    values, vectors = np.linalg.eigh((grown + grown.T) / 2)
    return vectors * np.maximum(values, SMALLEST_VARIANCE) @ vectors.T


def continued(motion, before, now, odom, seconds):
    """Covariance of a motion that ended at the first of two poses, continued to the second, in the axes of that. The
    step has the covariance of its velocity; where that is unknown, what the pose's grew by. (That alone would not do:
    errors of scale, which all steps share, cancel on the way back, where the pose's covariance shrinks.)"""
    carry = np.eye(6)
    carry[:3, 3:] = -cross_matrix(before[1].T @ (now[0] - before[0]))
    carry = np.kron(np.eye(2), now[1].T @ before[1]) @ carry
    velocity = np.reshape(odom.twist.covariance, (6, 6))
    step = seconds**2 * velocity if velocity[0, 0] < UNKNOWN_VARIANCE else motion_covariance(before, now)
    return carry @ motion @ carry.T + step


def compress(matrix):
    """A matrix of bytes or floats as RTAB-Map stores it: zlib, then rows, columns and OpenCV's type."""
    return zlib.compress(matrix.tobytes(), 1) + struct.pack("<3i", *matrix.shape, CV_8UC1 if matrix.dtype == np.uint8 else CV_32FC1)


def rgbd_image(keypoints, image, depth_image, camera_info):
    """RGBDImage with the keypoints, their points in the optical frame (NaN: unknown) and their descriptors."""
    u, v, K = keypoints.u, keypoints.v, keypoints.K
    depth = np.where(keypoints.depth > 0, keypoints.depth, np.nan)
    points = np.stack((depth * (u - K[2]) / K[0], depth * (v - K[5]) / K[4], depth), 1)
    octaves = np.frombuffer(keypoints.octave, np.uint8)
    rows = zip(u.tolist(), v.tolist(), keypoints.size.tolist(), keypoints.angle.tolist(), keypoints.response.tolist(),
               octaves.tolist())
    message = RGBDImage(header=image.header, rgb=image, depth=depth_image)
    message.rgb_camera_info = message.depth_camera_info = camera_info
    message.key_points = [KeyPoint(Point2f(*row[:2]), *row[2:], -1) for row in rows]
    message.points = [Point3f(*point) for point in points.tolist()]
    number = np.float32 if keypoints.descriptor_type == Keypoints.DESCRIPTOR_FLOAT32 else np.uint8
    columns = keypoints.descriptor_size // np.dtype(number).itemsize
    message.descriptors = compress(np.frombuffer(keypoints.descriptors, number).reshape(-1, columns))
    return message


class Relay:
    def __init__(self):
        self.period = 1 / rospy.get_param("~rate", 1.0)
        self.last_stamp, self.last_pose, self.camera_info = None, None, None
        self.sent, self.motion = None, CERTAIN  # stamp of the last message, motion since then
        self.images = rospy.Publisher("rgbd_image", RGBDImage, queue_size=10)
        self.odometry = rospy.Publisher("odom_rtabmap", Odometry, queue_size=10)
        self.depths = Cache(Subscriber("depth/image", Image), 30)
        rospy.Subscriber("camera_info", CameraInfo, lambda message: setattr(self, "camera_info", message))
        inputs = Subscriber("keypoints", numpy_msg(Keypoints)), Subscriber("odom", Odometry), Subscriber("image", Image)
        self.synchronizer = TimeSynchronizer(inputs, 30)
        self.synchronizer.registerCallback(self.relay)

    def relay(self, keypoints, odom, image):
        stamp, pose = image.header.stamp, pose_of(odom)
        if self.last_stamp:
            self.motion = continued(self.motion, self.last_pose, pose, odom, (stamp - self.last_stamp).to_sec())
        self.last_stamp, self.last_pose = stamp, pose
        if self.sent and 0 <= (stamp - self.sent).to_sec() < 0.999 * self.period:
            return
        near = self.depths.getInterval(stamp - rospy.Duration(DEPTH_TOLERANCE), stamp + rospy.Duration(DEPTH_TOLERANCE))
        if keypoints.pixel_space != Keypoints.PIXELS_RECTIFIED or not keypoints.K[0]:
            rospy.logwarn_throttle(10, "rtabmap_relay: the match filter's images are not rectified and calibrated")
        elif len(keypoints.depth) == 0:
            rospy.logwarn_throttle(10, "rtabmap_relay: keypoints without depth; set ~scale: depth of the match filter")
        elif near and self.camera_info:
            depth_image = min(near, key=lambda message: abs((message.header.stamp - stamp).to_sec()))
            # RTAB-Map reads the covariance of the twist as that of the motion since the message before.
            odom.twist.covariance = self.motion.ravel().tolist()
            self.images.publish(rgbd_image(keypoints, image, depth_image, self.camera_info))
            self.odometry.publish(odom)
            self.sent, self.motion = stamp, CERTAIN


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
                            allow_abbrev=False).parse_args(rospy.myargv()[1:])
    rospy.init_node("rtabmap_relay")
    relay = Relay()
    rospy.spin()
