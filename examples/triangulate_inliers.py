#!/usr/bin/env python3
"""Example subscriber: the inliers of every pair as points in the current camera's optical frame, in multiples of the
baseline (metres when the message says metric_scale). The distortion of images that are not rectified comes from
camera_info.
    rosrun gms_ransac triangulate_inliers.py correspondences:=/match_filter/correspondences camera_info:=/camera/camera_info"""
import argparse
import collections
import sys

try:
    import cv2
    import numpy as np
except ImportError as error:
    sys.exit("triangulate_inliers.py: %s; install python3-opencv and python3-numpy" % error)
import rospy
from rospy.numpy_msg import numpy_msg

from gms_ransac.msg import Correspondences
from sensor_msgs.msg import CameraInfo


def rotation(q):
    axis = np.cross(np.eye(3), (q.x, q.y, q.z))
    return np.eye(3) + 2 * q.w * axis + 2 * axis @ axis


def rays(points, message, info):
    """N x 3: pixels to rays (x, y, 1); only the pixels of a rectified image are described by K alone."""
    K, pixels = np.reshape(message.K, (3, 3)), points.reshape(-1, 1, 2)
    if message.pixel_space == Correspondences.PIXELS_RECTIFIED:
        ideal = cv2.undistortPoints(pixels, K, None)
    elif info.distortion_model in ("equidistant", "fisheye"):
        ideal = cv2.fisheye.undistortPoints(pixels, K, np.array(info.D))
    else:
        ideal = cv2.undistortPointsIter(pixels, K, np.array(info.D), None, None, (3, 100, 1e-10))
    return np.c_[ideal.reshape(-1, 2), np.ones(len(ideal))]


def triangulate(message, info):
    """N x 3 points by the mid-point method: minimises |l a - t - m b| for rays a and b."""
    inlier = message.stage == Correspondences.STAGE_INLIER if len(message.stage) else slice(None)
    reference, current = (rays(p, message, info)[inlier] for p in (message.reference_points, message.current_points))
    pose = message.current_in_reference.pose
    t = np.array([pose.position.x, pose.position.y, pose.position.z])
    turned = current @ rotation(pose.orientation).T
    aa, bb, ab = (np.sum(x * y, 1) for x, y in ((reference, reference), (turned, turned), (reference, turned)))
    at, bt = reference @ t, turned @ t
    area = np.maximum(aa * bb - ab * ab, 1e-12)  # of the parallelogram between the rays, squared
    depth_reference, depth = (bb * at - ab * bt) / area, (ab * at - aa * bt) / area
    good = (depth_reference > 0) & (depth > 0) & (area > aa * bb * np.sin(np.radians(0.2)) ** 2)
    return current[good] * depth[good, None]


def on_correspondences(message):
    if message.pixel_space == Correspondences.PIXELS_RAW and not infos:
        rospy.logwarn_throttle(10, "the points are pixels of a distorted image and no camera_info has come on %s"
                               % rospy.resolve_name("camera_info"))
    elif message.pose_valid:
        points = triangulate(message, infos[-1] if infos else None)
        rospy.loginfo("%d points of %d matches, centre %s", len(points), message.confidence.size,
                      np.round(points.mean(0), 2) if len(points) else None)


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
                            allow_abbrev=False).parse_args(rospy.myargv()[1:])
    rospy.init_node("triangulate_inliers", anonymous=True)
    infos = collections.deque(maxlen=1)  # the latest
    rospy.Subscriber("camera_info", CameraInfo, infos.append)
    rospy.Subscriber("correspondences", numpy_msg(Correspondences), on_correspondences)
    rospy.spin()
