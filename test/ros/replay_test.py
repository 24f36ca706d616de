#!/usr/bin/env python3
"""Real sequences as bags through tum.launch and kitti.launch: every image is answered, with the inliers and the pose
that `evaluate run` finds on the folder, and the same when replayed again."""
import json
import os
import shutil
import subprocess
import tempfile
import threading
import time
import unittest

import numpy as np
import rospkg
import rospy
import rostest
from gms_ransac.msg import Correspondences, MatchStats

from graph import degrees_between, rotation_degrees, rotation_matrix, vector

TIMEOUT = 120.0  # seconds of wall time for a replay, start of the launch file included
SETTINGS = "{method: fast, features: 2000, seed: 3, hold_reference: false}"


def data_folder(name):
    """The folder of a real sequence, or None: most machines have none."""
    source = os.path.realpath(rospkg.RosPack().get_path("gms_ransac"))
    for root in (os.environ.get("GMS_RANSAC_DATA"), os.path.join(source, "..", "shared", "data")):
        if root and os.path.isdir(os.path.join(root, name)):
            return os.path.join(root, name)
    return None


class Replay(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="gms_ransac_replay_")
        self.addCleanup(shutil.rmtree, self.folder)

    def replay(self, launch, bag, count):
        """Returns ([stats], {stamp: correspondences}) of the launch file's replay of `count` images."""
        stats, correspondences, changed = [], {}, threading.Condition()

        def on_stats(message):
            with changed:
                stats.append(message)
                changed.notify_all()

        def on_correspondences(message):
            with changed:
                correspondences[message.header.stamp.to_nsec()] = message
                changed.notify_all()

        subscribers = [rospy.Subscriber("/match_filter/stats", MatchStats, on_stats, queue_size=1000),
                       rospy.Subscriber("/match_filter/correspondences", Correspondences, on_correspondences, queue_size=1000)]
        settings = os.path.join(self.folder, "settings.yaml")
        with open(settings, "w") as out:
            out.write(SETTINGS)
        process = subprocess.Popen(["roslaunch", "gms_ransac", launch, "bag:=" + bag, "rviz:=false", "drop_frames:=false",
                                    "delay:=5", "parameters:=" + settings])
        try:
            with changed:
                end = time.monotonic() + TIMEOUT
                done = lambda: len(stats) >= count and len(correspondences) >= count - 1
                while not done() and time.monotonic() < end:
                    changed.wait(0.2)
        finally:
            process.terminate()
            process.wait()
            for subscriber in subscribers:
                subscriber.unregister()
        self.assertEqual(len(stats), count, "every image is answered")
        self.assertEqual(stats[-1].frames_dropped, 0)
        return stats, correspondences

    def check(self, name, images, launch):
        data = data_folder(name)
        if data is None:
            self.skipTest("%s is not here (GMS_RANSAC_DATA, ../shared/data)" % name)
        count = len([f for f in os.listdir(os.path.join(data, images)) if f.endswith(".png")])
        bag, records = os.path.join(self.folder, name + ".bag"), os.path.join(self.folder, "records.jsonl")
        subprocess.check_call(["rosrun", "gms_ransac", "dataset_to_bag", data, bag])
        subprocess.check_call(["rosrun", "gms_ransac", "evaluate", "run", data, "--method", "fast", "--features", "2000",
                               "--seed", "3", "--extractor", rospy.get_param("~extractor", "opencv"), "--out", records])
        with open(records) as lines:
            expected = [json.loads(line) for line in lines]
        self.assertEqual(len(expected), count - 1)

        stats, answers = self.replay(launch, bag, count)
        answers = [answers[stamp] for stamp in sorted(answers)]
        self.assertEqual(len(answers), len(expected))
        for i, (answer, record, stat) in enumerate(zip(answers, expected, stats[1:])):
            where = "%s, pair %d (%s)" % (name, i, stat.status_text)
            self.assertEqual(MatchStatus[stat.status], record["status"], where)
            self.assertEqual(stat.inliers, record["inliers"], where)
            mine = np.column_stack([np.reshape(answer.reference_points, (-1, 2)), np.reshape(answer.current_points, (-1, 2))])
            theirs = np.array(record["correspondences"])[:, :4] if record["correspondences"] else np.zeros((0, 4))
            self.assertTrue(np.allclose(mine, theirs, atol=1e-3), where)
            if not answer.pose_valid:
                continue
            pose = answer.current_in_reference.pose
            R = np.reshape(record["R"], (3, 3))
            self.assertLess(rotation_degrees(R.T @ rotation_matrix(pose.orientation)), 1e-4, where)
            if stat.status == MatchStats.OK:
                self.assertLess(degrees_between(vector(pose.position), np.array(record["t"])), 1e-3, where)

        again = self.replay(launch, bag, count)[1]
        for answer in answers:
            other = again[answer.header.stamp.to_nsec()]
            self.assertEqual(answer.current_points, other.current_points)
            self.assertEqual(answer.current_in_reference, other.current_in_reference)

    def test_kitti(self):
        self.check("kitti_06", "image_0", "kitti.launch")

    def test_tum(self):
        self.check("tum_fr1_desk", "rgb", "tum.launch")


MatchStatus = {value: name for name, value in vars(MatchStats).items() if name.isupper() and isinstance(value, int)}

if __name__ == "__main__":
    rospy.init_node("replay_test")
    rostest.rosrun("gms_ransac", "replay", Replay)
