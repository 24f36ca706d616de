#!/usr/bin/env python3
"""~odom, ~twist and their transforms: begin, axes, frames, covariance, silence when lost, no second parent."""
import time
import unittest

import numpy as np
import rospy
import tf2_ros
from diagnostic_msgs.msg import DiagnosticArray
from dynamic_reconfigure.client import Client as Reconfigure
from geometry_msgs.msg import PoseWithCovarianceStamped, TransformStamped, TwistWithCovarianceStamped
from gms_ransac.msg import MatchStats
from nav_msgs.msg import Odometry, Path
from std_msgs.msg import Bool
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

from graph import STEP, TIMEOUT, Scene, client_of, degrees_between, rotation_matrix, run, said_by, vector, walk


def optical_mount(stamp, parent, child):
    """A camera 0.3 m ahead of its base that looks along base x: rpy -90 0 -90."""
    message = TransformStamped()
    message.header.stamp = rospy.Time.from_sec(stamp)
    message.header.frame_id, message.child_frame_id = parent, child
    message.transform.translation.x = 0.3
    q = message.transform.rotation
    q.x, q.y, q.z, q.w = -0.5, 0.5, -0.5, 0.5
    return message


def diagonal(covariance):
    return np.diag(np.reshape(covariance, (6, 6)))


class OdometryTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.frames = walk(5)
        cls.buffer = tf2_ros.Buffer()
        cls.listener = tf2_ros.TransformListener(cls.buffer)  # without a subscriber there is no broadcast
        cls.static = tf2_ros.StaticTransformBroadcaster()
        cls.static.sendTransform([optical_mount(99, "base_c", "camera_c"), optical_mount(99, "wall", "camera_d")])

    def client(self, name, **kinds):
        """A client, and a list for each of these topics."""
        client, lists = client_of(name), [[] for _ in kinds]
        for (topic, kind), into in zip(kinds.items(), lists):
            client.subscribe(topic, kind, into)
        return [client.connect()] + lists

    def run_filter(self, name, frame, count=5):
        """Sends the sequence; returns (client, odom, twist)."""
        client, odom, twist = self.client(name, odom=Odometry, twist=TwistWithCovarianceStamped)
        for i in range(count):
            answer = client.ask(self.frames[i], 100 + 0.1 * i, frame=frame)
        self.assertEqual(answer.status, MatchStats.OK, answer.status_text)
        client.wait(lambda: len(odom) == count and len(twist) == count - 1, "odometry of %d images" % count)
        return client, odom, twist

    def walk(self, *clients, start=100, frame="camera"):
        """A function that sends the next image, there and back, and returns its stamp."""
        stamps = iter(start + 0.1 * np.arange(1000))

        def step(frame=frame):
            stamp = next(stamps)
            i = round(10 * (stamp - start)) % 8
            for client in clients:
                client.ask(self.frames[min(i, 7 - i)], stamp, frame=frame)
            return stamp

        return step

    def test_only_readers_of_positions_are_warned_that_they_are_not_in_metres(self):
        said = said_by("for_an_ekf")
        warnings = lambda: [line for line in said if "~odom, ~pose and ~twist are not in metres" in line]
        client, twist = self.client("for_an_ekf", twist=TwistWithCovarianceStamped)
        step = self.walk(client)
        client.wait(lambda: step() and twist, "a velocity")
        client.wait(lambda: [line for line in said if "fuse its rotation alone" in line], "what the recipe does")
        self.assertEqual(warnings(), [])
        client.subscribe("odom", Odometry, [])
        client.connect().wait(lambda: step() and warnings(), "the warning")

    def test_of_the_camera(self):
        client, odom, twist = self.run_filter("of_camera", "/camera_a")
        first = odom[0]
        self.assertEqual(first.header.stamp.to_sec(), 100)
        self.assertEqual((first.child_frame_id, vector(first.pose.pose.position).any()), ("camera_a", False))
        self.assertEqual((first.pose.pose.orientation.w, set(diagonal(first.pose.covariance))), (1, {1e-9}))
        self.assertEqual(set(diagonal(first.twist.covariance)), {1e3}, "its velocity is not known")
        for message, rate in zip(odom[1:], twist):
            self.assertEqual((message.header.frame_id, message.child_frame_id), ("odom", "camera_a"))
            self.assertEqual(rate.header.frame_id, "camera_a")
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
        said = said_by("contested")
        client, odom, _ = self.run_filter("contested", "camera_b", count=3)
        # A filter takes its place and the variance of it from the first message: with 1e6 it would go half of the way.
        self.assertLess(odom[0].pose.covariance[0], 1e-6, "the origin is known")
        for message in odom[1:]:
            for covariance, of_rotation in ((message.pose.covariance, 1e-3), (message.twist.covariance, 1e-1)):
                self.assertEqual(set(diagonal(covariance)[:3]), {1e6})
                self.assertLess(diagonal(covariance)[3], of_rotation)
        no_metres = lambda: [s for s in said if "set ~scale to depth, fixed, odometry or ground for metres" in s]
        client.wait(no_metres, "a word on metres")
        self.assertEqual(len(no_metres()), 1)

    def test_absolute_pose_transform_and_path(self):
        client, poses, transforms, paths, odom = self.client(
            "of_camera", pose=PoseWithCovarianceStamped, transform=TransformStamped, path=Path, odom=Odometry)
        self.assertTrue(rospy.ServiceProxy("of_camera/reset", Trigger)().success)
        for i, frame in enumerate(self.frames):
            client.ask(frame, 200 + 0.1 * i, frame="camera_p")
        for messages in (poses, transforms, paths, odom):
            client.wait(lambda: len(messages) == len(self.frames), "every output of every image")
        for last, pose, transform, path in zip(odom, poses, transforms, paths):
            for message in (pose, transform, path):
                self.assertEqual((message.header.frame_id, message.header.stamp), ("odom", last.header.stamp))
            self.assertEqual(pose.pose, last.pose)
            self.assertEqual(transform.child_frame_id, "camera_p")
            # The transform is made from the pose by tf2, which may round otherwise.
            np.testing.assert_allclose(vector(transform.transform.translation), vector(last.pose.pose.position), atol=1e-12)
            np.testing.assert_allclose(rotation_matrix(transform.transform.rotation),
                                       rotation_matrix(last.pose.pose.orientation), atol=1e-12)
        self.assertEqual([p.pose for p in paths[-1].poses], [m.pose.pose for m in odom])
        self.assertTrue(rospy.ServiceProxy("of_camera/reset", Trigger)().success)
        client.ask(self.frames[0], 300, frame="camera_p")
        client.wait(lambda: len(paths) == len(self.frames) + 1, "the path after a reset")
        self.assertEqual(len(paths[-1].poses), 1, "it begins anew")

    def test_silent_when_lost(self):
        client, odom, _ = self.run_filter("of_camera_again", "camera_b", count=3)
        elsewhere = np.ascontiguousarray(Scene().draw(r=(0, 2.0, 0))[::-1])
        for i, frame in enumerate((np.zeros_like(elsewhere), elsewhere, self.frames[0], self.frames[1])):
            client.ask(frame, 100.3 + 0.1 * i, frame="camera_b")
        self.assertEqual(client.stats[3].status, MatchStats.TOO_FEW_KEYPOINTS)
        client.wait(lambda: odom[-1].header.stamp.to_sec() > 100.59, "odometry after the loss")
        good = (MatchStats.OK, MatchStats.LOW_PARALLAX)
        self.assertEqual([m.header.stamp for m in odom[1:]], [m.header.stamp for m in client.stats[1:] if m.status in good])
        self.assertGreater(odom[-1].pose.covariance[21], odom[2].pose.covariance[21])

    def test_standing_still_for_long_breaks_nothing(self):
        client, odom, restarts = self.client("standing", odom=Odometry, restart=Bool)
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
        at = np.array([vector(m.pose.pose.position) for m in odom[:len(places)]])
        self.assertLess(np.abs(at[3:-2] - at[3]).max(), 1e-9, "nothing is added up")
        # Before and after it the steps are of one length: the scale outlived the stop.
        lengths = np.linalg.norm((at[2] - at[1], at[-2] - at[-3], at[-1] - at[-2]), axis=1)
        self.assertTrue(np.allclose(lengths, 1, atol=0.1), lengths)

    def test_of_the_base_and_the_walk_through_tf(self):
        client, odom = self.client("of_base", odom=Odometry)
        listeners = lambda: {connection.endpoint_id for connection in self.static.pub_tf.impl.connections}
        client.wait(lambda: {"/of_base", rospy.get_name()} <= listeners(), "the filter and us to listen to tf")
        # The filter listens to tf for a while before it broadcasts what has come; images keep coming as they would.
        step = self.walk(client, frame="camera_c")
        client.wait(lambda: self.buffer.can_transform("odom", "camera_c", rospy.Time.from_sec(step())) and len(client.stats) > 2,
                    "odom -> base_c")
        client.wait(lambda: len(odom) == len(client.stats), "odometry of every image, the first included")
        client.wait(lambda: self.buffer.can_transform("odom", "base_c", rospy.Time(100)), "tf of the first image")
        first = self.buffer.lookup_transform("odom", "base_c", rospy.Time(100)).transform
        self.assertLess(max(map(abs, list(vector(first.translation)) + [1 - first.rotation.w])), 1e-12)
        self.assertEqual((odom[-1].header.frame_id, odom[-1].child_frame_id), ("odom", "base_c"))
        # First motion: camera right and down = base right (-y) and down (-z).
        self.assertLess(degrees_between(vector(odom[1].pose.pose.position), (0, -STEP[0], -STEP[1])), 15)

        self.set_pose(client, odom, step)

    def set_pose(self, client, odom, step):
        said = said_by("of_base")
        publisher = rospy.Publisher("of_base/set_pose", PoseWithCovarianceStamped, queue_size=2)
        client.wait(publisher.get_num_connections, "the filter to listen to ~set_pose")
        message = PoseWithCovarianceStamped()
        message.header.frame_id = "map"
        message.pose.pose.position.x, message.pose.pose.orientation.z = 1000, 1  # far away, and facing the other way
        message.pose.covariance = np.diag([4, 4, 4, 0.01, 0.01, 0.01]).ravel()
        publisher.publish(message)
        client.wait(lambda: [s for s in said if "~set_pose in the frame 'map' is not used" in s], "the refusal")
        message.header.frame_id = "odom"
        message.pose.pose.position.y = float("nan")
        publisher.publish(message)
        client.wait(lambda: [s for s in said if "~set_pose is not used: it is not finite" in s], "the other refusal, at once")
        message.pose.pose.position.y = 0
        publisher.publish(message)
        client.wait(lambda: step() and odom[-1].pose.pose.position.x > 900, "the pose that was set")
        self.assertLess(np.linalg.norm(vector(odom[-1].pose.pose.position) - (1000, 0, 0)), 5)
        self.assertLess(rotation_matrix(odom[-1].pose.pose.orientation)[0, 0], -0.9)
        self.assertGreater(odom[-1].pose.covariance[35], 0.0099)

    def test_no_transform_without_a_frame(self):
        said, transforms = said_by("nameless"), []
        listening = rospy.Subscriber("/tf", TFMessage, lambda m: transforms.extend(m.transforms))
        client, = self.client("nameless")
        client.wait(listening.get_num_connections, "tf")
        step, begin = self.walk(client), time.monotonic()
        warnings = lambda: [s for s in said if "no frame_id" in s]

        def broadcast():  # of images with a name, once it has listened to tf for long enough
            step("named")
            return {"named", "named_reference"} <= {t.child_frame_id for t in transforms}

        for _ in range(10):
            step("/")
        client.wait(warnings, "the warning")
        client.wait(broadcast, "transforms of a camera with a name")
        for _ in range(5):
            step("/")
        transforms_before, transforms[:] = list(transforms), []
        client.wait(broadcast, "transforms after those that have no name")
        self.assertLessEqual(len(warnings()), 1 + (time.monotonic() - begin) // 10, "once in 10 s: %s" % said)
        self.assertFalse([t for t in transforms_before + transforms
                          if t.child_frame_id in ("", "_reference") or not t.header.frame_id])

    def broadcasters(self, child):
        """A list of who broadcasts a frame from now on, and when."""
        seen = []
        store = lambda m: seen.extend((m._connection_header["callerid"], t.header.stamp) for t in m.transforms
                                      if t.child_frame_id == child)
        rospy.Subscriber("/tf", TFMessage, store, queue_size=500)
        return seen

    def refused(self, name, reports):
        """What diagnostics say, as an ERROR, of a frame that another node broadcasts."""
        return [s.message for r in reports for s in r.status
                if s.name.strip("/") == name + ": graph" and s.level == 2 and "only one parent and one broadcaster" in s.message]

    def test_a_frame_that_another_node_broadcasts_is_left_to_it(self):
        said, broadcaster, reports = said_by("contested"), tf2_ros.TransformBroadcaster(), []
        rospy.Subscriber("/diagnostics", DiagnosticArray, reports.append)
        client, = self.client("contested")
        seen = self.broadcasters("camera_e_reference")
        step = self.walk(client, start=300, frame="camera_e")

        def noticed():
            broadcaster.sendTransform(optical_mount(step(), "camera_e", "camera_e_reference"))
            return [s for s in said if "broadcasts the transform camera_e -> camera_e_reference, and a frame can have" in s]

        self.assertIn(rospy.get_name(), client.wait(noticed, "the error")[0])
        self.assertIn(rospy.get_name(), client.wait(lambda: noticed() and self.refused("contested", reports), "diagnostics")[0])
        # The node's last message is read last: by then any other warning is here.
        last = "change refused"
        Reconfigure("contested", timeout=TIMEOUT).update_configuration({"features": 0})
        client.wait(lambda: [s for s in said if last in s], last)
        self.assertEqual(len(noticed()), 1, "said once")
        self.assertEqual({node for node, _ in seen}, {rospy.get_name()})

    def test_of_two_filters_on_one_camera_one_broadcasts(self):
        reports = []
        rospy.Subscriber("/diagnostics", DiagnosticArray, reports.append)
        (first,), (second,) = self.client("twin_a"), self.client("twin_b")
        seen, step = self.broadcasters("camera_t_reference"), self.walk(first, second, frame="camera_t")
        first.wait(lambda: step() and (self.refused("twin_a", reports) or self.refused("twin_b", reports)), "one to give way")
        del seen[:]
        stamps = [step() for _ in range(5)]
        first.wait(lambda: step() and len(seen) > 5, "transforms of the other")
        self.assertEqual(len({node for node, _ in seen}), 1)
        self.assertEqual(len(seen), len({stamp for _, stamp in seen}), "each stamp once: %s" % stamps)
        self.assertFalse(self.refused("twin_a", reports) and self.refused("twin_b", reports), "one goes on")

    def test_refuses_to_give_a_frame_a_second_parent(self):
        said = said_by("owned")
        (owned,), (inverted,) = self.client("owned"), self.client("inverted")
        step = self.walk(owned, inverted, frame="camera_d")
        known = lambda: self.buffer.can_transform("wall", "odom_inverted", rospy.Time.from_sec(step()))
        inverted.wait(known, "the inverted transform")
        owned.wait(lambda: step() and [s for s in said if "broadcasts the transform wall -> camera_d, and a frame can have" in s],
                   "the refusal")
        inverted.wait(known, "a transform of a pair that the other filter has answered too, after it refused")
        self.assertFalse(self.buffer.can_transform("odom_owned", "camera_d", rospy.Time(0)))
        self.assertTrue(self.buffer.can_transform("wall", "camera_d", rospy.Time(0)))


if __name__ == "__main__":
    with_tf = {"publish_odom_tf": True}
    run("odometry", OdometryTest, of_camera={"scale": "fixed", "fixed_scale": 0.5}, of_camera_again={},
        of_base=dict(with_tf, base_frame="base_c"),
        owned=dict(with_tf, odom_frame="odom_owned", publish_relative_tf=False),
        inverted=dict(with_tf, odom_frame="odom_inverted", invert_odom_tf=True, publish_relative_tf=False),
        standing={"scale": "propagate"}, nameless=with_tf, contested={}, for_an_ekf={}, twin_a={}, twin_b={})
