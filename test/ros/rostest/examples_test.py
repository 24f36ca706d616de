#!/usr/bin/env python3
"""The example launch files, in one graph: each one's filter answers, in the frames that the file promises. And every
launch file: what it reads of a match filter exists, and what it configures is read."""
import functools
import glob
import itertools
import os
import re
import unittest

import numpy as np
import rosgraph
import roslaunch.config
import rospkg
import rospy
import yaml
from geometry_msgs.msg import PoseWithCovarianceStamped, TransformStamped, TwistWithCovarianceStamped
from gms_ransac.msg import Correspondences, MatchStats
from nav_msgs.msg import Odometry

from graph import HEIGHT, WIDTH, Client, Scene, run, texture, vector

STEP = np.array((0.0, 0.0, 0.2))  # ahead
PACKAGE = rospkg.RosPack().get_path("gms_ransac")

# robot_localization's state, of which each input's config switches what is fused, and the kinds of input it numbers.
EKF_STATES = 15
EKF_KINDS = {"odom": "nav_msgs/Odometry", "twist": "geometry_msgs/TwistWithCovarianceStamped",
             "pose": "geometry_msgs/PoseWithCovarianceStamped", "imu": "sensor_msgs/Imu"}

# Arguments without which a launch file does not load.
ARGUMENTS = {
    "replay": ["bag:=/camera.bag", "image:=/camera/image"], "tum": ["bag:=/rgbd_dataset_freiburg1_desk.bag"],
    "kitti": ["bag:=/kitti_2011_09_26_drive_0002_synced.bag"], "demo": ["bag:=/scene.bag"],
    "example_rectified": ["start_image_proc:=true", "manager:=camera_manager", "rviz:=true"],
    "example_multi_machine": ["rviz:=true", "match_image_transport:=compressed"],
    "example_robot_localization": ["start_ekf:=true"]}


@functools.lru_cache()
def launch_files():
    """{name: what roslaunch makes of it}"""
    configs = {}
    for path in sorted(glob.glob(PACKAGE + "/launch/*.launch")):
        name = os.path.splitext(os.path.basename(path))[0]
        configs[name] = roslaunch.config.load_config_default([(path, ARGUMENTS.get(name, []))], 11311, assign_machines=False)
    return configs


def is_match_filter(node):
    return node.type == "match_filter_node" or "gms_ransac/MatchFilter" in (node.args or "")


def resolve(node, name):
    """A relative name as the node sees it."""
    return rosgraph.names.resolve_name(name, node.namespace + node.name)


class Examples(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.frames = [Scene().draw(t=STEP * i) for i in range(3)]

    def outputs(self, client, topic, kind):
        """Sends the frames and returns what comes out on the topic, one message per image."""
        messages = []
        client.subscribe(topic, kind, messages)
        client.connect()
        for i, frame in enumerate(self.frames):
            answer = client.ask(frame, 100 + 0.1 * i)
        self.assertEqual(answer.status, MatchStats.OK, answer.status_text)
        client.wait(lambda: len(messages) == len(self.frames), topic)
        return messages

    def test_two_cameras_have_an_odometry_frame_each(self):
        for side in ("left", "right"):
            client = Client(side + "_filter", "/%s/image" % side, "/%s/camera_info" % side)
            for odom in self.outputs(client, "odom", Odometry):
                self.assertEqual(odom.header.frame_id, side + "_filter_odom")

    def test_rectified_images_are_read_beside_the_camera_info(self):
        client = Client("match_filter", "/rectified/image_rect", "/rectified/camera_info")
        self.assertTrue(self.outputs(client, "odom", Odometry))

    def walk(self, client, condition, what, frame="camera"):
        """One step after another, ahead twice and back twice; the first ones may come before tf knows where the camera is."""
        sent = itertools.count()

        def step():
            i = next(sent)
            client.ask(self.frames[(0, 1, 2, 1)[i % 4]], 100 + 0.1 * i, frame=frame)
            return condition()

        client.connect().wait(step, what)

    def test_twist_for_robot_localization_is_that_of_the_base(self):
        client, twists = Client("/robot/match_filter", "/robot/image", "/robot/camera_info"), []
        client.subscribe("twist", TwistWithCovarianceStamped, twists)
        self.walk(client, lambda: len(twists) >= 3, "twist")
        stamps = [twist.header.stamp for twist in twists]
        self.assertEqual(stamps, sorted(set(stamps)), "older ones are not taken")
        for twist in twists:
            self.assertEqual(twist.header.frame_id, "base_link")
            covariance = np.reshape(twist.twist.covariance, (6, 6))
            self.assertTrue(np.allclose(covariance, covariance.T))
            self.assertGreater(np.linalg.eigvalsh(covariance)[0], 1e-9, "what the filter raises smaller variances to")
            ahead = round((twist.header.stamp.to_sec() - 100) / 0.1) % 4 in (1, 2)
            v = vector(twist.twist.twist.linear)
            self.assertGreater((v[0] if ahead else -v[0]) / np.linalg.norm(v), 0.99, "the camera looks along the base's x")

    def test_absolute_poses_arrive_where_they_are_read(self):
        client, poses, transforms = Client("/drone/match_filter", "/drone/image", "/drone/camera_info"), [], []
        for topic, kind, into in (("/mavros/vision_pose/pose_cov", PoseWithCovarianceStamped, poses),
                                  ("/transform", TransformStamped, transforms)):
            client.subscribers.append(rospy.Subscriber(topic, kind, into.append, queue_size=500))
        self.walk(client, lambda: len(poses) >= 2 and len(transforms) >= 2, "poses and transforms", "camera_of_drone")
        self.assertEqual(poses[0].header.frame_id, "odom")
        self.assertEqual((transforms[0].header.frame_id, transforms[0].child_frame_id), ("odom", "drone"))
        at = vector(poses[1].pose.pose.position) - vector(poses[0].pose.pose.position)
        self.assertGreater(abs(at[0]) / np.linalg.norm(at), 0.99, "the camera looks along the base's x")

    def test_a_loop_is_found_and_nothing_else(self):
        client, loops = Client("/loops/match_filter", "/loops/image", "/loops/camera_info"), []
        client.subscribers.append(rospy.Subscriber("/loops/find_loops/loops", Correspondences, loops.append, queue_size=50))
        client.connect()
        elsewhere = [texture(WIDTH, 50 + i)[:HEIGHT] for i in range(4)]
        for i, frame in enumerate(self.frames + elsewhere + self.frames):
            client.ask(frame, 100 + 0.1 * i)
        client.wait(lambda: loops, "the loop")
        for loop in loops:
            now, then = loop.header.stamp.to_sec(), loop.reference_header.stamp.to_sec()
            self.assertGreater(now, 100.65)
            self.assertLess(then, 100.25)
            self.assertGreaterEqual(len(loop.distance), 60)
            self.assertEqual(len(loop.reference_points), 2 * len(loop.distance))

    def outputs_and_services(self):
        """{name below the filter's: type} of what a running filter really offers."""
        master = rosgraph.Master("/examples_test")
        types = dict(master.getTopicTypes())
        publishers, _, services = master.getSystemState()
        prefix = "/match_filter/"
        offered = {topic[len(prefix):]: types.get(topic) for topic, _ in publishers if topic.startswith(prefix)}
        offered.update({name[len(prefix):]: None for name, _ in services if name.startswith(prefix)})
        return offered

    def test_every_input_of_robot_localization_is_read_and_exists(self):
        """The numbers of a kind are read from 0 to the first that is missing, without a word about the rest."""
        parameters = rospy.get_param("/robot/ekf")
        configured = {name for name in parameters if re.fullmatch("(%s)[0-9]+" % "|".join(EKF_KINDS), name)}
        read = set()
        for kind in EKF_KINDS:
            read.update(itertools.takewhile(parameters.__contains__, (kind + str(i) for i in itertools.count())))
        self.assertEqual(read, configured, "robot_localization stops at the first gap")
        self.assertEqual(read, {"odom0", "twist0"})
        self.assertTrue(parameters["smooth_lagged_data"], "or a twist counts as one of now, not of its image")
        self.assertGreaterEqual(parameters["history_length"], 0.5, "seconds: longer than an image waits and is processed")
        fused = [i for i, on in enumerate(parameters["twist0_config"]) if on]
        self.assertEqual(fused, [9, 10, 11], "of one camera vroll, vpitch, vyaw: its velocity has no scale")
        offered = self.outputs_and_services()
        ekf = next(n for n in launch_files()["example_robot_localization"].nodes if n.package == "robot_localization")
        for name in read:
            config = parameters[name + "_config"]
            self.assertEqual([type(on) for on in config], [bool] * EKF_STATES, name)
            self.assertIn(True, config, name)
            topic = parameters[name]
            if topic.startswith("match_filter/"):
                self.assertEqual(offered[topic.split("/", 1)[1]], EKF_KINDS[name.rstrip("0123456789")])
            else:
                self.assertIn(topic, [source for source, _ in ekf.remap_args], "the launch file says where it comes from")

    def test_the_commented_input_continues_the_numbers(self):
        with open(PACKAGE + "/cfg/robot_localization.yaml") as lines:
            text = lines.read()
        commented = "\n".join(re.findall(r"^# ((?:\w+:|  +[a-z]+,).*)$", text[text.index("if only poses"):], re.M))
        both = dict(yaml.safe_load(text), **yaml.safe_load(commented))
        numbers = sorted(name for name in both if re.fullmatch("odom[0-9]+", name))
        self.assertEqual(numbers, ["odom%d" % i for i in range(len(numbers))])
        self.assertEqual(len(both[numbers[-1] + "_config"]), EKF_STATES)
        self.assertIn(both[numbers[-1]].split("/")[1], self.outputs_and_services())

    def test_what_launch_files_name_below_a_filter_exists(self):
        offered = self.outputs_and_services()
        self.assertIn("correspondences", offered)
        settings = set(rospy.get_param("/match_filter"))  # dynamic_reconfigure has put all of its own there
        named = {}
        for path in glob.glob(PACKAGE + "/launch/*.launch") + [
                PACKAGE + "/" + name for name in ("README.md", "doc/consumers.md", "rviz/match_filter.rviz", "cfg/robot_localization.yaml")]:
            with open(path) as lines:
                for name in re.findall(r"(?:match_filter|left_filter|right_filter|arg name\))/([a-z_]+)", lines.read()):
                    named.setdefault(name, os.path.basename(path))
        self.assertGreater(len(named), 8)
        with open(PACKAGE + "/cfg/match_filter.yaml") as stream:
            known = set(offered) | settings | set(yaml.safe_load(stream)) | {"mask", "stereo_features"}  # of ~input stereo
        self.assertEqual({name: where for name, where in named.items() if name not in known}, {})

    def test_every_topic_of_the_view_follows_the_filters_name(self):
        with open(PACKAGE + "/rviz/match_filter.rviz") as lines:
            shown = set(re.findall("Topic: (match_filter/.*)", lines.read()))
        rviz = next(n for n in launch_files()["view"].nodes if n.type == "rviz")
        self.assertEqual({source for source, _ in rviz.remap_args}, shown)

    def test_every_launch_file_clears_the_parameters_of_its_nodes(self):
        for name, config in launch_files().items():
            for node in config.nodes:
                if is_match_filter(node) or node.package == "robot_localization":
                    self.assertIn(resolve(node, "~").rstrip("/") + "/", [p.rstrip("/") + "/" for p in config.clear_params],
                                  "%s: %s" % (name, node.name))

    def test_nodelets_load_into_one_manager(self):
        for name, config in launch_files().items():
            managers = {resolve(n, n.args.split()[2]) for n in config.nodes
                        if n.package == "nodelet" and n.args.startswith("load")}
            self.assertLessEqual(len(managers), 1, name)


if __name__ == "__main__":
    run("examples", Examples)
