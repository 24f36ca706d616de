#!/usr/bin/env python3
"""Images that are not rectified: the pose is right, and both example subscribers find the points where they are."""
import re
import unittest

import cv2
import numpy as np
import rospy
from gms_ransac.msg import Correspondences, MatchStats
from std_srvs.srv import Trigger

from graph import HEIGHT, K, WIDTH, Client, Scene, camera_info, degrees_between, run, said_by, vector

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
    x, y = rays_of_pixels(model, np.stack([columns, rows], -1)).T.reshape(2, HEIGHT, WIDTH)
    map_x, map_y = (K[0, 0] * x + K[0, 2]).astype(np.float32), (K[1, 1] * y + K[1, 2]).astype(np.float32)
    return cv2.remap(picture, map_x, map_y, cv2.INTER_LINEAR)


class Distorted(unittest.TestCase):
    def test_the_pose_and_both_examples(self):
        scene, client = Scene(), Client().connect()
        said = {example: said_by(example) for example in ("in_cpp", "in_python")}
        client.wait(lambda: client.info.get_num_connections() == 3, "the filter and both examples to subscribe")
        for k, model in enumerate(MODELS):
            self.check(scene, client, model, 100 + k, said)
            self.assertTrue(rospy.ServiceProxy("match_filter/reset", Trigger)().success)

    def check(self, scene, client, model, start, said):
        info = camera_info(start, d=MODELS[model])
        info.distortion_model = model
        for i in range(2):
            info.header.stamp = rospy.Time.from_sec(start + 0.1 * i)
            answer = client.ask(distort(model, scene.draw(t=STEP * i)), start + 0.1 * i, info=info)
        self.assertEqual(answer.status, MatchStats.OK, answer.status_text)
        message = client.correspondence(start + 0.1)
        self.assertEqual(message.pixel_space, Correspondences.PIXELS_RAW)
        self.assertLess(degrees_between(vector(message.current_in_reference.pose.position), STEP), 1.5)

        # Where the points are: the nearest board that each ray of the current image meets, in multiples of the step.
        xy = rays_of_pixels(model, message.current_points)
        depth = np.full(len(xy), np.inf)
        for z, left, top, side in scene.boards:
            at = xy * z + STEP[:2]
            hit = np.all((at > (left, top)) & (at < (left + side, top + side)), 1)
            depth[hit] = np.minimum(depth[hit], z)
        truth = (np.c_[xy, np.ones(len(xy))] * depth[:, None]).mean(0) / np.linalg.norm(STEP)
        for example, lines in said.items():
            text = client.wait(lambda: [line for line in lines if "centre" in line], example)[-1]
            lines.clear()
            used, found = (int(number) for number in re.findall(r"^(\d+) points of (\d+)", text)[0])
            self.assertEqual(found, len(xy), text)
            self.assertGreater(used, 0.95 * found, text)
            centre = np.array(re.findall(r"-?\d+\.\d*", text.split("centre")[1]), float)
            self.assertLess(np.linalg.norm(centre - truth), 0.04 * np.linalg.norm(truth), "%s: %s" % (text, truth))


if __name__ == "__main__":
    run("distorted", Distorted)
