#!/usr/bin/env python3
"""~input keypoints: features of another detector in place of images, with the example that publishes them."""
import os
import signal
import subprocess
import sys
import threading
import unittest

import numpy as np
import rospkg
import rospy
from gms_ransac.msg import Keypoints, MatchStats
from sensor_msgs.msg import Image
from std_msgs.msg import Header

from graph import STEP, TIMEOUT, Client, camera_info, degrees_between, image_message, run, vector, wait_for, walk

sys.path.insert(0, os.path.join(rospkg.RosPack().get_path("gms_ransac"), "examples"))
from publish_keypoints import keypoints_message  # noqa: E402

FEATURES = 1000


class Detector(Client):
    """Sends keypoints in place of images."""

    def __init__(self, name):
        super().__init__(name, name + "/unused", name + "/camera_info")
        self.image = rospy.Publisher(name + "/detector/keypoints", Keypoints, queue_size=200)

    def send(self, message, stamp, **_):
        message.header.stamp = rospy.Time.from_sec(stamp)
        self.info.publish(camera_info(stamp))
        self.image.publish(message)


class OwnKeypoints(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.frames = walk(3)

    def message(self, i, detector):
        return keypoints_message(Header(frame_id="camera"), self.frames[i], detector, FEATURES)

    def test_floats_and_long_binary_ones_give_the_motion(self):
        pictures, published = [], []
        client = Detector("own")
        client.subscribe("match_image", Image, pictures)
        client.subscribe("keypoints", Keypoints, published)
        client.connect()
        for start, detector, size in ((100, "sift", 512), (200, "akaze", 61), (300, "orb", 32)):
            for i in range(3):
                answer = client.ask(self.message(i, detector), start + 0.1 * i)
            self.assertEqual(answer.status, MatchStats.OK, (detector, answer.status_text))
            pair = client.correspondence(start + 0.2)
            self.assertTrue(pair.pose_valid)
            self.assertEqual((pair.width, pair.height), (640, 480))
            self.assertGreater(len(pair.probability), 100, detector)
            # The second image's camera is STEP away from the first's, without a rotation.
            self.assertLess(degrees_between(vector(pair.current_in_reference.pose.position), STEP), 2, detector)
            moved = np.reshape(pair.current_points, (-1, 2)) - np.reshape(pair.reference_points, (-1, 2))
            self.assertLess(np.median(moved[:, 0]), -5, "pixels, as the camera moves to the right")
            client.wait(lambda: published and published[-1].header.stamp == answer.header.stamp, "the keypoints")
            self.assertEqual(published[-1].descriptor_size, size)
            self.assertEqual(len(published[-1].descriptors), size * len(published[-1].u))
        client.wait(lambda: len(pictures) == 9, "a match image of every message")
        self.assertEqual((pictures[-1].encoding, pictures[-1].width), ("bgr8", 640))

    def test_a_malformed_message_is_answered_with_what_is_wrong(self):
        client = Detector("wrong").connect()
        client.ask(self.message(0, "orb"), 100)
        for i, (spoil, sentence) in enumerate((
                (lambda m: setattr(m, "descriptors", m.descriptors[:-1]), "descriptors has"),
                (lambda m: setattr(m, "descriptor_size", 0), "descriptor_size is 0"),
                (lambda m: setattr(m, "width", 0), "width or height is 0"),
                (lambda m: setattr(m, "u", [float("nan")] + m.u[1:]), "keypoint 0 lies outside the image")), 1):
            message = self.message(1, "orb")
            spoil(message)
            answer = client.ask(message, 100 + 0.1 * i)
            self.assertEqual(answer.status, MatchStats.BAD_IMAGE)
            self.assertIn("image on /wrong/detector/keypoints not used: Keypoints: " + sentence, answer.status_text)
        answer = client.ask(self.message(1, "orb"), 100.6)
        self.assertEqual(answer.status, MatchStats.OK, answer.status_text)
        answer = client.ask(self.message(2, "sift"), 100.7)
        self.assertEqual(answer.status, MatchStats.FIRST_FRAME)
        self.assertIn("the descriptors changed from 32 bytes to 128 floats", answer.status_text)

    @unittest.skipIf("isAlive" in rospy.core.signal_shutdown.__code__.co_names and not hasattr(threading.Thread, "isAlive"),
                     "no node of this rospy ends cleanly: it calls Thread.isAlive, which this Python does not have")
    def test_the_example_ends_at_ctrl_c_while_it_detects(self):
        images, published = rospy.Publisher("ended/image", Image, queue_size=10), []
        subscriber = rospy.Subscriber("ended/keypoints", Keypoints, published.append, queue_size=10)
        self.addCleanup(subscriber.unregister)
        slow = np.tile(self.frames[0], (2, 1))  # ten of these keep SIFT busy for longer than rospy needs to end
        for _ in range(6):
            detector = subprocess.Popen(["rosrun", "gms_ransac", "publish_keypoints.py", "image:=ended/image",
                                         "keypoints:=ended/keypoints"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            self.addCleanup(detector.kill)
            wait_for(lambda: images.get_num_connections() and subscriber.get_num_connections(), "the detector")
            for i in range(10):
                images.publish(image_message(slow, 100 + i))
            wait_for(lambda: published, "keypoints")
            detector.send_signal(signal.SIGINT)
            said, _ = detector.communicate(timeout=TIMEOUT)
            self.assertEqual((detector.returncode, said), (0, ""))
            wait_for(lambda: not images.get_num_connections() and not subscriber.get_num_connections(), "its end")
            published.clear()


if __name__ == "__main__":
    run("keypoints", OwnKeypoints, own={"input": "keypoints"}, wrong={"input": "keypoints"})
