#!/usr/bin/env python3
"""Images that are not rectified: the pose is right, and both example subscribers find the points where they are."""
import re
import unittest

import cv2
import numpy as np
import rospy
import rostest
from gms_ransac.msg import Correspondences, MatchStats
from rosgraph_msgs.msg import Log

from graph import HEIGHT, K, WIDTH, Client, Scene, camera_info, degrees_between, vector

STEP = np.array((0.3, 0.1, 0.0))
MODELS = {"plumb_bob": (-0.3, 0.12, 0.001, -0.001, 0.0), "equidistant": (-0.02, 0.01, -0.003, 0.001)}


def rays_of_pixels(model, pixels):
    """N x 2, normalised."""
    pixels, D = np.asarray(pixels, np.float64).reshape(-1, 1, 2), np.array(MODELS[model])
    if model == "equidistant":
        return cv2.fisheye.undistortPoints(pixels, K, D).reshape(-1, 2)
    return cv2.undistortPointsIter(pixels, K, D, None, None, (3, 100, 1e-10)).reshape(-1, 2)


def distort(model, picture):
    columns, rows = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
    x, y = rays_of_pixels(model, np.stack([columns, rows], -1)).T.reshape(2, HEIGHT, WIDTH).astype(np.float32)
    return cv2.remap(picture, K[0, 0] * x + float(K[0, 2]), K[1, 1] * y + float(K[1, 2]), cv2.INTER_LINEAR)


class Distorted(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scene = Scene()

    def check(self, model):
        ns = "/%s/" % model
        client = Client(ns + "match_filter", ns + "image", ns + "camera_info")
        lines = []

        def keep(message):
            with client.changed:
                lines.append((message.name, message.msg))
                client.changed.notify_all()

        client.subscribers.append(rospy.Subscriber("/rosout", Log, keep))
        client.connect()
        filter_publisher_peers = 3  # this test and the two examples
        client.wait(lambda: client.info.get_num_connections() == filter_publisher_peers, "the examples to subscribe")
        info = camera_info(100.0, d=MODELS[model])
        info.distortion_model = model
        for i in range(2):
            info.header.stamp = rospy.Time.from_sec(100 + 0.1 * i)
            answer = client.ask(distort(model, self.scene.draw(t=STEP * i)), 100 + 0.1 * i, info=info)
        self.assertEqual(answer.status, MatchStats.OK, answer.status_text)
        message = client.correspondence(100.1)
        self.assertEqual(message.pixel_space, Correspondences.PIXELS_RAW)
        self.assertLess(degrees_between(vector(message.current_in_reference.pose.position), STEP), 1.5)

        # Where the points are: the nearest board that each ray of the current image meets, in multiples of the step.
        xy = rays_of_pixels(model, message.current_points)
        depth = np.full(len(xy), np.inf)
        for z, left, top, side in self.scene.boards:
            at = xy * z + STEP[:2]
            hit = np.all((at > (left, top)) & (at < (left + side, top + side)), 1)
            depth[hit] = np.minimum(depth[hit], z)
        truth = (np.c_[xy, np.ones(len(xy))] * depth[:, None]).mean(0) / np.linalg.norm(STEP)
        for example in ("in_cpp", "in_python"):
            said = lambda: [m for name, m in lines if name.startswith(ns + example) and "centre" in m]
            text = client.wait(said, ns + example)[-1]
            used, found = (int(number) for number in re.findall(r"^(\d+) points of (\d+)", text)[0])
            self.assertEqual(found, len(xy), text)
            self.assertGreater(used, 0.95 * found, text)
            centre = np.array(re.findall(r"-?\d+\.\d*", text.split("centre")[1]), float)
            self.assertLess(np.linalg.norm(centre - truth), 0.04 * np.linalg.norm(truth), "%s: %s" % (text, truth))

    def test_plumb_bob(self):
        self.check("plumb_bob")

    def test_equidistant(self):
        self.check("equidistant")


if __name__ == "__main__":
    rospy.init_node("distorted_test")
    rostest.rosrun("gms_ransac", "distorted", Distorted)
