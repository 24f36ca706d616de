#!/usr/bin/env python3
"""Images are subscribed to only while somebody listens; transforms count as a listener, ~always_subscribe too."""
import unittest

import rosgraph
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from dynamic_reconfigure.client import Client as Reconfigure
from sensor_msgs.msg import Image
from tf2_msgs.msg import TFMessage

from graph import Client, Scene


class Lazy(unittest.TestCase):
    def test_a_silent_topic_is_named(self):
        client, said = Client("eager_filter", image="elsewhere", info="elsewhere_info", listen=False), []
        diagnostics = rospy.Subscriber(
            "/diagnostics", DiagnosticArray,
            lambda m: said.extend(s.message for s in m.status if s.name.endswith("input") and "eager_filter" in s.name))
        silent = "nobody publishes %s;" % rospy.resolve_name("eager_image")
        client.wait(lambda: any(silent in text for text in said), "the silent topic's name")
        diagnostics.unregister()
        self.assertNotIn("images arrive", said)

    def connections(self, client):
        return client.image.get_num_connections()

    def test_no_listener_no_subscription(self):
        client = Client("lazy_filter", image="lazy_image", info="lazy_info", listen=False)
        Client("eager_filter", image="eager_image", info="eager_info", listen=False).connect()
        # Offered once it has decided whether to subscribe; the master knows of a subscription from that moment on.
        rospy.wait_for_service("lazy_filter/reset")
        subscriptions = dict(rosgraph.Master(rospy.get_name()).getSystemState()[1])
        self.assertIn(rospy.resolve_name("eager_image"), subscriptions)
        self.assertNotIn(rospy.resolve_name("lazy_image"), subscriptions)

        listener = rospy.Subscriber("lazy_filter/match_image", Image, lambda message: None)
        client.wait(lambda: self.connections(client) == 1, "the subscription that follows a listener")
        listener.unregister()
        client.wait(lambda: self.connections(client) == 0, "the end of the subscription")

        reconfigure = Reconfigure("lazy_filter", timeout=30)
        reconfigure.update_configuration({"publish_relative_tf": True})
        client.wait(lambda: self.connections(client) == 1, "the subscription that follows the transform")
        reconfigure.update_configuration({"publish_relative_tf": False})
        client.wait(lambda: self.connections(client) == 0, "the end of the subscription")

    def test_transform_is_a_leaf_of_its_own(self):
        client = Client("eager_filter", image="eager_image", info="eager_info")
        transforms = []
        client.subscribers.append(rospy.Subscriber("/tf", TFMessage, lambda m: transforms.extend(m.transforms)))
        client.connect()
        scene = Scene()
        for i in range(3):
            client.ask(scene.draw(t=(0.15 * i, 0.05 * i, 0)), 100 + 0.1 * i, frame="/slashed/camera")
        client.wait(lambda: transforms, "a transform")
        for transform in transforms:
            self.assertEqual(transform.header.frame_id, "slashed/camera")
            self.assertEqual(transform.child_frame_id, "slashed/camera_reference")
        message = client.correspondence(100.2)
        self.assertEqual(message.header.frame_id, "slashed/camera")
        self.assertAlmostEqual(message.reference_header.stamp.to_sec(), 100.1, 6)
        # The camera moved right and down, so the reference lies left of it and above.
        self.assertLess(transforms[-1].transform.translation.x, -0.8)
        self.assertLess(transforms[-1].transform.translation.y, -0.1)


if __name__ == "__main__":
    rospy.init_node("lazy_test")
    rostest.rosrun("gms_ransac", "lazy", Lazy)
