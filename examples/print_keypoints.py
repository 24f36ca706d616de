#!/usr/bin/env python3
"""Example subscriber: how many keypoints an image has, on which octaves, how many are tracked, and the first descriptor.
    rosrun gms_ransac print_keypoints.py keypoints:=/match_filter/keypoints"""
import argparse

import numpy as np
import rospy
from rospy.numpy_msg import numpy_msg

from gms_ransac.msg import Keypoints


def on_keypoints(message):
    descriptors = np.frombuffer(message.descriptors, np.uint8).reshape(-1, message.descriptor_size)  # a row a keypoint
    octaves = np.bincount(np.frombuffer(message.octave, np.uint8))
    rospy.loginfo("%d keypoints, of each octave %s, %d tracked, first descriptor %s", len(message.u), octaves.tolist(),
                  np.count_nonzero(message.track_id), descriptors[0].tobytes().hex() if len(descriptors) else None)


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
                            allow_abbrev=False).parse_args(rospy.myargv()[1:])
    rospy.init_node("print_keypoints", anonymous=True)
    rospy.Subscriber("keypoints", numpy_msg(Keypoints), on_keypoints)
    rospy.spin()
