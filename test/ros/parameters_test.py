#!/usr/bin/env python3
"""Wrong parameters are refused with a sentence, unknown ones warned about, and good ones changed while running."""
import subprocess
import unittest

import rospy
import rostest
from dynamic_reconfigure.client import Client as Reconfigure
from gms_ransac.msg import MatchStats

from graph import Client, Scene

TIMEOUT = 60  # seconds


class Parameters(unittest.TestCase):
    def start(self, *settings):
        """Runs a node until it gives up; returns (exit status, what it said)."""
        done = subprocess.run(["rosrun", "gms_ransac", "match_filter_node", "__name:=refused"] + list(settings),
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=TIMEOUT)
        for setting in settings:
            rospy.delete_param("refused/" + setting.split(":=")[0][1:])
        return done.returncode, done.stdout

    def assert_refused(self, setting, *words):
        status, said = self.start(setting)
        self.assertEqual(status, 2, said)
        for word in words:
            self.assertIn(word, said)

    def test_number_out_of_range(self):
        self.assert_refused("_features:=0", "/refused/features", "'0'", "between 1 and 100000")

    def test_fraction_out_of_range(self):
        self.assert_refused("_confidence:=1.5", "/refused/confidence", "1.5", "between 0.5 and")

    def test_word_for_a_number(self):
        self.assert_refused("_max_iterations:=many", "/refused/max_iterations", "'many'", "whole number")

    def test_unknown_method(self):
        self.assert_refused("_method:=magic", "unknown method 'magic'", "cp_ransac")

    def test_unknown_choice(self):
        self.assert_refused("_camera_info_sync:=sometimes", "/refused/camera_info_sync", "'sometimes'", "'exact'")

    def test_queue_size(self):
        self.assert_refused("_queue_size:=0", "/refused/queue_size", "between 1 and 10000")

    def test_half_a_camera(self):
        self.assert_refused("_camera/fx:=500.0", "camera/", "is missing")

    def test_misspelt_parameter(self):
        process = subprocess.Popen(["rosrun", "gms_ransac", "match_filter_node", "__name:=misspelt", "_featuers:=100"],
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        try:
            for line in process.stdout:
                if "featuers" in line:
                    self.assertIn("not known", line)
                    break
            else:
                self.fail("nothing was said")
        finally:
            process.terminate()
            process.wait()

    def test_change_while_running(self):
        client = Client("running", "running/image", "running/camera_info").connect()
        scene = Scene()
        frames = [scene.draw(t=(0.15 * i, 0.05 * i, 0)) for i in range(4)]
        reconfigure = Reconfigure("running", timeout=TIMEOUT)
        client.ask(frames[0], 100.0)
        self.assertGreater(client.ask(frames[1], 100.1).keypoints_current, 1000)
        reconfigure.update_configuration({"features": 500, "publish_rejected": True})
        answer = client.ask(frames[2], 100.2)
        self.assertLessEqual(answer.keypoints_current, 500)
        message = client.correspondence(100.2)
        self.assertEqual(len(message.stage), len(message.confidence))
        self.assertEqual(list(message.stage).count(2), answer.inliers)

        clamped = reconfigure.update_configuration({"confidence": 1.5, "max_iterations": 0})
        self.assertEqual((clamped["confidence"], clamped["max_iterations"]), (0.99999, 1), "the nearest value allowed")
        reconfigure.update_configuration({"confidence": 0.99, "max_iterations": 2000})

        refused = reconfigure.update_configuration({"method": "magic", "features": 700})
        self.assertEqual((refused["method"], refused["features"]), ("fast", 500), "the old parameters stay")
        answer = client.ask(frames[3], 100.3)
        self.assertEqual(answer.status, MatchStats.OK, answer.status_text)


if __name__ == "__main__":
    rospy.init_node("parameters_test")
    rostest.rosrun("gms_ransac", "parameters", Parameters)
