#!/usr/bin/env python3
"""The relay to RTAB-Map: features of RGBDImage, and the covariance that RTAB-Map takes for that of a motion."""
import os
import struct
import sys
import unittest
import zlib

import numpy as np
import rospkg
import rospy
from gms_ransac.msg import Keypoints, MatchStats
from nav_msgs.msg import Odometry
from rtabmap_msgs.msg import RGBDImage
from sensor_msgs.msg import Image

from graph import STEP, Client, K, Scene, image_message, run

sys.path.insert(0, os.path.join(rospkg.RosPack().get_path("gms_ransac"), "examples"))
import rtabmap_relay


class Rtabmap(unittest.TestCase):
    def test_the_covariance_of_a_motion_is_what_it_added(self):
        """Chains uncertain steps; each one's covariance is found again, and those of two steps add up."""
        random = np.random.RandomState(3)
        p, R, C = np.zeros(3), np.eye(3), np.zeros((6, 6))
        poses, added = [(p, R, C)], []
        for _ in range(3):
            step, spread = random.normal(size=3), random.normal(size=(6, 6)) * 0.01
            Q = spread @ spread.T  # in odometry axes
            carry = np.eye(6)
            carry[:3, 3:] = np.cross(step, np.eye(3))  # an error w of the rotation moves the end by w x step
            p, C = p + step, carry @ C @ carry.T + Q
            R = np.linalg.qr(random.normal(size=(3, 3)))[0]
            R *= np.linalg.det(R)
            to_frame = np.kron(np.eye(2), R.T)
            poses.append((p, R, C))
            added.append(to_frame @ Q @ to_frame.T)
        for before, now, Q in zip(poses, poses[1:], added):
            np.testing.assert_allclose(rtabmap_relay.motion_covariance(before, now), Q, atol=1e-8)
        both = rtabmap_relay.motion_covariance(poses[0], poses[2])
        to_frame = np.kron(np.eye(2), poses[2][1].T)
        np.testing.assert_allclose(both, to_frame @ poses[2][2] @ to_frame.T, atol=1e-8)
        # After a return to an earlier place the pose may be known better than before; the motion is never without error.
        self.assertGreater(np.linalg.eigvalsh(rtabmap_relay.motion_covariance(poses[2], poses[0]))[0], 0)

    def test_a_motion_there_and_back_is_as_uncertain_as_its_steps(self):
        """An error of scale cancels on the way back: the pose is exact again, and the motion to it is not."""
        step, sigma, seconds = 0.1, 0.01, 0.05
        odometry = Odometry()
        odometry.twist.covariance = (np.diag([1, 0, 0, 0, 0, 0]) * (sigma * step / seconds) ** 2).ravel().tolist()
        poses = [(np.array([x, 0, 0]), np.eye(3), np.diag([(sigma * x) ** 2, 0, 0, 0, 0, 0]))
                 for x in step * np.array([0, 1, 2, 3, 4, 3, 2, 1, 0])]
        motion = np.zeros((6, 6))
        for before, now in zip(poses, poses[1:]):
            motion = rtabmap_relay.continued(motion, before, now, odometry, seconds)
        np.testing.assert_allclose(motion[0, 0], 8 * (sigma * step) ** 2)
        self.assertLess(rtabmap_relay.motion_covariance(poses[4], poses[8])[0, 0], 1e-8)
        # Where the velocity is unknown, what the pose's covariance grew by.
        odometry.twist.covariance = (1000 * np.eye(6)).ravel().tolist()
        np.testing.assert_allclose(rtabmap_relay.continued(np.zeros((6, 6)), poses[1], poses[2], odometry, seconds),
                                   rtabmap_relay.motion_covariance(poses[1], poses[2]))

    def test_a_motion_is_turned_and_carried_along(self):
        """A certain step: an earlier error of the rotation moves its end."""
        turn = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])  # about z, by a quarter
        before = np.zeros(3), np.eye(3), np.zeros((6, 6))
        now = np.array([2.0, 0, 0]), turn, np.zeros((6, 6))
        motion = rtabmap_relay.continued(np.diag([0, 0, 0, 0, 0, 1e-4]), before, now, Odometry(), 0.1)
        # An error w about z moves the end by 2 w along y, which is x of the later axes.
        np.testing.assert_allclose(motion[np.ix_([0, 5], [0, 5])], 1e-4 * np.array([[4, 2], [2, 1]]), atol=1e-12)
        self.assertAlmostEqual(np.trace(motion), 5e-4)

    def test_images_features_and_odometry(self):
        client, scene, keypoints, odometry = Client(), Scene(), [], []
        images, relayed = [], []
        client.subscribe("keypoints", Keypoints, keypoints)
        client.subscribe("odom", Odometry, odometry)
        client.subscribers += [rospy.Subscriber("rgbd_image", RGBDImage, images.append, queue_size=50),
                               rospy.Subscriber("odom_rtabmap", Odometry, relayed.append, queue_size=50)]
        depth = rospy.Publisher("depth/image", Image, queue_size=50)
        client.connect()
        # Both the filter and the relay.
        client.wait(lambda: min(p.get_num_connections() for p in (client.image, client.info, depth)) == 2, "the relay")
        metres, places = [], [STEP * min(i, 4) for i in range(7)]  # it stands still at the end
        for i, place in enumerate(places):
            metres.append(scene.depth(place) * np.float32(1 + 1e-5 * i))  # no image is a copy of another
            metres[i][:100] = np.nan
            depth.publish(image_message(metres[i], 100 + 0.1 * i, encoding="32FC1"))
            answer = client.ask(scene.draw(t=place), 100 + 0.1 * i)
            self.assertIn(answer.status, (MatchStats.FIRST_FRAME, MatchStats.OK, MatchStats.LOW_PARALLAX), answer.status_text)
        client.wait(lambda: len(images) == len(relayed) == 4, "every second image")
        self.assertEqual([round(10 * m.header.stamp.to_sec()) - 1000 for m in images], [0, 2, 4, 6])
        self.assertEqual([m.header.stamp for m in images], [m.header.stamp for m in relayed])
        source = {m.header.stamp: m for m in keypoints}
        for i, message in enumerate(images):
            pixels = np.array([(k.pt.x, k.pt.y) for k in message.key_points])
            points = np.array([(p.x, p.y, p.z) for p in message.points])
            self.assertEqual(len(points), len(source[message.header.stamp].u))
            known = np.isfinite(points[:, 2])
            self.assertGreater(known.sum(), 300)
            self.assertFalse(known[pixels[:, 1] < 90].any())
            projected = points[known] @ K.T
            np.testing.assert_allclose(projected[:, :2] / projected[:, 2:], pixels[known], atol=1e-3)
            at = np.round(pixels[known]).astype(int)
            off = points[known, 2] / metres[2 * i][at[:, 1], at[:, 0]] - 1
            self.assertLess(np.median(np.abs(off)), 1e-3)
            rows, columns, kind = struct.unpack("<3i", message.descriptors[-12:])
            self.assertEqual((rows, columns, kind), (len(points), 32, 0))
            self.assertEqual(zlib.decompress(message.descriptors[:-12]), source[message.header.stamp].descriptors)
            self.assertEqual(message.depth.header.stamp, message.rgb.header.stamp)
            self.assertEqual(message.rgb_camera_info.K, tuple(K.ravel()))
        # A velocity that is not known has a variance of 1000; the place is known all the same.
        unknown = [m for m in odometry if m.twist.covariance[0] > 100]
        self.assertTrue(unknown)
        for message in relayed[1:]:
            covariance = np.reshape(message.twist.covariance, (6, 6))
            np.testing.assert_allclose(covariance, covariance.T, atol=1e-12)
            self.assertLess(np.linalg.eigvalsh(covariance)[-1], 0.1)


if __name__ == "__main__":
    run("rtabmap", Rtabmap)
