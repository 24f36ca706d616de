#!/usr/bin/env python3
"""A transport other than raw: the same answers, the overlay too, and one sentence where it is not installed."""
import signal
import subprocess
import unittest

import cv2
import numpy as np
import rospy
from gms_ransac.msg import MatchStats
from nodelet.srv import NodeletList, NodeletLoad, NodeletLoadRequest, NodeletUnload
from sensor_msgs.msg import CompressedImage, Image

from graph import TIMEOUT, Stream, client_of, image_message, run, walk


class Compressing:
    """Stands for a publisher of images that sends them as PNG."""

    def __init__(self, topic, transport="test_png", kind=".png"):
        self.publisher = rospy.Publisher(topic + "/" + transport, CompressedImage, queue_size=200)
        self.kind = kind
        self.get_num_connections = self.publisher.get_num_connections

    def publish(self, image):
        pixels = np.frombuffer(image.data, np.uint16 if image.encoding == "16UC1" else np.uint8)
        message = CompressedImage(header=image.header, format=image.encoding)
        message.data = cv2.imencode(self.kind, pixels.reshape(image.height, image.width))[1].tobytes()
        self.publisher.publish(message)


class Transport(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.frames = walk(3)
        cls.depth = np.full(cls.frames[0].shape, 5000, np.uint16)  # millimetres; plausible is enough

    def answers(self, name, *transport):
        client = client_of(name)
        if transport:
            client.image = Compressing(name + "/image", *transport)
        client.connect()
        for i, frame in enumerate(self.frames):
            answer = client.ask(frame, 100 + 0.1 * i)
        self.assertEqual(answer.status, MatchStats.OK, answer.status_text)
        return [client.correspondence(100 + 0.1 * i) for i in (1, 2)]

    def test_same_answers_as_raw(self):
        for raw, png in zip(self.answers("raw"), self.answers("png", "test_png")):
            self.assertGreater(len(raw.confidence), 100)
            self.assertEqual(raw, png)

    def test_jpeg_and_png_need_no_transport(self):
        for raw, png in zip(self.answers("raw_again"), self.answers("packed", "compressed", ".png")):
            self.assertGreater(len(raw.confidence), 100)
            self.assertEqual(raw, png)
        for jpg in self.answers("jpg", "compressed", ".jpg"):
            self.assertGreater(len(jpg.confidence), 100)

    def test_what_is_no_picture_is_named(self):
        client = client_of("broken")
        client.image = Compressing("broken/image", "compressed")
        client.image.publish = lambda image: client.image.publisher.publish(
            CompressedImage(header=image.header, format="mono8; webm compressed", data=b"not a picture"))
        client.connect()
        answer = client.ask(self.frames[0], 200)
        self.assertEqual(answer.status, MatchStats.BAD_IMAGE)
        self.assertIn("cannot be decoded (format 'mono8; webm compressed', 13 bytes)", answer.status_text)

    def test_depth_has_a_transport_of_its_own(self):
        lengths = []
        for name in ("raw_depth", "png_depth"):
            client, topic = client_of(name), name + "/depth/image"
            depth = Compressing(topic) if name == "png_depth" else rospy.Publisher(topic, Image, queue_size=10)
            client.connect().wait(depth.get_num_connections, "the filter to subscribe to depth")
            for i in range(2):
                stamp = 100 + 0.1 * i
                depth.publish(image_message(self.depth, stamp, encoding="16UC1"))
                answer = client.ask(self.frames[i], stamp)
            self.assertEqual(answer.status, MatchStats.OK, answer.status_text)
            message = client.correspondence(100.1)
            self.assertTrue(message.metric_scale, name)
            lengths.append(message.current_in_reference)
        self.assertEqual(lengths[0], lengths[1])

    def test_the_overlay_goes_out_through_it(self):
        client = client_of("raw")
        raw, png = [], []
        client.subscribe("match_image", Image, raw)
        client.subscribe("match_image/test_png", CompressedImage, png)
        client.connect()
        for i in range(2):
            client.ask(self.frames[i], 200 + 0.1 * i)
        client.wait(lambda: len(raw) == 2 and len(png) == 2, "overlays")
        sent = np.frombuffer(raw[1].data, np.uint8).reshape(raw[1].height, raw[1].width, 3)
        self.assertTrue(np.array_equal(cv2.imdecode(np.frombuffer(png[1].data, np.uint8), cv2.IMREAD_COLOR), sent))

    def test_a_transport_that_is_not_installed_is_refused(self):
        for name, transport, words in (
                ("image_transport", "theora", "ros-noetic-theora-image-transport"),
                ("image_transport", "magic", "check the spelling"),
                ("depth_image_transport", "compressedDepth", "ros-noetic-compressed-depth-image-transport")):
            command = ["rosrun", "gms_ransac", "match_filter_node", "__name:=refused", "_%s:=%s" % (name, transport)]
            command += ["_scale:=depth"] if name.startswith("depth") else []
            done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=TIMEOUT)
            rospy.delete_param("refused")
            self.assertEqual(done.returncode, 2, done.stdout)
            for part in ("/refused/%s is '%s'" % (name, transport), "'raw'", "'test_png'", words):
                self.assertIn(part, done.stdout)
            self.assertEqual(len(done.stdout.strip().splitlines()), 1, done.stdout)

    def streamed(self, name):
        """A client that keeps sending PNG and has had answers."""
        client = client_of(name)
        client.image = Compressing(name + "/image")
        stream = Stream(client, self.frames)
        stream.start()
        self.addCleanup(stream.stop)
        client.wait(lambda: any(m.status == MatchStats.OK for m in client.stats), "an answer of " + name)
        return client

    def test_unloaded_while_images_flow(self):
        load = rospy.ServiceProxy("lone_manager/load_nodelet", NodeletLoad)
        unload = rospy.ServiceProxy("lone_manager/unload_nodelet", NodeletUnload)
        rospy.set_param("passing", {"image_transport": "test_png"})
        request = NodeletLoadRequest(name="/passing", type="gms_ransac/MatchFilter")
        request.remap_source_args = ["image", "camera_info"]
        request.remap_target_args = ["/passing/image", "/passing/camera_info"]
        client = None
        for threads in (1, 2, 3, 4):
            rospy.set_param("passing/threads", threads)
            self.assertTrue(load(request).success)
            client = client or self.streamed("passing")
            before = len(client.stats)
            client.wait(lambda: any(m.status == MatchStats.OK for m in client.stats[before:]), "an answer")
            self.assertTrue(unload(name="/passing").success)
            self.assertEqual(rospy.ServiceProxy("lone_manager/list", NodeletList)().nodelets, [])

    def test_interrupted_while_images_flow(self):
        for threads in (1, 2):
            name = "interrupted_%d" % threads
            process = subprocess.Popen(["rosrun", "gms_ransac", "match_filter_node", "__name:=" + name,
                                        "image:=%s/image" % name, "camera_info:=%s/camera_info" % name,
                                        "_image_transport:=test_png", "_threads:=%d" % threads])
            self.addCleanup(process.kill)
            self.streamed(name)
            process.send_signal(signal.SIGINT)
            self.assertEqual(process.wait(TIMEOUT), 0)

    def test_the_manager_survives_it(self):
        rospy.set_param("lost/image_transport", "theora")
        load = rospy.ServiceProxy("manager/load_nodelet", NodeletLoad)
        with self.assertRaises(rospy.ServiceException):
            load(NodeletLoadRequest(name="/lost", type="gms_ransac/MatchFilter"))
        nodelets = rospy.ServiceProxy("manager/list", NodeletList)().nodelets
        self.assertEqual(set(nodelets), {"/png", "/png_depth"})


if __name__ == "__main__":
    run("transport", Transport, raw={}, raw_depth={"scale": "depth"}, raw_again={}, jpg={"image_transport": "compressed"},
        packed={"image_transport": "compressed"}, broken={"image_transport": "compressed"})
