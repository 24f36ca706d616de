#!/usr/bin/env python3
"""~features: the layouts of VINS-Mono, VINS-Fusion and LVI-SAM, the rate, and tracks that outlive images of no use."""
import unittest

import numpy as np
import rospy
import rostest
from gms_ransac.msg import MatchStats
from sensor_msgs.msg import Image, PointCloud

from graph import Client, HEIGHT, K, Scene, WIDTH, image_message

STEP = np.array((0.15, 0.05, 0.0))


def columns_of(cloud):
    return {channel.name: np.array(channel.values) for channel in cloud.channels}


def rays_of(cloud):
    return {i: np.array((p.x, p.y)) for i, p in zip(cloud.channels[0].values, cloud.points)}


def ids_that_came_back(clouds):
    """How many features were in an earlier message, but not in the one before."""
    ever, last, count = set(), set(), 0
    for cloud in clouds:
        ids = set(cloud.channels[0].values)
        count += len((ids & ever) - last)
        ever, last = ever | ids, ids
    return count


def share_kept(before, after):
    ids = set(before.channels[0].values)
    return len(ids & set(after.channels[0].values)) / len(ids)


class Features(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scene = Scene()
        cls.frames = [cls.scene.draw(t=STEP * i) for i in range(5)]

    def client(self, name):
        """A client, and the list that its features go to."""
        client, clouds = Client(name, name + "/image", name + "/camera_info"), []
        client.subscribe("features", PointCloud, clouds)
        return client.connect(), clouds

    def send(self, client, clouds, frames, start, period):
        """The answers to the frames, and the messages of features that came with them, with the last one at least."""
        answers = [client.ask(frame, start + period * i) for i, frame in enumerate(frames)]
        client.wait(lambda: clouds and clouds[-1].header.stamp == answers[-1].header.stamp, "features of the last image")
        return answers, [c for c in clouds if c.header.stamp.to_sec() >= start]

    def check_velocities(self, clouds):
        """Of what was in the message before; a feature that is new has that of its pair."""
        for before, after in zip(clouds, clouds[1:]):
            columns, rays, known = columns_of(after), rays_of(after), rays_of(before)
            seconds = (after.header.stamp - before.header.stamp).to_sec()
            for i, x, y in zip(columns["id"], columns["velocity_x"], columns["velocity_y"]):
                if i in known:
                    self.assertTrue(np.allclose((x, y), (rays[i] - known[i]) / seconds, atol=1e-3))

    def check_layout(self, name, names, start):
        client, clouds = self.client(name)
        answers, clouds = self.send(client, clouds, self.frames, start, 0.1)
        self.assertEqual(answers[-1].status, MatchStats.OK, answers[-1].status_text)
        self.assertGreaterEqual(len(clouds), 4)
        self.assertEqual(ids_that_came_back(clouds), 0)
        for cloud in clouds:
            self.assertEqual([c.name for c in cloud.channels], names)
            columns = columns_of(cloud)
            for values in columns.values():
                self.assertEqual(len(values), len(cloud.points))
            pixels = np.column_stack([columns["u"], columns["v"]])
            self.assertTrue(100 < len(pixels) <= 220, "~feature_limit")
            apart = np.linalg.norm(pixels[:, None] - pixels, axis=2) + 1e3 * np.eye(len(pixels))
            self.assertGreaterEqual(apart.min(), 15, "~feature_distance")
            points = np.array([(p.x, p.y, p.z) for p in cloud.points])
            self.assertTrue(np.all(points[:, 2] == 1), "VINS-Mono stops when z is not exactly 1")
            self.assertTrue(np.allclose(points[:, :2], (pixels - K[:2, 2]) / K[0, 0], atol=1e-5))
            # Where the pairs follow it, too, it is the same point.
            pair = client.correspondence(cloud.header.stamp.to_sec())
            keypoints = dict(zip(pair.track_id, np.reshape(pair.current_points, (-1, 2))))
            off = [np.linalg.norm(keypoints[i] - p) for i, p in zip(columns["id"], pixels) if i in keypoints]
            self.assertGreater(len(off), 50)
            self.assertLess(max(off), 3.1)
            self.assertLess(np.median(off), 1)
        self.check_velocities(clouds)
        return clouds

    def test_vins_fusion(self):
        names = ["id", "camera_id", "u", "v", "velocity_x", "velocity_y", "gx", "gy", "gz"]
        clouds = self.check_layout("fusion", names, 100)
        self.assertEqual(set(columns_of(clouds[-1])["camera_id"]), {0.0})

    def test_lvi_sam(self):
        depth = rospy.Publisher("lvi/depth", Image, queue_size=10)
        client, clouds = self.client("lvi")
        client.wait(depth.get_num_connections, "the filter to subscribe to depth")
        for i, frame in enumerate(self.frames):
            # Depth of the left half alone; 3 m everywhere, as it is not compared with the images.
            metres = np.full((HEIGHT, WIDTH), np.nan, np.float32)
            metres[:, :WIDTH // 2] = 3
            depth.publish(image_message(metres, 100 + 0.1 * i, encoding="32FC1"))
            client.send(frame, 100 + 0.1 * i)
        client.wait(lambda: len(clouds) == len(self.frames) - 1, "features of every pair")
        for cloud in clouds:
            self.assertEqual([c.name for c in cloud.channels], ["id", "u", "v", "velocity_x", "velocity_y", "depth"])
            columns = columns_of(cloud)
            left = np.rint(columns["u"]) < WIDTH // 2
            self.assertTrue(20 < np.count_nonzero(left) < len(left) - 20)
            self.assertEqual(set(columns["depth"][left]), {3.0})
            self.assertEqual(set(columns["depth"][~left]), {-1.0}, "not known")

    def test_the_rate_and_tracks_that_span_it(self):
        client, clouds = self.client("mono")
        frames = [self.scene.draw(t=0.2 * STEP * i) for i in range(20)]
        answers, clouds = self.send(client, clouds, frames, 200, 0.04)  # 25 Hz
        stamps = [c.header.stamp.to_sec() - 200 for c in clouds]
        self.assertTrue(np.allclose(stamps, [0.04, 0.16, 0.24, 0.36, 0.44, 0.56, 0.64, 0.76], atol=1e-3), stamps)
        self.assertEqual(ids_that_came_back(clouds), 0)
        for before, after in zip(clouds, clouds[1:]):
            self.assertGreater(share_kept(before, after), 0.85)
        self.check_velocities(clouds)
        self.assertGreater(answers[-1].track_length_median, 2)
        self.assertGreaterEqual(answers[-1].track_length_p90, answers[-1].track_length_median)
        self.assertGreater(answers[-1].feature_age_p90, 0.5)
        self.assertGreater(answers[-1].feature_age_median, 0.2)

    def test_images_between_two_messages_are_passed_over(self):
        """While no other output has a subscriber."""
        client, clouds = Client("alone", "alone/image", "alone/camera_info", listen=False), []
        client.subscribe("features", PointCloud, clouds)
        client.connect()
        for i in range(10):
            client.send(self.scene.draw(t=0.2 * STEP * i), 100 + 0.05 * i)
        client.wait(lambda: len(clouds) == 5, "features of every second image")
        self.assertEqual([round((c.header.stamp.to_sec() - 100) / 0.05) for c in clouds], [1, 3, 5, 7, 9])
        self.assertEqual(ids_that_came_back(clouds), 0)
        self.assertGreater(share_kept(clouds[0], clouds[-1]), 0.7)
        client.listen()
        client.connect()
        for i in range(10, 13):
            answer = client.ask(self.scene.draw(t=0.2 * STEP * i), 100 + 0.05 * i)
            self.assertEqual((answer.frames_received, answer.frames_processed, answer.frames_passed_over), (i + 1, i - 3, 4))

    def test_every_image_while_the_reference_is_held(self):
        """Turning on the spot, in noise that hides a keypoint now and then."""
        client, clouds = self.client("every")
        noise = np.random.RandomState(0)
        frames = [self.scene.draw(r=(0, 0.002 * i, 0)) + noise.normal(0, 8, self.frames[0].shape) for i in range(20)]
        answers, clouds = self.send(client, clouds, [np.clip(f, 0, 255).astype(np.uint8) for f in frames], 100, 0.04)
        self.assertEqual(answers[-1].status, MatchStats.LOW_PARALLAX, answers[-1].status_text)
        self.assertEqual(len(clouds), len(frames) - 1)
        self.assertLess(len({m.reference_header.stamp for m in client.correspondences}), 8, "the reference is held")
        self.assertEqual(ids_that_came_back(clouds), 0)
        self.assertGreater(share_kept(clouds[0], clouds[-1]), 0.7)
        self.check_velocities(clouds)

    def test_images_of_no_use_end_no_track(self):
        """One is dark, one shows something else, so that two pairs fail."""
        client, clouds = self.client("every")
        foreign = np.random.RandomState(1).randint(0, 256, (HEIGHT, WIDTH)).astype(np.uint8)
        frames = [self.scene.draw(t=0.2 * STEP * i) for i in range(8)]
        frames[3], frames[5] = np.zeros_like(frames[3]), foreign
        answers, clouds = self.send(client, clouds, frames, 300, 0.05)
        self.assertEqual(answers[3].status, MatchStats.TOO_FEW_KEYPOINTS)
        for i in (5, 6):
            self.assertNotIn(answers[i].status, (MatchStats.OK, MatchStats.LOW_PARALLAX), answers[i].status_text)
        self.assertEqual([round((c.header.stamp.to_sec() - 300) / 0.05) for c in clouds], [1, 2, 4, 6, 7])
        self.assertEqual(ids_that_came_back(clouds), 0)
        self.assertGreater(share_kept(clouds[1], clouds[-1]), 0.6)
        self.check_velocities(clouds)


if __name__ == "__main__":
    rospy.init_node("features_test")
    rostest.rosrun("gms_ransac", "features", Features)
