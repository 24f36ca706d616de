#!/usr/bin/env python3
"""~features: the layouts of VINS-Mono, VINS-Fusion and LVI-SAM, the rate, and tracks that span images without a message."""
import unittest

import numpy as np
import rospy
from gms_ransac.msg import MatchStats
from sensor_msgs.msg import Image, PointCloud

from graph import HEIGHT, Scene, WIDTH, client_of, image_message, run

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

    def client(self, name, **options):
        """A client, and the list that its features go to."""
        client, clouds = client_of(name, **options), []
        client.subscribe("features", PointCloud, clouds)
        return client.connect(), clouds

    def send(self, client, clouds, frames, start, period):
        """The answers to the frames, and the messages of features that came with them, with the last one at least."""
        answers = [client.ask(frame, start + period * i) for i, frame in enumerate(frames)]
        client.wait(lambda: clouds and clouds[-1].header.stamp == answers[-1].header.stamp, "features of the last image")
        return answers, [c for c in clouds if c.header.stamp.to_sec() >= start]

    def test_vins_fusion(self):
        client, clouds = self.client("fusion")
        answers, clouds = self.send(client, clouds, self.frames, 100, 0.1)
        self.assertEqual(answers[-1].status, MatchStats.OK, answers[-1].status_text)
        self.assertGreaterEqual(len(clouds), 4)
        self.assertEqual(ids_that_came_back(clouds), 0)
        for cloud in clouds:
            self.assertEqual([c.name for c in cloud.channels],
                             ["id", "camera_id", "u", "v", "velocity_x", "velocity_y", "gx", "gy", "gz"])
            columns = columns_of(cloud)
            self.assertEqual({len(values) for values in columns.values()}, {len(cloud.points)})
            self.assertTrue(100 < len(cloud.points) <= 220, "~feature_limit")
            pixels = np.column_stack([columns["u"], columns["v"]])
            # Where the pairs follow it, too, it is the same point.
            pair = client.correspondence(cloud.header.stamp.to_sec())
            keypoints = dict(zip(pair.track_id, np.reshape(pair.current_points, (-1, 2))))
            off = [np.linalg.norm(keypoints[i] - p) for i, p in zip(columns["id"], pixels) if i in keypoints]
            self.assertGreater(len(off), 50)
            self.assertLess(np.median(off), 1)

    def test_lvi_sam(self):
        depth = rospy.Publisher("lvi/depth/image", Image, queue_size=10)
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
            columns, rays, known = columns_of(after), rays_of(after), rays_of(before)
            seconds = (after.header.stamp - before.header.stamp).to_sec()
            for i, x, y in zip(columns["id"], columns["velocity_x"], columns["velocity_y"]):
                if i in known:
                    self.assertTrue(np.allclose((x, y), (rays[i] - known[i]) / seconds, atol=1e-3))
        self.assertGreater(answers[-1].track_length_median, 2)
        self.assertGreaterEqual(answers[-1].track_length_p90, answers[-1].track_length_median)
        self.assertGreater(answers[-1].feature_age_p90, 0.5)
        self.assertGreater(answers[-1].feature_age_median, 0.2)

    def test_images_between_two_messages_are_passed_over(self):
        """While no other output has a subscriber."""
        client, clouds = self.client("alone", listen=False)
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


if __name__ == "__main__":
    always = {"always_subscribe": True}
    run("features", Features, mono=always, alone=always, fusion=dict(always, feature_layout="vins_fusion"),
        lvi=dict(always, feature_layout="lvi_sam", scale="depth"))
