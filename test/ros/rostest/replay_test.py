#!/usr/bin/env python3
"""Real sequences as bags through tum.launch and kitti.launch: every image is answered, with the inliers and the pose
that `evaluate run` finds on the folder, and the same when replayed again, with one thread or two. Bags that do not fit."""
import json
import os
import shutil
import socket
import subprocess
import tempfile
import time
import unittest

import numpy as np
import rosbag
import rospy
import rostest
from gms_ransac.msg import MatchStats

from graph import (PATIENCE, Client, camera_info, data_folder, degrees_between, image_message, linger,
                   rotation_degrees, rotation_matrix, said_by, vector, walk)

TIMEOUT = 120.0 * PATIENCE  # seconds of wall time for a replay, start of the launch file included
KITTI_IMAGES = 8 if PATIENCE > 1 else None  # of a sanitized build: a second each
SETTINGS = "method: lo_prosac, features: 2000, seed: 3, hold_reference: false"


class Replay(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="gms_ransac_replay_")
        self.addCleanup(shutil.rmtree, self.folder)

    def replay(self, launch, bag, count, settings="", rate=1, arguments=()):
        """Returns ([stats], {stamp: correspondences}) of the launch file's replay of `count` images. A node that is slower
        than usual gets them as much more slowly, or its queue would overflow."""
        client = Client(image="nobody_reads", camera=False)
        settings_file = os.path.join(self.folder, "settings.yaml")
        with open(settings_file, "w") as out:
            out.write("{%s%s}" % (SETTINGS, settings))
        process = subprocess.Popen(["roslaunch", "gms_ransac", launch, "bag:=" + bag, "rviz:=false", "drop_frames:=false",
                                    "await:=/match_filter/stats /match_filter/correspondences",
                                    "parameters:=" + settings_file, "rate:=%g" % (rate / PATIENCE), *arguments])
        try:
            end = time.monotonic() + TIMEOUT
            while (len(client.stats) < count or len(client.correspondences) < count - 1) and time.monotonic() < end:
                time.sleep(0.2)
        finally:
            process.terminate()
            process.wait()
            for each in client.subscribers + [client.image]:
                each.unregister()
        self.assertGreaterEqual(len(client.stats), count, "every image is answered")
        self.assertEqual(client.stats[-1].frames_dropped, 0)
        return client.stats, {answer.header.stamp.to_nsec(): answer for answer in client.correspondences}

    def sequence(self, name):
        """The folder of a real sequence; skips the test without it."""
        return data_folder(name) or self.skipTest("%s is not here (GMS_RANSAC_DATA, ../shared/data)" % name)

    def kitti(self, count, *cameras):
        """A folder with the first images of the KITTI sequence (None: all), of these cameras."""
        data, folder = self.sequence("kitti_06"), os.path.join(self.folder, "kitti")
        os.mkdir(folder)
        shutil.copy(os.path.join(data, "calib.txt"), folder)
        for camera in cameras:
            os.mkdir(os.path.join(folder, camera))
            for name in sorted(os.listdir(os.path.join(data, camera)))[:count]:
                os.symlink(os.path.join(data, camera, name), os.path.join(folder, camera, name))
        return folder

    def check(self, data, images, launch):
        name, bag = os.path.basename(data), os.path.join(self.folder, "sequence.bag")
        count = len([f for f in os.listdir(os.path.join(data, images)) if f.endswith(".png")])
        subprocess.check_call(["rosrun", "gms_ransac", "dataset_to_bag", data, bag, "--camera-info", "folder"])
        linger(bag)
        records = os.path.join(self.folder, "records.jsonl")
        subprocess.check_call(["rosrun", "gms_ransac", "evaluate", "run", data, "--method", "lo_prosac", "--features", "2000",
                               "--seed", "3", "--extractor", rospy.get_param("~extractor", "simd_orb"), "--out", records])
        with open(records) as lines:
            expected = [json.loads(line) for line in lines]
        self.assertEqual(len(expected), count - 1)

        stats, answers = self.replay(launch, bag, count)
        self.assertEqual(len(stats), count)
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

        for settings in ("", ", threads: 2", ", threads: 4"):
            again = self.replay(launch, bag, count, settings, 4)[1]
            for answer in answers:
                other = again[answer.header.stamp.to_nsec()]
                self.assertEqual(answer.current_points, other.current_points, settings)
                self.assertEqual(answer.current_in_reference, other.current_in_reference, settings)

    def test_kitti(self):
        self.check(self.kitti(KITTI_IMAGES, "image_0"), "image_0", "kitti.launch")

    def test_tum(self):
        self.check(self.sequence("tum_fr1_desk"), "rgb", "tum.launch")

    def drawn_bag(self, name, image_topic, info_topic, k=None):
        """A bag of three images of the drawn scene."""
        path = os.path.join(self.folder, name)
        with rosbag.Bag(path, "w") as bag:
            for i, frame in enumerate(walk(3)):
                image = image_message(frame, 100 + 0.1 * i)
                bag.write(info_topic, camera_info(100 + 0.1 * i, k=k), image.header.stamp)
                bag.write(image_topic, image, image.header.stamp)
        return linger(path)

    def test_nothing_is_left_of_the_launch_before(self):
        """TUM, whose calibration is a set of parameters, and then KITTI, whose camera_info counts, on one master."""
        tum = self.drawn_bag("desk.bag", "/camera/rgb/image_color", "/camera/rgb/camera_info")
        kitti = self.drawn_bag("drive.bag", "/kitti/camera_gray_left/image_raw", "/kitti/camera_gray_left/camera_info")
        rospy.set_param("/match_filter/max_iterations", 7)
        answers = self.replay("tum.launch", tum, 3, arguments=["calibration:=1"])[1]
        self.assertEqual({answer.K[0] for answer in answers.values()}, {517.306408})
        self.assertEqual(rospy.get_param("/match_filter/max_iterations"), 2000)
        answers = self.replay("kitti.launch", kitti, 3)[1]
        self.assertEqual({answer.K[0] for answer in answers.values()}, {500.0})
        self.assertFalse(rospy.has_param("/match_filter/camera"))
        self.assertIs(rospy.get_param("/match_filter/publish_odom_tf"), True, "what the launch file sets stays")

    def test_a_bag_that_holds_other_images_is_refused_with_the_arguments_that_read_it(self):
        self.drawn_bag("drive.bag", "/kitti/camera_gray_left/image_rect", "/kitti/camera_gray_left/camera_info")
        self.drawn_bag("desk.bag", "/camera/rgb/image_color", "/camera/rgb/camera_info")
        launches = []
        for launch, arguments, remedy in (
                ("kitti.launch", ["bag:=drive.bag", "variant:=raw"],
                 "/kitti/camera_gray_left/image_rect (kitti.launch camera:=gray_left variant:=odom)"),
                ("kitti.launch", ["bag:=drive.bag", "variant:=odometry"],
                 "variant is 'odometry'; it must be raw, odom or empty"),
                ("kitti.launch", ["bag:=desk.bag"], "/camera/rgb/image_color (tum.launch)"),
                ("kitti.launch", ["bag:=drive.bag", "variant:=odom", "stereo:=true"],
                 "no messages on /kitti/camera_gray_right/image_rect, the images of the right camera; leave stereo:=true out"),
                ("tum.launch", ["bag:=desk.bag", "scale:=depth"],
                 "no messages on /camera/depth/image, which scale:=depth reads; leave scale:=depth out"),
                ("tum.launch", ["bag:=desk.bag", "rviz:=true"], "rviz needs a display and there is none: give rviz:=false"),
                ("tum.launch", ["bag:=nowhere.bag"], "there is no file %s/nowhere.bag" % self.folder)):
            with socket.socket() as free:  # a master each: they run side by side
                free.bind(("localhost", 0))
                master = "http://localhost:%d" % free.getsockname()[1]
            environment = dict(os.environ, PWD=self.folder, ROS_MASTER_URI=master)
            environment.pop("DISPLAY", None)
            launches.append((remedy, subprocess.Popen(
                ["roslaunch", "gms_ransac", launch, "rviz:=false", *arguments], cwd=self.folder, env=environment,
                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)))
        for remedy, process in launches:
            self.assertIn(remedy, process.communicate(timeout=TIMEOUT)[0])

    def test_the_end_of_the_bag_is_said_on_the_screen(self):
        bag = self.drawn_bag("desk.bag", "/camera/rgb/image_color", "/camera/rgb/camera_info")
        process = subprocess.Popen(["roslaunch", "gms_ransac", "tum.launch", "bag:=" + bag, "rviz:=false"],
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.terminate)
        self.assertTrue(any("the bag has ended; the graph goes on" in line for line in process.stdout))

    def test_two_cameras_of_a_kitti_folder_give_metres_and_so_does_the_ground(self):
        count = 4
        folder, bag = self.kitti(count, "image_0", "image_1"), os.path.join(self.folder, "short.bag")
        said = subprocess.check_output(["rosrun", "gms_ransac", "dataset_to_bag", folder, bag], text=True)
        self.assertIn("the right camera is 0.537", said)
        self.assertIn("kitti.launch variant:=odom camera:=gray_left bag:=%s stereo:=true" % bag, said)
        linger(bag)
        for metres in ("stereo:=true", "scale:=ground"):
            stats, answers = self.replay("kitti.launch", bag, count,
                                         arguments=["variant:=odom", "camera:=gray_left", metres])
            self.assertEqual([s.status for s in stats], [MatchStats.FIRST_FRAME] + [MatchStats.OK] * (count - 1))
            for each in stats[1:]:
                self.assertNotIn("no length", each.status_text)
            self.assertTrue(all(answer.metric_scale for answer in answers.values()), metres)

    def test_camera_info_counts_whatever_the_name_of_the_bag(self):
        """A calibration is used as it is; the factory's values are named, with the choice."""
        log = said_by()
        bag = self.drawn_bag("rgbd_dataset_freiburg1_desk.bag", "/camera/rgb/image_color", "/camera/rgb/camera_info")
        answers = self.replay("tum.launch", bag, 3)[1]
        self.assertEqual({answer.K[0] for answer in answers.values()}, {500.0})
        named = lambda: [line for line in log if "factory values" in line and "tum.launch calibration:=1, 2 or 3" in line]
        self.assertEqual(named(), [])
        bag = self.drawn_bag("desk.bag", "/camera/rgb/image_color", "/camera/rgb/camera_info",
                             k=[[525, 0, 319.5], [0, 525, 239.5], [0, 0, 1]])
        answers = self.replay("tum.launch", bag, 3)[1]
        self.assertEqual({answer.K[0] for answer in answers.values()}, {525.0})
        self.assertTrue(named(), log)

    def test_no_image_is_lost_before_the_node_listens(self):
        """Images follow their camera_info's as they were recorded, the first one before any."""
        path, frames, count = os.path.join(self.folder, "early.bag"), walk(4), 20
        with rosbag.Bag(path, "w") as bag:
            for i in range(count):
                image = image_message(frames[(0, 1, 2, 3, 2, 1)[i % 6]], 100 + 0.05 * i)
                bag.write("/camera/image", image, image.header.stamp)
                bag.write("/camera/camera_info", camera_info(100 + 0.05 * i), image.header.stamp + rospy.Duration(0.001))
                bag.write("/elsewhere", camera_info(100 + 0.05 * i), image.header.stamp)
        stats = self.replay("replay.launch", linger(path), count, arguments=["image:=/camera/image"])[0]
        self.assertEqual(stats[-1].frames_received, count)
        statuses = [s.status for s in stats]
        self.assertEqual(statuses[0], MatchStats.FIRST_FRAME)
        # Where the walk reverses, a pair may have no direction.
        self.assertLessEqual(set(statuses[1:]), {MatchStats.OK, MatchStats.LOW_PARALLAX})
        self.assertGreater(statuses.count(MatchStats.OK), 0.75 * count)



MatchStatus = {value: name for name, value in vars(MatchStats).items() if name.isupper() and isinstance(value, int)}

if __name__ == "__main__":
    rospy.init_node("replay_test")
    rostest.rosrun("gms_ransac", "replay", Replay)
