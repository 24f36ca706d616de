#!/usr/bin/env python3
"""Example detector: SIFT, AKAZE or ORB of OpenCV in place of the match filter's own features. It publishes `keypoints` for
every `image`; ~detector is sift (default), akaze or orb, ~features how many keypoints an image has at most.
    rosrun gms_ransac publish_keypoints.py image:=/camera/image_raw keypoints:=/keypoints _detector:=akaze
    roslaunch gms_ransac match_filter.launch keypoints:=/keypoints camera_info:=/camera/camera_info"""
import argparse
import functools
import sys
import threading

import cv2
import numpy as np
import rospy
from cv_bridge import CvBridge
from sensor_msgs.msg import Image

from gms_ransac.msg import Keypoints

# Of each detector: how to make it for so many keypoints, and the scale between two octaves.
DETECTORS = {"sift": (lambda features: cv2.SIFT_create(features), 2.0),
             "akaze": (lambda features: cv2.AKAZE_create(threshold=1e-4), 2.0),
             "orb": (lambda features: cv2.ORB_create(features), 1.2)}


@functools.lru_cache()
def finder_of(detector, features):
    return DETECTORS[detector][0](features)


def octave_of(keypoint, detector):
    """Pyramid level, 0 is the finest. SIFT packs its octave, from -1, with the layer into one number."""
    if detector != "sift":
        return keypoint.octave
    lowest_byte = keypoint.octave & 255
    return (lowest_byte if lowest_byte < 128 else lowest_byte - 256) + 1


def keypoints_message(header, grey, detector, features):
    """Keypoints of a grey image. A detector of one's own fills u, v and the descriptors; the other columns may stay empty."""
    finder = finder_of(detector, features)
    found = sorted(finder.detect(grey), key=lambda keypoint: -keypoint.response)[:features]
    found, descriptors = finder.compute(grey, found)
    message = Keypoints(header=header, scale_factor=DETECTORS[detector][1])
    message.height, message.width = grey.shape
    if not found:
        return message
    message.u, message.v = np.float32([keypoint.pt for keypoint in found]).T.tolist()
    message.octave = bytes(octave_of(keypoint, detector) for keypoint in found)
    message.size = [keypoint.size for keypoint in found]
    message.angle = [keypoint.angle % 360 if keypoint.angle >= 0 else -1 for keypoint in found]
    message.response = [keypoint.response for keypoint in found]
    floats = descriptors.dtype == np.float32
    message.descriptor_type = Keypoints.DESCRIPTOR_FLOAT32 if floats else Keypoints.DESCRIPTOR_BINARY
    message.descriptor_size = descriptors.shape[1] * descriptors.itemsize
    message.descriptors = descriptors.tobytes()
    return message


def main():
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
                            allow_abbrev=False).parse_args(rospy.myargv()[1:])
    rospy.init_node("publish_keypoints", anonymous=True)
    detector, features = rospy.get_param("~detector", "sift"), rospy.get_param("~features", 2000)
    if detector not in DETECTORS:
        sys.exit("~detector is '%s'; it must be one of %s" % (detector, ", ".join(sorted(DETECTORS))))
    bridge, publisher = CvBridge(), rospy.Publisher("keypoints", Keypoints, queue_size=10)
    detecting = threading.Lock()

    def on_image(image):
        with detecting:
            publisher.publish(keypoints_message(image.header, bridge.imgmsg_to_cv2(image, "mono8"), detector, features))

    rospy.Subscriber("image", Image, on_image, queue_size=10, buff_size=2 ** 25)
    rospy.on_shutdown(detecting.acquire)  # the process would abort if Python ended while a callback is in OpenCV
    rospy.spin()


if __name__ == "__main__":
    main()
