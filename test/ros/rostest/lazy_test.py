#!/usr/bin/env python3
"""Images are subscribed to only while an output has a subscriber; transforms count as one, ~always_subscribe too."""
import unittest

import numpy as np
import rosgraph
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from dynamic_reconfigure.client import Client as Reconfigure
from gms_ransac.msg import MatchStats
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import Image
from std_srvs.srv import SetBool
from tf2_msgs.msg import TFMessage

from graph import TIMEOUT, Client, client_of, rotation_matrix, run, said_by, vector, walk


class Lazy(unittest.TestCase):
    def test_it_says_where_images_are_and_what_is_no_image(self):
        client = Client("lazy_filter", image="elsewhere", info="mistaken_filter/image", listen=False)
        levels, lines, errors = {}, said_by("mistaken_filter"), said_by("mistaken_filter", Log.ERROR)
        reports = []
        diagnostics = rospy.Subscriber("/diagnostics", DiagnosticArray, lambda m: (levels.update(
            {(s.name, s.message): s.level for s in m.status}),
            "mistaken_filter" in m.status[0].name and reports.append(m)))
        # Otherwise the filter may start with an answer of the master from when nobody published yet.
        client.wait(lambda: len(reports) > 3, "reports from after the publishers came")
        del lines[:]
        listener = rospy.Subscriber("mistaken_filter/stats", MatchStats, lambda message: None)

        def said(name, *words):
            return [level for (node, text), level in levels.items() if name in node and all(word in text for word in words)]

        silent = "nobody publishes %s;" % rospy.resolve_name("eager_filter/image")
        client.wait(lambda: said("eager_filter", silent, "images are published on", rospy.resolve_name("elsewhere") + " (image:="),
                    "the topic that has images")
        topic = rospy.resolve_name("mistaken_filter/image")
        client.wait(lambda: said("mistaken_filter", topic + ", which is a sensor_msgs/CameraInfo; it must be a sensor_msgs/Image"),
                    "both types")
        self.assertEqual(set(said("mistaken_filter", "must be a sensor_msgs/Image")), {2})
        client.wait(lambda: any("must be a sensor_msgs/Image" in line for line in errors), "the log to name both types")
        count = len(reports)
        client.wait(lambda: len(reports) > count + 7, "the time in which a silent topic is named")
        self.assertFalse([line for line in lines if "nobody publishes" in line])
        listener.unregister()
        pause = rospy.ServiceProxy("lazy_filter/pause", SetBool)
        pause(True)
        for task in ("input", "matches", "timing"):
            client.wait(lambda: said("lazy_filter: " + task, "paused by ~pause"), "a word on the pause in " + task)
        pause(False)
        diagnostics.unregister()

    def connections(self, client):
        return client.image.get_num_connections()

    def test_no_listener_no_subscription(self):
        client = client_of("lazy_filter", listen=False)
        client_of("eager_filter", listen=False).connect()
        # Offered once it has decided whether to subscribe; the master knows of a subscription from that moment on.
        rospy.wait_for_service("lazy_filter/reset")
        subscriptions = dict(rosgraph.Master(rospy.get_name()).getSystemState()[1])
        self.assertIn(rospy.resolve_name("eager_filter/image"), subscriptions)
        self.assertNotIn(rospy.resolve_name("lazy_filter/image"), subscriptions)

        listener = rospy.Subscriber("lazy_filter/match_image", Image, lambda message: None)
        client.wait(lambda: self.connections(client) == 1, "the subscription that follows a listener")
        listener.unregister()
        client.wait(lambda: self.connections(client) == 0, "the end of the subscription")

        reconfigure = Reconfigure("lazy_filter", timeout=TIMEOUT)
        reconfigure.update_configuration({"publish_relative_tf": True})
        client.wait(lambda: self.connections(client) == 1, "the subscription that follows the transform")
        reconfigure.update_configuration({"publish_relative_tf": False})
        client.wait(lambda: self.connections(client) == 0, "the end of the subscription")

    def test_images_without_a_frame(self):
        client, reports = client_of("nameless_filter"), []
        client.subscribers += [rospy.Subscriber("/tf", TFMessage, lambda message: None),
                               rospy.Subscriber("/diagnostics", DiagnosticArray, lambda m: reports.extend(m.status))]
        client.connect()
        frames = walk(2)

        def said_after_another_image():
            i = len(client.stats)
            client.ask(frames[i % 2], 100 + 0.1 * i, frame="")
            return [s for s in reports if "nameless_filter: graph" in s.name and s.level == 1 and "no frame_id" in s.message]

        client.wait(said_after_another_image, "a word on the missing frame_id")

    def test_transform_is_a_leaf_of_its_own(self):
        client = client_of("eager_filter")
        transforms = []
        client.subscribers.append(rospy.Subscriber("/tf", TFMessage, lambda m: transforms.extend(m.transforms)))
        client.connect()
        for i, frame in enumerate(walk(3)):
            client.ask(frame, 100 + 0.1 * i, frame="/slashed/camera")
        message = client.correspondence(100.2)
        client.wait(lambda: transforms and transforms[-1].header.stamp == message.header.stamp, "the last image's transform")
        for transform in transforms:
            self.assertEqual(transform.header.frame_id, "slashed/camera")
            self.assertEqual(transform.child_frame_id, "slashed/camera_reference")
        self.assertEqual(message.header.frame_id, "slashed/camera")
        self.assertAlmostEqual(message.reference_header.stamp.to_sec(), 100.1, 6)
        pose = message.current_in_reference.pose
        R, inverse = rotation_matrix(pose.orientation), transforms[-1].transform
        self.assertTrue(np.allclose(rotation_matrix(inverse.rotation), R.T, atol=1e-6))
        self.assertTrue(np.allclose(vector(inverse.translation), -R.T @ vector(pose.position), atol=1e-6))


if __name__ == "__main__":
    run("lazy", Lazy, lazy_filter={"publish_relative_tf": False}, eager_filter={}, nameless_filter={}, mistaken_filter={})
