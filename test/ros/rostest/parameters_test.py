#!/usr/bin/env python3
"""Wrong parameters are refused with a sentence, unknown ones warned about, and good ones changed while running."""
import ast
import subprocess
import unittest

import roslib.packages
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from dynamic_reconfigure.client import Client as Reconfigure
from gms_ransac.msg import MatchStats

from graph import TIMEOUT, client_of, run, said_by, wait_for, walk


class Parameters(unittest.TestCase):
    def test_wrong_types_and_values_of_every_kind(self):
        """Each by a node of its own, all at the same time."""
        node = roslib.packages.find_node("gms_ransac", "match_filter_node")[0]
        pinhole = {"fx": 500.0, "fy": 500.0, "cx": 320.0, "cy": 240.0}
        refused = [  # all that is set, the parameter that is named, the words of the refusal
            ({"features": 1000.5}, "features", "whole number"),
            ({"success_probability": float("nan")}, "success_probability", "a number between"),
            ({"inlier_threshold_px": [1.0]}, "inlier_threshold_px", "between 0.001 and 100 pixels, or 0"),
            ({"lan_mutual": 2}, "lan_mutual", "true or false, and this is a number"),
            ({"method": 5}, "method", "'cp_ransac'"),
            ({"sort_key": "taste"}, "sort_key", "'' 'score' 'relative_score'"),
            ({"queue_size": "ten"}, "queue_size", "a whole number between 1 and 10000, and this is a text"),
            ({"drop_frames": "perhaps"}, "drop_frames", "true or false, and this is a text"),
            ({"fixed_scale": {"x": 1}}, "fixed_scale", "and this is a structure"),
            ({"scale": 3}, "scale", "one of 'unit'"),
            ({"image_transport": 7}, "image_transport", "the name of an image transport"),
            ({"odom_frame": 5}, "odom_frame", "a frame"),
            ({"camera": dict(pinhole, fx="wide")}, "camera/fx", "a number between"),
            ({"camera": {"fx": 500.0}}, "camera", "is missing"),
            ({"camera": {"k1": 0.1, "fy": 500.0}}, "camera", "camera/fx is missing"),
            ({"camera": pinhole, "input": "stereo"}, "camera", "both are described by their camera_info"),
            ({"input": "stereo", "scale": "depth"}, "scale", "it must be unit, the default, with ~input stereo"),
            ({"input": "pair", "scale": "ground", "camera_height": 1.5}, "scale", "it must be unit or fixed with ~input pair"),
            ({"input": "pair", "camera_info_sync": "exact"}, "camera_info_sync", "it must be 'latest' with"),
            ({"rotation_prior": "tf"}, "prior_frame", "the fixed frame in which tf knows the camera"),
            ({"scale": "ground"}, "camera_height", "in metres, with ~scale ground"),
            ({"mask_file": "/nowhere/mask.png"}, "", "~mask_file is '/nowhere/mask.png'; it must be the path of an image"),
        ]
        nodes = []
        for i, (values, _, _) in enumerate(refused):
            rospy.set_param("refused_%d" % i, values)
            nodes.append(subprocess.Popen([node, "__name:=refused_%d" % i], stdout=subprocess.PIPE,
                                          stderr=subprocess.STDOUT, text=True))
        wrong = []
        for i, (process, (values, named, words)) in enumerate(zip(nodes, refused)):
            said = process.communicate(timeout=TIMEOUT)[0]
            if process.returncode != 2 or named and "/refused_%d/%s" % (i, named) not in said or words not in said:
                wrong.append("%s: exit status %d, %s" % (values, process.returncode, said))
            rospy.delete_param("refused_%d" % i)
        self.assertEqual(wrong, [])

    def test_whole_numbers_are_numbers(self):
        """YAML's 1 is as good as 1.0 where any number is wanted. What has no effect is named, unless it is the default."""
        for name, value in (("inlier_threshold_px", 2), ("max_frame_gap", 2), ("fixed_scale", 3), ("diagnostic_period", 2),
                            ("featuers", 100), ("imu_frame", "imu"), ("camera_height", 1.5), ("prior_frame", ""), ("camera", {"fx": 500, "fy": 500, "cx": 320, "cy": 240})):
            rospy.set_param("whole/" + name, value)
        process = subprocess.Popen(["stdbuf", "-oL", "rosrun", "gms_ransac", "match_filter_node", "__name:=whole"],
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        try:
            rospy.wait_for_service("whole/reset", TIMEOUT)
            self.assertEqual(rospy.get_param("whole/max_frame_gap"), 2)
        finally:
            process.terminate()
            said = process.communicate()[0]
        first = next(line for line in said.splitlines() if "subscribes to" in line)
        for setting in ("~input stream", "~scale unit", "~method lo_prosac", "~max_frame_gap 2", "~fixed_scale 3"):
            self.assertIn(setting + ",", first.replace(";", ","), "what decides, and what is not at its default")
        for usual in ("~features", "~prior_frame", "~drop_frames"):
            self.assertNotIn(usual, first)
        without_effect = sorted(line.split("parameter ")[1].split("\x1b")[0] for line in said.splitlines() if "is set, but" in line)
        self.assertEqual(without_effect, [
            "/whole/camera_height is set, but has no effect without ~scale ground",
            "/whole/featuers is set, but this node has no such parameter; check the spelling",
            "/whole/fixed_scale is set, but has no effect without ~scale fixed",
            "/whole/imu_frame is set, but has no effect without ~rotation_prior imu"])

    def test_what_yaml_reads_otherwise_is_taken(self):
        """4e-05, as the documents write it, is a text to YAML. The server then has the type that rqt_reconfigure reads."""
        given = {"rotation_sigma_floor": ("4e-05", 4e-05), "features": (1500.0, 1500), "max_iterations": ("500", 500),
                 "hold_reference": ("false", False), "refine": (0, False)}
        for name, (value, _) in given.items():
            rospy.set_param("otherwise/" + name, value)
        process = subprocess.Popen(["rosrun", "gms_ransac", "match_filter_node", "__name:=otherwise"])
        try:
            rospy.wait_for_service("otherwise/reset", TIMEOUT)
            in_force = Reconfigure("otherwise", timeout=TIMEOUT).get_configuration()
            for name, (_, typed) in given.items():
                value = rospy.get_param("otherwise/" + name)
                self.assertEqual((value, type(value)), (typed, type(typed)), name)
                self.assertEqual(in_force.get(name, typed), typed, name)
        finally:
            process.terminate()
            process.wait()

    def test_every_choice_is_taken(self):
        """As the menu has it: dynamic_reconfigure writes it for rqt_reconfigure as a Python literal."""
        reconfigure = Reconfigure("running", timeout=TIMEOUT)
        choices = {described["name"]: [constant["value"] for constant in ast.literal_eval(described["edit_method"])["enum"]]
                   for described in reconfigure.get_parameter_descriptions() if described["edit_method"]}
        self.assertLessEqual({"method", "model", "search"}, set(choices))
        defaults = reconfigure.get_configuration()
        for name, words in choices.items():
            for word in words:
                self.assertEqual(reconfigure.update_configuration({name: word})[name], word)
            reconfigure.update_configuration({name: defaults[name]})

    def test_change_while_running(self):
        client, said = client_of("running").connect(), said_by("running")
        frames = walk(4)
        reconfigure = Reconfigure("running", timeout=TIMEOUT)
        client.ask(frames[0], 100.0)
        self.assertGreater(client.ask(frames[1], 100.1).keypoints_current, 1000)
        rospy.set_param("running/max_iterations", 7)  # a mark: what does not change is not written, one call of the master each
        reconfigure.update_configuration({"features": 500, "publish_rejected": True})
        self.assertEqual([rospy.get_param("running/" + name) for name in ("features", "publish_rejected", "max_iterations")],
                         [500, True, 7])
        changed = "/running: changed ~features 2000 -> 500, ~publish_rejected false -> true"
        client.wait(lambda: changed in said, changed)
        answer = client.ask(frames[2], 100.2)
        self.assertLessEqual(answer.keypoints_current, 500)
        message = client.correspondence(100.2)
        self.assertEqual(len(message.stage), len(message.confidence))
        self.assertEqual(list(message.stage).count(2), answer.inliers)

        for refused, words in (
                ({"success_probability": 1.5, "features": 600},
                 "~success_probability is '1.5'; it must be a number between 0.01 and 0.999999999"),
                ({"max_iterations": 0}, "~max_iterations is '0'; it must be a whole number between 1 and 1000000"),
                ({"inlier_threshold_px": float("nan")}, "~inlier_threshold_px is 'nan'"),
                ({"method": "magic", "features": 700}, "~method is 'magic'; it must be one of ")):
            answer = reconfigure.update_configuration(refused)
            self.assertEqual([answer[name] for name in ("success_probability", "max_iterations", "inlier_threshold_px", "method",
                                                        "features")], [0.99, 2000, 0, "lo_prosac", 500], "the old ones stay")
            client.wait(lambda: any(words in line for line in said), words)
        answer = client.ask(frames[3], 100.3)
        self.assertEqual(answer.status, MatchStats.OK, answer.status_text)

    def test_period_of_diagnostics(self):
        often, seldom = [], []
        subscriber = rospy.Subscriber("/diagnostics", DiagnosticArray, lambda message: (
            often if "often" in message.status[0].name else seldom if "seldom" in message.status[0].name else []).append(message))
        for each in ("often", "seldom"):
            rospy.wait_for_service(each + "/reset", TIMEOUT)
        wait_for(lambda: len(often) > 25, "a message every 0.2 s")
        self.assertEqual(len(seldom), 0, "a message a day")
        subscriber.unregister()


if __name__ == "__main__":
    run("parameters", Parameters, running={}, often={"diagnostic_period": 0.2}, seldom={"diagnostic_period": 86400})
