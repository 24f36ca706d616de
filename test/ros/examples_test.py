#!/usr/bin/env python3
"""The example launch files, in one graph: each one's filter answers, in the frames that the file promises."""
import itertools
import unittest

import numpy as np
import rospy
import rostest
from geometry_msgs.msg import TwistWithCovarianceStamped
from gms_ransac.msg import MatchStats
from nav_msgs.msg import Odometry

from graph import Client, Scene, vector

STEP = np.array((0.0, 0.0, 0.2))  # ahead


class Examples(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.frames = [Scene().draw(t=STEP * i) for i in range(3)]

    def outputs(self, client, topic, kind):
        """Sends the frames and returns what comes out on the topic, one message per pair."""
        messages = []
        client.subscribe(topic, kind, messages)
        client.connect()
        for i, frame in enumerate(self.frames):
            answer = client.ask(frame, 100 + 0.1 * i)
        self.assertEqual(answer.status, MatchStats.OK, answer.status_text)
        client.wait(lambda: len(messages) == len(self.frames) - 1, topic)
        return messages

    def test_two_cameras_have_an_odometry_frame_each(self):
        for side in ("left", "right"):
            client = Client(side + "_filter", "/%s/image" % side, "/%s/camera_info" % side)
            for odom in self.outputs(client, "odom", Odometry):
                self.assertEqual(odom.header.frame_id, side + "_filter_odom")

    def test_rectified_images_are_read_beside_the_camera_info(self):
        client = Client("match_filter", "/rectified/image_rect", "/rectified/camera_info")
        self.assertTrue(self.outputs(client, "odom", Odometry))

    def test_twist_for_robot_localization_is_that_of_the_base(self):
        client = Client("/robot/match_filter", "/robot/image", "/robot/camera_info")
        twists = []
        client.subscribe("twist", TwistWithCovarianceStamped, twists)
        client.connect()
        sent = itertools.count()

        def walk():
            """One step, ahead twice and back twice; the first ones may come before tf knows where the camera is."""
            i = next(sent)
            client.ask(self.frames[(0, 1, 2, 1)[i % 4]], 100 + 0.1 * i)
            return len(twists) >= 3

        client.wait(walk, "twist")
        stamps = [twist.header.stamp for twist in twists]
        self.assertEqual(stamps, sorted(set(stamps)), "older ones are not taken")
        for twist in twists:
            self.assertEqual(twist.header.frame_id, "base_link")
            covariance = np.reshape(twist.twist.covariance, (6, 6))
            self.assertTrue(np.allclose(covariance, covariance.T))
            self.assertGreater(np.linalg.eigvalsh(covariance)[0], 1e-9, "what the filter raises smaller variances to")
            ahead = round((twist.header.stamp.to_sec() - 100) / 0.1) % 4 in (1, 2)
            v = vector(twist.twist.twist.linear)
            self.assertGreater((v[0] if ahead else -v[0]) / np.linalg.norm(v), 0.99, "the camera looks along the base's x")

    def test_mono_velocity_is_not_fused(self):
        fused = rospy.get_param("/robot/ekf/twist0_config")
        self.assertEqual([i for i, on in enumerate(fused) if on], [9, 10, 11], "vroll, vpitch, vyaw")


if __name__ == "__main__":
    rospy.init_node("examples_test")
    rostest.rosrun("gms_ransac", "examples", Examples)
