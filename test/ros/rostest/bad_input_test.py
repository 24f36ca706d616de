#!/usr/bin/env python3
"""Malformed, useless and changing images: never a crash, a status that says which, and the next good pair is answered."""
import unittest

import numpy as np
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from gms_ransac.msg import MatchStats

from graph import Scene, camera_info, client_of, image_message, run


class BadInput(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.client = client_of("latest").connect()
        # Its images wait for their own camera_info: which one counts is no matter of which connection is faster.
        cls.exact = client_of("exact").connect()
        scene = Scene()
        cls.frames = [scene.draw(t=(0.15 * i, 0.05 * i, 0)) for i in range(4)]
        cls.stamp = 100.0

    def next_stamp(self):
        BadInput.stamp += 0.1
        return self.stamp

    def ask(self, pixels, **options):
        return self.client.ask(pixels, self.next_stamp(), **options)

    def ask_message(self, message):
        count = len(self.client.stats) + 1
        self.client.image.publish(message)
        return self.client.answer(count)

    def ask_exactly(self, pixels, info):
        info.header.stamp = rospy.Time.from_sec(self.next_stamp())
        return self.exact.ask(pixels, self.stamp, info=info)

    def assert_good_pair(self, client=None):
        """The filter still does its work."""
        client = client or self.client
        client.ask(self.frames[0], self.next_stamp())
        answer = client.ask(self.frames[1], self.next_stamp())
        self.assertEqual(answer.status, MatchStats.OK, answer.status_text)
        self.assertGreater(answer.inliers, 100)

    def assert_bad(self, answer, *words):
        self.assertEqual(answer.status, MatchStats.BAD_IMAGE, answer.status_text)
        for word in words + (rospy.resolve_name("latest/image"),):
            self.assertIn(word, answer.status_text)
        self.assert_good_pair()

    def broken(self, **fields):
        message = image_message(self.frames[0], self.next_stamp())
        for name, value in fields.items():
            setattr(message, name, value)
        return message

    def test_unknown_encoding(self):
        self.assert_bad(self.ask_message(self.broken(encoding="sepia12")), "sepia12", "mono8")

    def test_camera_info_that_describes_no_camera(self):
        endless = camera_info(0, d=(np.nan, np.inf, 0, 0, 0))
        self.ask_exactly(self.frames[0], endless)
        answer = self.ask_exactly(self.frames[1], endless)
        self.assertEqual(answer.status, MatchStats.UNCALIBRATED, answer.status_text)
        self.assertIn("finite", answer.status_text)
        self.assert_good_pair(self.exact)

    def test_images_without_camera_info_of_their_stamp_are_counted(self):
        reports = []
        listening = rospy.Subscriber("/diagnostics", DiagnosticArray, lambda m: reports.extend(m.status))
        self.exact.send(self.frames[0], self.next_stamp(), info=camera_info(self.stamp + 0.05))
        self.assert_good_pair(self.exact)

        def counted():
            values = [dict((v.key, v.value) for v in s.values) for s in reports if s.name.endswith("exact: input")]
            return values and int(values[-1]["frames without camera_info of their stamp"]) > 0

        self.exact.wait(counted, "diagnostics to count the image")
        listening.unregister()

    def test_stamps_beyond_what_a_duration_holds(self):
        # The clock is at some 1.8e9 s; a difference of more than 2.1e9 s is none that ros::Duration can hold.
        for stamp in (0.0, 4.2e9, 4.2e9 + 0.1):
            self.client.ask(self.frames[0], stamp)
        self.assert_good_pair()

    def test_padded_rows_are_fine(self):
        padded = np.zeros((480, 700), np.uint8)
        padded[:, :640] = self.frames[1]
        self.ask(self.frames[0])
        message = self.broken(step=700, data=padded.tobytes())
        self.assertEqual(self.ask_message(message).status, MatchStats.OK)

    def test_black_image(self):
        self.assert_good_pair()
        answer = self.ask(np.zeros((480, 640), np.uint8))
        self.assertEqual(answer.status, MatchStats.TOO_FEW_KEYPOINTS)
        answer = self.ask(self.frames[2])  # compared with the last image that had keypoints
        self.assertEqual(answer.status, MatchStats.OK, answer.status_text)

    def test_same_image_twice(self):
        self.assert_good_pair()
        answer = self.ask(self.frames[1])
        self.assertEqual(answer.status, MatchStats.LOW_PARALLAX, answer.status_text)
        pose = self.client.correspondence(self.stamp).current_in_reference
        self.assertEqual((pose.pose.position.x, pose.pose.position.y, pose.pose.position.z), (0, 0, 0))
        self.assertGreater(pose.covariance[0], 100)
        self.assert_good_pair()

    def test_zero_calibration(self):
        zero = camera_info(0, k=np.zeros((3, 3)))
        self.ask_exactly(self.frames[0], zero)
        answer = self.ask_exactly(self.frames[1], zero)
        self.assertEqual(answer.status, MatchStats.UNCALIBRATED, answer.status_text)
        self.assertIn(rospy.resolve_name("exact/camera_info"), answer.status_text)
        message = self.exact.correspondence(self.stamp)
        self.assertFalse(message.pose_valid)
        self.assertGreater(len(message.confidence), 100)
        self.assertGreater(np.median(message.probability), 0.5, "weighed by the fundamental matrix")
        self.assertEqual(set(message.K), {0.0})
        self.assert_good_pair(self.exact)

    def test_resolution_change(self):
        self.assert_good_pair()
        small = self.frames[0][:240, :320].copy()
        answer = self.ask(small)
        self.assertEqual(answer.status, MatchStats.FIRST_FRAME)
        self.assertIn("640x480", answer.status_text)
        answer = self.ask(self.frames[1][:240, :320].copy())
        self.assertEqual(answer.status, MatchStats.UNCALIBRATED)  # camera_info still describes 640x480
        self.assertIn("320x240", answer.status_text)
        self.assert_good_pair()

    def test_every_message_has_columns_of_one_length(self):
        self.assert_good_pair()
        self.assertGreater(len(self.client.correspondence(self.stamp).confidence), 100)
        for message in self.client.correspondences:
            n = len(message.confidence)
            self.assertEqual([len(message.reference_points), len(message.current_points)], [2 * n, 2 * n])
            self.assertEqual([len(message.distance), len(message.track_id), len(message.track_length)], [n] * 3)
            self.assertEqual([len(message.probability), len(message.reference_sigma), len(message.current_sigma)], [n] * 3)
            self.assertEqual(len(message.stage), 0)
            self.assertTrue(np.all(np.isfinite(message.current_in_reference.covariance)))


if __name__ == "__main__":
    run("bad_input", BadInput, latest={}, exact={"camera_info_sync": "exact"})
