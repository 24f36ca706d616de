#!/usr/bin/env python3
"""~mask latched, scaled, refused, and of each image; ~learned_mask."""
import math
import unittest

import numpy as np
import rospy
from gms_ransac.msg import MatchStats
from sensor_msgs.msg import Image

from graph import HEIGHT, WIDTH, Scene, client_of, image_message, run, texture, walk

ASKED = 2000  # ~features


def half_mask(height=HEIGHT, width=WIDTH):
    mask = np.zeros((height, width), np.uint8)
    mask[:, :width // 2] = 1
    return mask


class Mask(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.frames = walk(3)

    def client(self, name):
        client = client_of(name).connect()
        self.start = max([0] + [s.header.stamp.to_sec() for s in client.stats]) + 100
        return client

    def send_mask(self, client, topic, message):
        """Publishes a latched mask, if any, once the filter subscribes to it; returns the publisher."""
        publisher = rospy.Publisher(topic, Image, queue_size=10, latch=True)
        self.addCleanup(publisher.unregister)
        client.wait(publisher.get_num_connections, "the filter to listen to " + topic)
        if message:
            publisher.publish(message)
        return publisher

    def await_mask(self, client, accepted):
        """Sends the same image until an answer shows that the mask has arrived; it comes on a connection of its own."""
        for attempt in range(200):
            answer = client.ask(self.frames[0], self.start + 1e-3 * attempt)
            if accepted(answer):
                return answer
        self.fail("the mask never arrived")

    def test_latched_scaled_and_refused(self):
        client = self.client("latest")
        publisher = self.send_mask(client, "latest/mask", image_message(np.zeros((HEIGHT, WIDTH), np.uint8), 0))
        self.await_mask(client, lambda answer: answer.keypoints_current == 0)
        nothing = client.ask(self.frames[1], self.start + 0.9)
        self.assertEqual(nothing.status, MatchStats.TOO_FEW_KEYPOINTS)
        self.assertIn("the mask leaves 0 % of the image", nothing.status_text)
        publisher.publish(image_message(half_mask(HEIGHT // 4, WIDTH // 4), 0))
        self.start += 10
        self.await_mask(client, lambda answer: answer.keypoints_current > 0)
        for i, frame in enumerate(self.frames):
            answer = client.ask(frame, self.start + 2 + 0.1 * i)
        self.assertEqual(answer.status, MatchStats.OK, answer.status_text)
        self.assertEqual(answer.keypoints_current, ASKED, "all that are asked for come from the rest")
        pair = client.correspondence(self.start + 2.2)
        points = np.reshape(pair.current_points + pair.reference_points, (-1, 2))
        self.assertGreater(len(points), 0.5 * ASKED)
        self.assertLess(points[:, 0].max(), WIDTH / 2)
        publisher.publish(image_message(half_mask(200, 200), 0))
        self.start += 10
        answer = self.await_mask(client, lambda answer: "no mask: the mask is 200x200" in answer.status_text)
        self.assertEqual(answer.keypoints_current, ASKED, "answered all the same")

    def test_of_each_image(self):
        client = self.client("exact")
        publisher = self.send_mask(client, "segmentation", None)
        for i, frame in enumerate(self.frames):
            client.send(frame, 100 + 0.1 * i)
            mask = half_mask() if i % 2 else np.full((HEIGHT, WIDTH), 255, np.uint8)
            publisher.publish(image_message(mask, 100 + 0.1 * i))
        client.answer(3)
        for stamp, half in ((100.1, "current_points"), (100.2, "reference_points")):
            points = np.reshape(getattr(client.correspondence(stamp), half), (-1, 2))
            self.assertLess(points[:, 0].max(), WIDTH / 2)
        client.send(self.frames[0], 100.3)
        client.send(self.frames[1], 100.4)
        publisher.publish(image_message(half_mask(), 100.4))
        skipped, masked = client.answer(4), client.answer(5)
        self.assertIn("no mask: none of its stamp came on ~mask", skipped.status_text)
        self.assertNotIn("no mask", masked.status_text)

    def test_learned_of_what_is_fixed_to_the_camera(self):
        masks, late = [], []
        client = self.client("learning")
        client.subscribe("learned_mask", Image, masks)
        client.connect()
        scene, random = Scene(), np.random.RandomState(1)
        fixed = texture(WIDTH, 99)[:HEIGHT // 4]

        def see(i):
            phase = 0.5 * i
            picture = scene.draw(t=(0.3 * math.cos(phase), 0.2 * math.sin(phase), 0),
                                 r=(0.04 * math.sin(phase), 0.05 * math.cos(phase), 0))
            picture[-HEIGHT // 4:] = np.clip(fixed + random.normal(0, 1, fixed.shape), 0, 255)
            client.ask(picture, self.start + 0.1 * i)

        def pixels(message):
            self.assertEqual((message.encoding, message.header.frame_id), ("mono8", "camera"))
            return np.reshape(np.frombuffer(message.data, np.uint8), (message.height, message.width))

        for i in range(3):
            see(i)
        client.wait(lambda: masks, "a first mask")
        self.assertTrue((pixels(masks[0]) == 255).all(), "nothing is learnt yet")
        for i in range(3, 25):
            see(i)
        client.subscribe("learned_mask", Image, late)
        client.wait(lambda: late, "the latched mask")
        learned = pixels(late[0])
        self.assertEqual(learned.shape, (HEIGHT, WIDTH))
        edge = HEIGHT * 3 // 4
        # But for cells without a keypoint, as those at the border.
        self.assertGreater(np.mean(learned[edge:HEIGHT - HEIGHT // 20] == 0), 0.8)
        self.assertEqual(np.mean(learned[:edge] == 0), 0)


if __name__ == "__main__":
    run("mask", Mask, latest={}, learning={})
