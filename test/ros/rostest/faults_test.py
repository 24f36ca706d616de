#!/usr/bin/env python3
"""Neighbours that fail: after each the same processes answer the next good pair, ids and counts are sane, and what was
wrong is said in a sentence. The processes are `required`: were one to end, the test would."""
import os
import struct
import subprocess
import tempfile
import unittest

import numpy as np
import rospy
import rostest
import tf2_msgs.msg
from diagnostic_msgs.msg import DiagnosticArray
from dynamic_reconfigure.msg import Config, IntParameter
from dynamic_reconfigure.srv import Reconfigure
from gms_ransac.msg import Correspondences, MatchStats
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Image

from graph import FULL, K, PATIENCE, STEP, Client, Scene, Stream, camera_info, client_of, image_message, said_by, vector, walk
from processes import pid_of, resident_mb
from tcpros import RawPublisher, RawSubscriber, serialized

RECONFIGURATIONS = 1000 if FULL else 100
LONE = 300  # depth images without an image: 370 MB
# Ten of them wait at the subscription and ten for their image.
LONE_MB = 40
# Images that nobody reads wait at the publisher, ten an output; far less than these would take. A sanitized build, which
# uses memory otherwise and is slow, has fewer.
UNREAD, UNREAD_MB = 100 if PATIENCE == 1 else 20, 30


class Faults(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.client = Client().connect()
        cls.based = client_of("based")
        cls.based.subscribe("odom", Odometry, [])  # or no one asks for the camera's place on its base
        cls.based.connect()
        cls.deep = client_of("deep").connect()
        cls.depth = rospy.Publisher("deep/depth/image", Image, queue_size=LONE)
        cls.reports = []
        cls.listener = rospy.Subscriber("/diagnostics", DiagnosticArray, lambda m: cls.reports.extend(
            (each.name, each.message) for each in m.status))
        cls.said = said_by()
        # Without the first image of the walk: the pair that begins with it is refused with one noise of ten.
        cls.frames = walk(5)[1:]
        cls.stamp = 100.0

    def setUp(self):
        # Earlier images are no reference: their stamps may be anywhere.
        self.assert_good_pair()
        del self.client.correspondences[:]

    def tearDown(self):
        self.assert_good_pair()
        last = self.client.stats[-1]
        self.assertEqual(last.frames_received, last.frames_processed + last.frames_dropped)
        self.assertEqual(last.frames_processed, len(self.client.stats), "one answer for each image")
        for message in self.client.correspondences:
            ids = [i for i in message.track_id if i != 0]
            self.assertEqual(len(ids), len(set(ids)), "ids are unique")
            self.assertGreater(message.header.stamp, message.reference_header.stamp)
            self.assertTrue(np.all(np.isfinite(message.current_in_reference.covariance)))

    def next_stamp(self):
        Faults.stamp += 0.1
        return self.stamp

    def ask_pair(self, client=None):
        client = client or self.client
        client.ask(self.frames[0], self.next_stamp())
        return client.ask(self.frames[1], self.next_stamp())

    def assert_good_pair(self, client=None):
        answer = self.ask_pair(client)
        self.assertEqual(answer.status, MatchStats.OK, answer.status_text)

    def ask_message(self, message, info=None):
        count = len(self.client.stats) + 1
        if info:
            self.client.info.publish(info)
        self.client.image.publish(message)
        return self.client.answer(count)

    def test_publisher_that_dies_amid_a_message(self):
        whole = serialized(image_message(self.frames[2], self.next_stamp()))
        for i, payload in enumerate((whole[:len(whole) // 2], whole[:3], whole[:4], b"\xff" * 8, struct.pack("<I", 0),
                                     struct.pack("<I", 20) + b"\xff" * 20)):
            publisher = RawPublisher("/dying_%d" % i, rospy.resolve_name("image"), Image, payload)
            self.client.wait(lambda: publisher.served, "the filter to connect")
            self.assert_good_pair()
            publisher.close()

    def test_subscriber_that_never_reads(self):
        deaf = [RawSubscriber("/deaf_%d" % i, "/match_filter/" + topic, kind) for i, (topic, kind) in
                enumerate((("match_image", Image), ("correspondences", Correspondences), ("stats", MatchStats)))]
        before = resident_mb(pid_of("/manager"))
        for i in range(UNREAD):
            answer = self.client.ask(self.frames[i % 4], self.next_stamp())
            self.assertEqual(answer.frames_dropped, self.client.stats[0].frames_dropped)
        self.assertLess(resident_mb(pid_of("/manager")) - before, UNREAD_MB)
        for each in deaf:
            each.close()

    def test_everything_changes_every_time(self):
        encodings = (("mono8", 1, np.uint8), ("bgr8", 3, np.uint8), ("rgba8", 4, np.uint8), ("mono16", 1, np.uint16),
                     ("bayer_rggb8", 1, np.uint8), ("yuv422", 2, np.uint8), ("32FC1", 1, np.float32))
        random = np.random.RandomState(1)
        for i in range(21):
            encoding, channels, kind = encodings[i % len(encodings)]
            height, width = 2 * random.randint(40, 300, 2)
            pixels = random.randint(0, 256, (height, width, channels)).astype(kind)
            answer = self.client.ask(pixels, self.next_stamp(), encoding=encoding, frame="camera_%d" % i,
                                     info=camera_info(self.stamp, "camera_%d" % i, size=(width, height)))
            bad = encoding == "32FC1"
            self.assertEqual(answer.status, MatchStats.BAD_IMAGE if bad else MatchStats.FIRST_FRAME, answer.status_text)
            self.assertIn("32FC1" if bad else "the frame_id changed", answer.status_text)

    def test_stamps_beyond_what_a_duration_holds(self):
        # The clock is at some 1.8e9 s; a difference of more than 2.1e9 s is none that ros::Duration can hold.
        for stamp in (0.0, 4.2e9, 4.2e9 + 0.1):
            self.client.ask(self.frames[0], stamp)

    def test_camera_that_stops(self):
        silent = "no image arrives on %s, although it has a publisher" % rospy.resolve_name("image")
        of_input = lambda words: [text for name, text in self.reports if "match_filter: input" in name and words in text]
        self.client.wait(lambda: of_input(silent), "the diagnostics to name the silent topic")
        Faults.stamp += 6
        answer = self.client.ask(self.frames[0], self.next_stamp())
        self.assertEqual(answer.status, MatchStats.TIME_RESET, answer.status_text)
        before = len(of_input("images arrive"))
        self.client.wait(lambda: self.assert_good_pair() or len(of_input("images arrive")) > before, "the diagnostics to see images")

    def test_camera_info_that_changes(self):
        zoomed = lambda f: np.array([[f, 0, K[0, 2]], [0, f, K[1, 2]], [0, 0, 1]])
        for focal_length, size, words in ((400, (640, 480), ""), (0, (640, 480), "is not calibrated"), (600, (640, 480), ""),
                                          (float("nan"), (640, 480), "fx is nan"), (700, (640, 480), ""),
                                          (500, (320, 240), "is for 320x240 images"), (500, (640, 480), "")):

            def answered_as_it_should():
                # Image and camera_info travel apart, so the first image may have the camera before.
                for frame in self.frames[:2]:
                    stamp = self.next_stamp()
                    info = camera_info(stamp, k=zoomed(focal_length), size=size)
                    answer = self.client.ask(frame, stamp, info=info)
                pair = self.client.correspondence(stamp)
                if words:
                    return answer.status == MatchStats.UNCALIBRATED and words in answer.status_text and not pair.pose_valid
                return answer.status == MatchStats.OK and pair.K[0] == focal_length

            self.client.wait(answered_as_it_should, "an answer with the focal length %g" % focal_length)

    def test_depth_without_partner(self):
        metres, scene = np.full(self.frames[0].shape, 5, np.float32), Scene()
        self.deep.wait(self.depth.get_num_connections, "the filter to subscribe to depth")
        pid = pid_of("/deep")
        self.assert_good_pair(self.deep)
        before = resident_mb(pid)
        for i in range(LONE):  # no image comes
            self.depth.publish(image_message(metres, self.next_stamp(), encoding="32FC1"))
        for i in range(4):  # of another moment than the image
            stamp = self.next_stamp()
            self.depth.publish(image_message(metres, stamp + 0.04, encoding="32FC1"))
            answer = self.deep.ask(self.frames[i], stamp)
            self.assertEqual(answer.status, MatchStats.OK if i else MatchStats.TIME_RESET, answer.status_text)
            self.assertEqual("no length: no depth image" in answer.status_text, i > 0, answer.status_text)
        self.assertLess(resident_mb(pid) - before, LONE_MB)
        for i in range(2):
            stamp = self.next_stamp()
            self.depth.publish(image_message(scene.depth(STEP * (1 + i)), stamp, encoding="32FC1"))
            answer = self.deep.ask(self.frames[i], stamp)
        self.assertEqual(answer.status, MatchStats.OK, answer.status_text)
        pair = self.deep.correspondence(stamp)
        self.assertTrue(pair.metric_scale, answer.status_text)
        length = np.linalg.norm(vector(pair.current_in_reference.pose.position))
        self.assertLess(abs(length / np.linalg.norm(STEP) - 1), 0.05)

    def test_loop_in_tf(self):
        loop = tf2_msgs.msg.TFMessage()
        for parent, child in (("body", "base"), ("arm", "hand"), ("hand", "arm"), ("hand", "camera")):
            transform = TransformStamped()
            transform.header.frame_id, transform.child_frame_id = parent, child
            transform.header.stamp, transform.transform.rotation.w = rospy.Time(1), 1
            loop.transforms.append(transform)
        tf = rospy.Publisher("/tf", tf2_msgs.msg.TFMessage, queue_size=1, latch=True)
        tf.publish(loop)
        self.client.wait(lambda: self.assert_good_pair(self.based) or self.said_of("tf", "contains a loop"),
                         "the log to name the loop")

    def said_of(self, *words):
        return [text for text in self.said if all(word in text for word in words)]

    def test_reconfigured_all_the_time(self):
        rospy.wait_for_service("match_filter/set_parameters")
        reconfigure = rospy.ServiceProxy("match_filter/set_parameters", Reconfigure, persistent=True)
        # At most half of ~queue_size: every image is answered, on a slow day too.
        stream = Stream(self.client, self.frames, ahead=100 / PATIENCE)
        before = len(self.client.stats)
        stream.start()
        for i in range(RECONFIGURATIONS):
            config = reconfigure(Config(ints=[IntParameter("features", 300 + 100 * (i % 5)),
                                             IntParameter("max_iterations", 2000 + i)])).config
            self.assertIn(("max_iterations", 2000 + i), [(each.name, each.value) for each in config.ints])
        stream.stop()
        reconfigure(Config(ints=[IntParameter("features", 2000), IntParameter("max_iterations", 2000)]))
        sent = before + stream.sent
        self.client.answer(sent)
        Faults.stamp = 1e6

    def test_disk_full_under_rosbag_record(self):
        with tempfile.TemporaryDirectory() as folder:
            # 512-byte blocks: the file may not grow beyond 50 kB, as on a disk that is full.
            recorder = subprocess.Popen(["bash", "-c", "ulimit -f 100; exec rosbag record -b 8 --chunksize=1 -O full "
                                         "/match_filter/match_image __name:=recorder"], cwd=folder)
            topic = "/match_filter/match_image"
            subscribers = lambda: dict(rospy.get_master().getSystemState()[2][1]).get(topic, [])
            self.client.wait(lambda: "/recorder" in subscribers(), "the recorder")
            self.client.wait(lambda: self.client.ask(self.frames[0], self.next_stamp()) and recorder.poll() is not None,
                             "the recorder to fail")


if __name__ == "__main__":
    rospy.init_node("faults_test")
    rostest.rosrun("gms_ransac", "faults", Faults)
