#!/usr/bin/env python3
"""Example relay: ~stereo_features under the type that another package calls the same fields by, which ROS takes for
another one. For msckf_vio:
    rosrun gms_ransac relay_stereo_features.py in:=/match_filter/stereo_features out:=/firefly_sbx/vio/features"""
import argparse

import roslib.message
import rospy

from gms_ransac.msg import StereoFeatures

if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args(
        rospy.myargv()[1:])
    rospy.init_node("relay_stereo_features", anonymous=True)
    kind = rospy.get_param("~type", "msckf_vio/CameraMeasurement")
    measurement = roslib.message.get_message_class(kind)
    if measurement is None:
        raise SystemExit("~type is '%s': no package that this terminal knows has this message" % kind)
    publisher = rospy.Publisher("out", measurement, queue_size=10)
    feature = roslib.message.get_message_class(measurement._slot_types[1][:-2])

    def relay(message):
        publisher.publish(message.header, [feature(f.id, f.u0, f.v0, f.u1, f.v1) for f in message.features])

    rospy.Subscriber("in", StereoFeatures, relay)
    rospy.spin()
