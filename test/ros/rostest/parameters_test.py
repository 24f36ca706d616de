#!/usr/bin/env python3
"""Wrong parameters are refused with a sentence, unknown ones warned about, and good ones changed while running."""
import ast
import contextlib
import subprocess
import time
import unittest

import roslib.packages
import rospkg
import rospy
import rostest
import yaml
from dynamic_reconfigure.client import Client as Reconfigure
from gms_ransac.msg import MatchStats
from rosgraph_msgs.msg import Log

from graph import Client, Scene

TIMEOUT = 60  # seconds


class Parameters(unittest.TestCase):
    def test_wrong_types_and_values_of_every_kind(self):
        """Each by a node of its own, all at the same time."""
        node = roslib.packages.find_node("gms_ransac", "match_filter_node")[0]
        refused = [
            ("features", 1000.5, "whole number"), ("features", "many", "whole number"),
            ("success_probability", float("nan"), "a number between"),
            ("inlier_threshold_px", float("inf"), "between 0.001 and 100 pixels, or 0"),
            ("inlier_threshold_px", [1.0], "a number between"), ("gms_grid_columns", 1, "between 2 and 100, or 0"),
            ("lan_mutual", 1, "true or false"), ("method", 5, "'cp_ransac'"), ("method", "", "one of"),
            ("sort_key", "taste", "'' 'score' 'relative_score'"), ("feature_limit", -1, "between 0 and 100000"),
            ("queue_size", "ten", "whole number"), ("drop_frames", "no", "true or false"), ("scale", 3, "one of 'unit'"),
            ("image_transport", 7, "the name of an image transport"),
            ("fixed_scale", float("nan"), "between 1e-06 and 1000000 metres"),
            ("odom_frame", 5, "a frame"), ("input_is_rectified", "maybe", "'auto' 'true' 'false'"),
            ("camera", {"fx": "wide", "fy": 500.0, "cx": 320.0, "cy": 240.0}, "a number between"),
            ("camera", {"fx": -500.0, "fy": 500.0, "cx": 320.0, "cy": 240.0}, "between 0.001 and"),
            ("camera", {"fx": 500.0}, "is missing"), ("mask_sync", "always", "'always'; it must be one of 'latest' 'exact'"),
            ("mask_file", "/nowhere/mask.png", "is '/nowhere/mask.png'; it must be the path of an image"),
        ]
        nodes = []
        for i, (name, value, words) in enumerate(refused):
            rospy.set_param("refused_%d/%s" % (i, name), value)
            nodes.append(subprocess.Popen([node, "__name:=refused_%d" % i], stdout=subprocess.PIPE,
                                          stderr=subprocess.STDOUT, text=True))
        wrong = []
        for i, (process, (name, value, words)) in enumerate(zip(nodes, refused)):
            said = process.communicate(timeout=TIMEOUT)[0]
            named = "~mask_file" if name == "mask_file" else "/refused_%d/%s" % (i, name)
            if process.returncode != 2 or named not in said or words not in said:
                wrong.append("%s: %r: exit status %d, %s" % (name, value, process.returncode, said))
            rospy.delete_param("refused_%d" % i)
        self.assertEqual(wrong, [])

    def test_whole_numbers_are_numbers(self):
        """YAML's 1 is as good as 1.0 where any number is wanted."""
        for name, value in (("inlier_threshold_px", 2), ("max_frame_gap", 2), ("fixed_scale", 3), ("diagnostic_period", 2),
                            ("featuers", 100), ("camera", {"fx": 500, "fy": 500, "cx": 320, "cy": 240})):
            rospy.set_param("whole/" + name, value)
        process = subprocess.Popen(["rosrun", "gms_ransac", "match_filter_node", "__name:=whole"],
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        try:
            rospy.wait_for_service("whole/reset", TIMEOUT)
            self.assertEqual(rospy.get_param("whole/max_frame_gap"), 2)
        finally:
            process.terminate()
            said = process.communicate()[0]
        unknown = [line for line in said.splitlines() if "is set, but this node has no such parameter" in line]
        self.assertEqual(len(unknown), 1, said)
        self.assertIn("/whole/featuers", unknown[0])

    @contextlib.contextmanager
    def said(self):
        """The lines that the node `running` logs."""
        lines = []
        subscriber = rospy.Subscriber(
            "/rosout", Log, lambda message: lines.append(message.msg) if message.name == "/running" else None)
        try:
            deadline = time.monotonic() + TIMEOUT
            while not subscriber.get_num_connections() and time.monotonic() < deadline:
                rospy.rostime.wallsleep(0.05)
            yield lines
        finally:
            subscriber.unregister()

    def test_the_documents_list_every_parameter(self):
        package = rospkg.RosPack().get_path("gms_ransac")
        with open(package + "/cfg/match_filter.yaml") as yaml_file:
            documented = yaml.safe_load(yaml_file)
        with open(package + "/doc/parameters.md") as readme:
            rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in readme if line.startswith("| `~")]
        table = {name.strip("`~"): row for row in rows for name in row[0].split(", ")}
        for described in Reconfigure("running", timeout=TIMEOUT).get_parameter_descriptions():
            name = described["name"]
            self.assertEqual(documented.pop(name, "not in the YAML"), described["default"], name)
            self.assertIn(name, table, "not in doc/parameters.md")
            self.assertEqual(table[name][1].strip('"').lower(), str(described["default"]).lower(), name)
            self.assertEqual(table[name][3], described["description"], name)
        for name in documented:  # those that are fixed at start
            self.assertIn(name, table, "not in doc/parameters.md")

    def test_every_choice_says_what_cfg_offers(self):
        """Against the menu as Python reads it: dynamic_reconfigure writes it for rqt_reconfigure as a literal."""
        client, reconfigure = Client("running", listen=False), Reconfigure("running", timeout=TIMEOUT)
        choices = {described["name"]: [constant["value"] for constant in ast.literal_eval(described["edit_method"])["enum"]]
                   for described in reconfigure.get_parameter_descriptions() if described["edit_method"]}
        self.assertLessEqual({"method", "model", "search"}, set(choices))
        evaluate = subprocess.check_output(["rosrun", "gms_ransac", "evaluate", "--list"], text=True)
        for method in choices["method"]:
            self.assertIn(method, evaluate.splitlines())
        defaults = reconfigure.get_configuration()
        with self.said() as said:
            for name, words in choices.items():
                for word in words:
                    self.assertEqual(reconfigure.update_configuration({name: word})[name], word)
                reconfigure.update_configuration({name: defaults[name]})
                reconfigure.update_configuration({name: "magic"})
                sentence = "~%s is 'magic'; it must be one of %s" % (name, " ".join("'%s'" % word for word in words))
                client.wait(lambda: any(line.endswith(sentence) for line in said), sentence)

    def test_change_while_running(self):
        client = Client("running", "running/image", "running/camera_info").connect()
        scene = Scene()
        frames = [scene.draw(t=(0.15 * i, 0.05 * i, 0)) for i in range(4)]
        reconfigure = Reconfigure("running", timeout=TIMEOUT)
        client.ask(frames[0], 100.0)
        self.assertGreater(client.ask(frames[1], 100.1).keypoints_current, 1000)
        with self.said() as said:
            reconfigure.update_configuration({"features": 500, "publish_rejected": True})
            changed = "/running: changed ~features 2000 -> 500, ~publish_rejected false -> true"
            client.wait(lambda: changed in said, changed)
        answer = client.ask(frames[2], 100.2)
        self.assertLessEqual(answer.keypoints_current, 500)
        message = client.correspondence(100.2)
        self.assertEqual(len(message.stage), len(message.confidence))
        self.assertEqual(list(message.stage).count(2), answer.inliers)

        with self.said() as said:
            answer = reconfigure.update_configuration({"success_probability": 1.5, "max_iterations": 0, "features": 600})
            self.assertEqual((answer["success_probability"], answer["max_iterations"], answer["features"]), (0.99, 2000, 500),
                             "the old parameters stay")
            for words in ("~success_probability is '1.5'; it must be a number between 0.01 and 0.999999999",
                          "~max_iterations is '0'; it must be a whole number between 1 and 1000000"):
                client.wait(lambda: any(words in line for line in said), words)
        answer = reconfigure.update_configuration({"inlier_threshold_px": float("nan")})
        self.assertEqual(answer["inlier_threshold_px"], 0)

        refused = reconfigure.update_configuration({"method": "magic", "features": 700})
        self.assertEqual((refused["method"], refused["features"]), ("lo_prosac", 500), "the old parameters stay")
        answer = client.ask(frames[3], 100.3)
        self.assertEqual(answer.status, MatchStats.OK, answer.status_text)


if __name__ == "__main__":
    rospy.init_node("parameters_test")
    rostest.rosrun("gms_ransac", "parameters", Parameters)
