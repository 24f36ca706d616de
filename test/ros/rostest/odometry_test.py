#!/usr/bin/env python3
"""~odom, ~twist and their transforms: begin, axes, frames, covariance, silence when lost, no second parent."""
import itertools
import unittest

import numpy as np
import rospy
import rostest
import tf2_ros
from dynamic_reconfigure.client import Client as Reconfigure
from geometry_msgs.msg import PoseWithCovarianceStamped, TransformStamped, TwistWithCovarianceStamped
from gms_ransac.msg import MatchStats
from nav_msgs.msg import Odometry, Path
from rosgraph_msgs.msg import Log
from std_msgs.msg import Bool
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

from graph import Client, Scene, degrees_between, rotation_matrix, vector

STEP = (0.15, 0.05, 0.0)


def optical_mount(stamp, parent, child):
    """A camera 0.3 m ahead of its base that looks along base x: rpy -90 0 -90."""
    message = TransformStamped()
    message.header.stamp = stamp
    message.header.frame_id, message.child_frame_id = parent, child
    message.transform.translation.x = 0.3
    q = message.transform.rotation
    q.x, q.y, q.z, q.w = -0.5, 0.5, -0.5, 0.5
    return message


class OdometryTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        scene = Scene()
        cls.frames = [scene.draw(t=np.array(STEP) * i) for i in range(5)]

    def run_filter(self, name, frame, count=5):
        """Sends the sequence; returns (client, odom, twist)."""
        client, odom, twist = Client(name, name + "/image", name + "/camera_info"), [], []
        client.subscribe("odom", Odometry, odom)
        client.subscribe("twist", TwistWithCovarianceStamped, twist)
        client.connect()
        for i in range(count):
            answer = client.ask(self.frames[i], 100 + 0.1 * i, frame=frame)
        self.assertEqual(answer.status, MatchStats.OK, answer.status_text)
        client.wait(lambda: len(odom) == count and len(twist) == count - 1, "odometry of %d images" % count)
        return client, odom, twist

    def assert_close(self, a, b):
        for field in a.__slots__:
            self.assertAlmostEqual(getattr(a, field), getattr(b, field), places=12)

    def assert_covariance(self, covariance):
        covariance = np.array(covariance).reshape(6, 6)
        self.assertTrue(np.all(np.isfinite(covariance)))
        self.assertTrue(np.all(np.diag(covariance) >= 1e-9) and np.all(np.diag(covariance) <= 1e6))
        self.assertGreater(np.linalg.eigvalsh(covariance).min(), -1e-9)

    def test_of_the_camera(self):
        client, odom, twist = self.run_filter("of_camera", "/camera_a")
        first = odom[0]
        self.assertEqual(first.header.stamp.to_sec(), 100)
        self.assertEqual((first.child_frame_id, vector(first.pose.pose.position).any()), ("camera_a", False))
        self.assertEqual((first.pose.pose.orientation.w, set(np.diag(np.reshape(first.pose.covariance, (6, 6))))), (1, {1e-9}))
        self.assertEqual(set(np.diag(np.reshape(first.twist.covariance, (6, 6)))), {1e3}, "its velocity is not known")
        for message, rate in zip(odom[1:], twist):
            self.assertEqual((message.header.frame_id, message.child_frame_id), ("odom", "camera_a"))
            self.assertEqual(rate.header.frame_id, "camera_a")
            self.assert_covariance(message.pose.covariance)
            self.assert_covariance(message.twist.covariance)
            self.assertEqual(message.twist.covariance, rate.twist.covariance)
        position = vector(odom[-1].pose.pose.position)
        self.assertLess(degrees_between(position, STEP), 5)
        # ~scale fixed: 0.5 m a pair, five times a second ten.
        self.assertAlmostEqual(np.linalg.norm(position), 4 * 0.5, delta=0.02)
        self.assertAlmostEqual(np.linalg.norm(vector(twist[-1].twist.twist.linear)), 5, delta=0.01)
        self.assertTrue(client.correspondence(100.4).metric_scale)
        variances = [m.pose.covariance[0] for m in odom]
        self.assertEqual(variances, sorted(variances), "uncertainty grows")

    def test_a_filter_does_not_move_by_what_is_not_in_metres(self):
        """robot_localization's correction of a position: K = P / (P + R), with its default process noise. The robot drives at
        1 m/s for a minute, and the camera's odometry, whose unit is none, says a half of it."""
        said = []
        logged = rospy.Subscriber("/rosout", Log, lambda m: said.append(m.msg) if m.name.endswith("contested") else None)
        client, odom, twist = self.run_filter("contested", "camera_b", count=3)
        # A filter takes its place and the variance of it from the first message: with 1e6 it would go half of the way.
        self.assertLess(odom[0].pose.covariance[0], 1e-6, "the origin is known")
        for message in odom[1:]:
            position, rotation = np.diag(np.reshape(message.pose.covariance, (6, 6)))[[0, 3]]
            velocity, rate = np.diag(np.reshape(message.twist.covariance, (6, 6)))[[0, 3]]
            self.assertLess(rotation, 1e-3)
            self.assertLess(rate, 1e-1)
            # With variances of 1000, as of a step that is not known, it would move by 15 m.
            for variance, noise in ((position, 0.05), (velocity, 0.025)):  # of the filter, per second
                state, P = 0.0, 1e-9
                for _ in range(600):
                    P += 0.1 * noise
                    state += P / (P + variance) * (30 - state)
                    P -= P * P / (P + variance)
                self.assertLess(state, 0.05)
        no_metres = lambda: [s for s in said if "set ~scale to depth, fixed, odometry or ground for metres" in s]
        client.wait(no_metres, "a word on metres")
        self.assertEqual(len(no_metres()), 1)
        logged.unregister()

    def test_absolute_pose_transform_and_path(self):
        name, topics = "of_camera", (("pose", PoseWithCovarianceStamped), ("transform", TransformStamped), ("path", Path))
        client = Client(name, name + "/image", name + "/camera_info")
        received = {topic: [] for topic, _ in topics}
        for topic, kind in topics:
            client.subscribe(topic, kind, received[topic])
        odom = []
        client.subscribe("odom", Odometry, odom)
        client.connect()
        self.assertTrue(rospy.ServiceProxy(name + "/reset", Trigger)().success)
        for i, frame in enumerate(self.frames):
            client.ask(frame, 200 + 0.1 * i, frame="camera_p")
        for messages in list(received.values()) + [odom]:
            client.wait(lambda: len(messages) == len(self.frames), "every output of every image")
        for last, pose, transform, path in zip(odom, received["pose"], received["transform"], received["path"]):
            for message in (pose, transform, path):
                self.assertEqual(message.header.frame_id, "odom")
                self.assertEqual(message.header.stamp, last.header.stamp)
            self.assertEqual(pose.pose, last.pose)
            self.assertEqual(transform.child_frame_id, "camera_p")
            # The transform is made from the pose by tf2, which may round otherwise.
            self.assert_close(transform.transform.translation, last.pose.pose.position)
            self.assert_close(transform.transform.rotation, last.pose.pose.orientation)
            self.assertEqual(path.poses[-1].pose, last.pose.pose)
        self.assertEqual([p.pose for p in received["path"][-1].poses], [m.pose.pose for m in odom])
        self.assertTrue(rospy.ServiceProxy(name + "/reset", Trigger)().success)
        client.ask(self.frames[0], 300, frame="camera_p")
        client.wait(lambda: len(received["path"]) == len(self.frames) + 1, "the path after a reset")
        self.assertEqual(len(received["path"][-1].poses), 1, "it begins anew")

    def test_silent_when_lost(self):
        client, odom, twist = self.run_filter("of_camera_again", "camera_b", count=3)
        answer = client.ask(np.zeros((480, 640), np.uint8), 100.3, frame="camera_b")
        self.assertEqual(answer.status, MatchStats.TOO_FEW_KEYPOINTS)
        other_place = Scene().draw(t=(0, 0, 0), r=(0, 2.0, 0))
        client.ask(np.ascontiguousarray(other_place[::-1]), 100.4, frame="camera_b")
        answer = client.ask(self.frames[0], 100.5, frame="camera_b")
        client.ask(self.frames[1], 100.6, frame="camera_b")
        client.wait(lambda: odom[-1].header.stamp.to_sec() > 100.59, "odometry after the loss")
        stamps = [round(m.header.stamp.to_sec(), 3) for m in odom]
        lost = [round(m.header.stamp.to_sec(), 3) for m in client.stats[1:] if m.status not in (MatchStats.OK, MatchStats.LOW_PARALLAX)]
        self.assertFalse(set(stamps) & set(lost))
        self.assertGreater(odom[-1].pose.covariance[21], odom[2].pose.covariance[21])

    def test_standing_still_for_long_breaks_nothing(self):
        client, odom, restarts = Client("standing", "standing/image", "standing/camera_info"), [], []
        client.subscribe("odom", Odometry, odom)
        client.subscribe("restart", Bool, restarts)
        client.connect()
        random = np.random.RandomState(1)
        places = [0, 1, 2] + 35 * [2] + [3, 4]  # stands for 3.5 s; ~max_frame_gap is 1 s
        for i, place in enumerate(places):
            noisy = self.frames[place] + random.normal(0, 2, self.frames[place].shape)
            answer = client.ask(np.clip(noisy, 0, 255).astype(np.uint8), 100 + 0.1 * i)
            self.assertIn(answer.status, (MatchStats.OK, MatchStats.LOW_PARALLAX) if i else (MatchStats.FIRST_FRAME,),
                          answer.status_text)
        client.wait(lambda: len(odom) == len(places), "odometry of every image")
        self.assertEqual(answer.resets, 0)
        self.assertTrue(rospy.ServiceProxy("standing/reset", Trigger)().success)
        client.ask(self.frames[0], 100 + 0.1 * len(places))
        client.wait(lambda: restarts, "~restart after a reset")
        self.assertEqual(len(restarts), 1, "and none before it")
        standing = [vector(m.pose.pose.position) for m in odom[3:len(places) - 2]]
        self.assertLess(max(np.linalg.norm(p - standing[0]) for p in standing), 1e-9, "nothing is added up")
        # Before and after it the steps are of one length: the scale outlived the stop.
        steps = np.diff([vector(odom[k].pose.pose.position) for k in (1, 2, len(places) - 3, len(places) - 2, len(places) - 1)], axis=0)
        lengths = np.linalg.norm(steps[[0, 2, 3]], axis=1)
        self.assertTrue(np.allclose(lengths, 1, atol=0.1), lengths)

    def test_of_the_base_and_the_walk_through_tf(self):
        buffer = tf2_ros.Buffer()
        listener = tf2_ros.TransformListener(buffer)
        static = tf2_ros.StaticTransformBroadcaster()
        static.sendTransform(optical_mount(rospy.Time.from_sec(99), "base_c", "camera_c"))
        client, odom = Client("of_base", "of_base/image", "of_base/camera_info"), []
        client.subscribe("odom", Odometry, odom)
        client.connect()
        client.wait(lambda: static.pub_tf.get_num_connections() >= 2, "the filter and us to listen to tf")
        stamp = 100.0
        # The filter listens to tf for a while before it broadcasts what has come; images keep coming as they would.
        i = 0

        def walked():
            nonlocal i, stamp
            client.ask(self.frames[i % 4 if (i // 4) % 2 == 0 else 3 - i % 4], stamp, frame="camera_c")
            i, stamp = i + 1, stamp + 0.1
            return i > 2 and buffer.can_transform("odom", "camera_c", rospy.Time.from_sec(stamp - 0.1))

        client.wait(walked, "odom -> base_c")
        client.wait(lambda: len(odom) == i, "odometry of every image, the first included")
        client.wait(lambda: buffer.can_transform("odom", "base_c", rospy.Time(100)), "tf of the first image")
        first = buffer.lookup_transform("odom", "base_c", rospy.Time(100)).transform
        self.assertLess(max(map(abs, list(vector(first.translation)) + [1 - first.rotation.w])), 1e-12)
        last = odom[-1]
        self.assertEqual((last.header.frame_id, last.child_frame_id), ("odom", "base_c"))
        there = buffer.lookup_transform("odom", "camera_c", rospy.Time(0)).transform
        back = buffer.lookup_transform("camera_c", "odom", rospy.Time(0)).transform
        R = rotation_matrix(there.rotation)
        self.assertTrue(np.allclose(R @ rotation_matrix(back.rotation), np.eye(3), atol=1e-9))
        self.assertTrue(np.allclose(R @ vector(back.translation) + vector(there.translation), 0, atol=1e-9))
        # First motion: camera right and down = base right (-y) and down (-z).
        first = vector(odom[1].pose.pose.position)
        self.assertLess(degrees_between(first, (0, -STEP[0], -STEP[1])), 15)
        del listener

    def test_no_transform_without_a_frame(self):
        said, transforms = [], []
        logged = rospy.Subscriber("/rosout", Log, lambda m: said.append(m.msg) if m.name.endswith("nameless") else None)
        listening = rospy.Subscriber("/tf", TFMessage, lambda m: transforms.extend(m.transforms))
        client = Client("nameless", "nameless/image", "nameless/camera_info").connect()
        client.wait(lambda: logged.get_num_connections() and listening.get_num_connections(), "log and tf")
        sent = itertools.count()

        def step(frame):
            i = next(sent)
            return client.ask(self.frames[i % 5 if (i // 5) % 2 == 0 else 4 - i % 5], 100 + 0.1 * i, frame=frame)

        for _ in range(10):
            step("/")
        client.wait(lambda: [s for s in said if "no frame_id" in s], "the warning")

        def broadcast():  # of images with a name, once it has listened to tf for long enough
            step("named")
            children = {t.child_frame_id for t in transforms}
            return {"named", "named_reference"} <= children

        client.wait(broadcast, "transforms of a camera with a name")
        for _ in range(5):
            step("/")
        count = len(transforms)

        def more():
            step("named")
            return len(transforms) > count + 1

        client.wait(more, "transforms after those that have no name")
        warnings = lambda: [s for s in said if "no frame_id" in s]
        client.wait(warnings, "a warning")
        self.assertEqual(len(warnings()), 1, said)
        self.assertFalse([t for t in transforms if t.child_frame_id in ("", "_reference") or not t.header.frame_id])

    def test_another_node_with_the_same_transform_is_noticed(self):
        said = []
        logged = rospy.Subscriber("/rosout", Log, lambda m: said.append(m.msg) if m.name.endswith("contested") else None)
        broadcaster = tf2_ros.TransformBroadcaster()
        rospy.Subscriber("/tf", TFMessage, lambda m: None)  # without a subscriber there is no broadcast
        client = Client("contested", "contested/image", "contested/camera_info").connect()
        client.wait(logged.get_num_connections, "log")
        i = 0

        def noticed():
            nonlocal i
            client.ask(self.frames[i % 4 if (i // 4) % 2 == 0 else 3 - i % 4], 300 + 0.1 * i, frame="camera_e")
            broadcaster.sendTransform(optical_mount(rospy.Time.from_sec(300 + 0.1 * i), "camera_e", "camera_e_reference"))
            i += 1
            return [s for s in said if "camera_e -> camera_e_reference, and so does" in s]

        self.assertIn(rospy.get_name(), client.wait(noticed, "the warning")[0])
        for _ in range(5):
            noticed()
        # The node's last message is read last: by then any other warning is here.
        last = "change refused"
        Reconfigure("contested", timeout=30).update_configuration({"features": 0})
        client.wait(lambda: [s for s in said if last in s], last)
        self.assertEqual(len([s for s in said if "and so does" in s]), 1, "it does not contest itself")

    def test_refuses_to_give_a_frame_a_second_parent(self):
        buffer = tf2_ros.Buffer()
        listener = tf2_ros.TransformListener(buffer)
        static = tf2_ros.StaticTransformBroadcaster()
        static.sendTransform([optical_mount(rospy.Time.from_sec(99), "wall", "camera_d")])
        said = []
        logged = rospy.Subscriber("/rosout", Log, lambda m: said.append(m.msg) if m.name.endswith("owned") else None)
        client = Client("owned", "owned/image", "owned/camera_info").connect()
        inverted = Client("inverted", "inverted/image", "inverted/camera_info").connect()
        i = 0

        def both():
            nonlocal i
            k = i % 4 if (i // 4) % 2 == 0 else 3 - i % 4
            client.ask(self.frames[k], 100 + 0.1 * i, frame="camera_d")
            inverted.ask(self.frames[k], 100 + 0.1 * i, frame="camera_d")
            i += 1
            return buffer.can_transform("wall", "odom_inverted", rospy.Time(0))

        inverted.wait(both, "the inverted transform")

        def refused():
            both()
            return [s for s in said if "another node broadcasts camera_d with the parent wall" in s]

        client.wait(refused, "the refusal")
        before = buffer.lookup_transform("wall", "odom_inverted", rospy.Time(0)).header.stamp

        def later():  # pairs that the other filter has answered too, after it refused
            both()
            return buffer.lookup_transform("wall", "odom_inverted", rospy.Time(0)).header.stamp > before

        client.wait(later, "a later transform")
        self.assertFalse(buffer.can_transform("odom_owned", "camera_d", rospy.Time(0)))
        self.assertTrue(buffer.can_transform("wall", "camera_d", rospy.Time(0)))
        del listener, logged



if __name__ == "__main__":
    rospy.init_node("odometry_test")
    rostest.rosrun("gms_ransac", "odometry", OdometryTest)
