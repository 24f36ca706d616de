#!/usr/bin/env python3
"""The frames that rviz/match_filter.rviz names, with z up and x ahead: match_filter_world at the fixed frame, and
match_filter_view at the camera, whose frame the first marker tells."""
import rospy
import tf2_ros
from geometry_msgs.msg import Quaternion, TransformStamped
from visualization_msgs.msg import MarkerArray

UPRIGHT = Quaternion(0.5, -0.5, 0.5, 0.5)  # from optical axes


def child_of(parent, name, rotation):
    transform = TransformStamped(child_frame_id=name)
    transform.header.frame_id = parent
    transform.header.stamp = rospy.Time.now()
    transform.transform.rotation = rotation
    return transform


rospy.init_node("view_frames")
broadcaster = tf2_ros.StaticTransformBroadcaster()
optical = rospy.get_param("~optical", True)
world = child_of(rospy.get_param("~fixed_frame", "odom"), "match_filter_world", UPRIGHT if optical else Quaternion(0, 0, 0, 1))
broadcaster.sendTransform(world)
markers = rospy.wait_for_message("match_markers", MarkerArray)
# Both: who subscribes later hears the last message alone.
broadcaster.sendTransform([world, child_of(markers.markers[0].header.frame_id, "match_filter_view", UPRIGHT)])
rospy.spin()
