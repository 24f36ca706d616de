#!/usr/bin/env python3
"""Track ids, triangulated points, markers, scale, pairs, services and diagnostics."""
import unittest

import genpy.dynamic
import numpy as np
import rospy
import rostest
import sensor_msgs.point_cloud2
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TwistWithCovarianceStamped
from gms_ransac.msg import Keypoints, MatchStats, StereoFeatures
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, Image, PointCloud2
from std_msgs.msg import Bool
from std_srvs.srv import SetBool, Trigger
from visualization_msgs.msg import MarkerArray

from graph import Client, K, Scene, camera_info, degrees_between, image_message, vector

STEP = np.array((0.15, 0.05, 0.0))
BASELINE = 0.2  # metres


class Outputs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scene = Scene()
        cls.frames = [cls.scene.draw(t=STEP * i) for i in range(5)]

    def client(self, name):
        return Client(name, name + "/image", name + "/camera_info")

    def send_all(self, client, start=100.0):
        for i, frame in enumerate(self.frames):
            answer = client.ask(frame, start + 0.1 * i)
        self.assertEqual(answer.status, MatchStats.OK, answer.status_text)
        return [client.correspondence(start + 0.1 * i) for i in range(1, len(self.frames))]

    def test_the_first_images_wait_for_camera_info(self):
        client = self.client("late").connect()
        for i, frame in enumerate(self.frames[:3]):
            client.image.publish(image_message(frame, 100 + 0.1 * i))
        client.info.publish(camera_info(100))
        client.answer(3)
        self.assertEqual([s.status for s in client.stats], [MatchStats.FIRST_FRAME, MatchStats.OK, MatchStats.OK])

    def test_an_image_waits_in_vain_for_camera_info_though_nothing_follows_it(self):
        client = Client("uncalibrated", "uncalibrated/image", camera=False).connect()
        for i, status in enumerate((MatchStats.FIRST_FRAME, MatchStats.UNCALIBRATED)):
            self.assertEqual(client.ask(self.frames[i], 100 + 0.1 * i).status, status)

    def test_track_ids_persist(self):
        pairs = self.send_all(self.client("mono").connect())
        for before, after in zip(pairs, pairs[1:]):
            self.assertEqual(before.header.stamp, after.reference_header.stamp)
            where = {i: p for i, p in zip(before.track_id, np.reshape(before.current_points, (-1, 2))) if i}
            ids = [i for i in after.track_id if i]
            self.assertEqual(len(ids), len(set(ids)), "one feature, one id")
            shared = [(where[i], p) for i, p in zip(after.track_id, np.reshape(after.reference_points, (-1, 2))) if i in where]
            self.assertGreater(len(shared), 100)
            for was, is_now in shared:
                self.assertTrue(np.allclose(was, is_now), "the same keypoint")
        self.assertGreaterEqual(max(pairs[-1].track_length), 4)
        self.assertGreaterEqual(min(n for i, n in zip(pairs[-1].track_id, pairs[-1].track_length) if i), 2)

    def test_matches_carry_probability_and_noise(self):
        for pair in self.send_all(self.client("mono").connect(), 150.0):
            probability, reference, current = (np.array(c) for c in (pair.probability, pair.reference_sigma, pair.current_sigma))
            for column in (probability, reference, current):
                self.assertEqual(len(column), len(pair.confidence))
            self.assertTrue(np.all((probability >= 0) & (probability <= 1)))
            self.assertGreater(np.median(probability), 0.9)
            self.assertTrue(np.all(reference > 0) and np.all(current > 0))
            self.assertTrue(0.05 < np.median(current) < 1, "noise of a drawn scene")
            self.assertGreater(reference.max() / reference.min(), 1.1, "coarse levels are less accurate")

    def test_points_lie_on_the_boards(self):
        client, clouds, markers = self.client("fusion"), [], []
        client.subscribe("inlier_points", PointCloud2, clouds)
        client.subscribe("match_markers", MarkerArray, markers)
        self.send_all(client.connect(), 300.0)
        client.wait(lambda: len(clouds) == 4 and len(markers) == 4, "points and markers of every pair")
        depths = np.array([board[0] for board in self.scene.boards])
        for cloud in clouds:
            self.assertEqual([f.name for f in cloud.fields], ["x", "y", "z", "intensity", "id"])
            points = np.array(list(sensor_msgs.point_cloud2.read_points(cloud, ("x", "y", "z", "intensity"))))
            self.assertGreater(len(points), 100)
            # ~scale fixed holds the true step, so depths are metres.
            off = np.min(np.abs(points[:, 2:3] / depths - 1), axis=1)
            # Four percent of the farthest board is half a pixel of disparity.
            self.assertLess(np.median(off), 0.04)
            self.assertTrue(np.all((points[:, 3] >= 0) & (points[:, 3] <= 1)))
        self.assertEqual([m.ns for m in markers[-1].markers], ["flow", "current", "reference"])
        self.assertEqual(len(markers[-1].markers[0].points), len(markers[-1].markers[0].colors))

    def test_depth_in_metres(self):
        start = 400.0
        client = self.client("depth")
        depth = rospy.Publisher("depth/depth", Image, queue_size=10)
        client.connect()
        client.wait(depth.get_num_connections, "the filter to subscribe to depth")
        for i, frame in enumerate(self.frames):
            depth.publish(image_message(self.scene.depth(STEP * i), start + 0.1 * i + 0.004, encoding="32FC1"))
            client.send(frame, start + 0.1 * i)
        client.wait(lambda: [m for m in client.correspondences if m.header.stamp.to_sec() > start + 0.25], "pairs with depth")
        lengths = []
        for message in client.correspondences:
            if message.header.stamp.to_sec() > start and message.pose_valid:
                self.assertTrue(message.metric_scale)
                position = vector(message.current_in_reference.pose.position)
                lengths.append(np.linalg.norm(position))
                self.assertLess(degrees_between(position, STEP), 3)
        self.assertGreater(len(lengths), 1)
        self.assertLess(abs(np.median(lengths) / np.linalg.norm(STEP) - 1), 0.02)

    def test_depth_of_another_size_costs_the_length_alone(self):
        client, start = self.client("depth"), 550.0
        depth = rospy.Publisher("depth/depth", Image, queue_size=10)
        client.connect()
        client.wait(depth.get_num_connections, "the filter to subscribe to depth")
        for i, frame in enumerate(self.frames):
            depth.publish(image_message(self.scene.depth(STEP * i)[::2, ::2].copy(), start + 0.1 * i, encoding="32FC1"))
            client.send(frame, start + 0.1 * i)
        client.wait(lambda: [m for m in client.stats if m.header.stamp.to_sec() > start + 0.25], "pairs with wrong depth")
        answers = [m for m in client.stats if m.header.stamp.to_sec() > start + 0.05]
        for answer in answers:
            self.assertEqual(answer.status, MatchStats.OK)
            self.assertIn("no length: the depth image is 320x240, but the image is 640x480", answer.status_text)
        self.assertGreater(len(answers), 1)
        for answer in answers:
            message = client.correspondence(answer.header.stamp.to_sec())
            self.assertTrue(message.pose_valid)
            self.assertFalse(message.metric_scale)

    def test_images_without_depth_are_answered_without_a_length(self):
        client, start, twist, odom = self.client("depth"), 560.0, [], []
        client.subscribe("twist", TwistWithCovarianceStamped, twist)
        client.subscribe("odom", Odometry, odom)
        depth = rospy.Publisher("depth/depth", Image, queue_size=10)
        client.connect()
        client.wait(depth.get_num_connections, "the filter to subscribe to depth")
        stamps = [start + 0.1 * i for i in range(10)]
        for i, stamp in enumerate(stamps):
            k = i if i < 5 else 8 - i if i < 9 else 1  # there and back
            if not 3 <= i < 6:
                depth.publish(image_message(self.scene.depth(STEP * k), stamp, encoding="32FC1"))
            client.send(self.frames[k], stamp)
        client.wait(lambda: any(abs(m.header.stamp.to_sec() - stamps[-1]) < 1e-6 for m in client.stats), "the last answer")
        answers = [m for m in client.stats if m.header.stamp.to_sec() > start - 0.05]
        self.assertEqual([round(m.header.stamp.to_sec(), 3) for m in answers], [round(s, 3) for s in stamps])
        for i, answer in enumerate(answers[1:], 1):  # one image with depth is enough for a pair
            self.assertEqual(answer.status, MatchStats.OK, answer.status_text)
            self.assertEqual("no length: no depth image" in answer.status_text, i in (4, 5), (i, answer.status_text))
        client.wait(lambda: len(twist) == 9 and len(odom) == 9, "rotation and twist of every pair")
        lengths = np.linalg.norm(np.diff([vector(m.pose.pose.position) for m in odom], axis=0), axis=1)
        self.assertTrue(np.allclose(lengths, np.linalg.norm(STEP), rtol=0.1), lengths)

    def test_pairs(self):
        client = Client("pair", "pair/current", "pair/camera_info")
        reference = rospy.Publisher("pair/reference", Image, queue_size=10)
        client.connect()
        client.wait(reference.get_num_connections, "the filter to subscribe to the reference")
        for i in range(3):
            stamp = 600 + i
            reference.publish(image_message(self.frames[0], stamp))
            client.send(self.frames[1 + i], stamp + 0.005)
        reference.publish(image_message(self.frames[0], 604))  # lets the synchroniser settle what came before
        client.send(self.frames[1], 604.0)
        client.wait(lambda: len(client.correspondences) >= 3, "pairs")
        for message in client.correspondences[:3]:
            self.assertAlmostEqual((message.header.stamp - message.reference_header.stamp).to_sec(), 0.005, 3)
            self.assertLess(degrees_between(vector(message.current_in_reference.pose.position), STEP), 5)

    def test_keypoints_are_what_the_correspondences_are_made_of(self):
        client, images = self.client("mono"), []
        client.subscribe("keypoints", Keypoints, images)
        pairs = self.send_all(client.connect(), 1200.0)
        client.wait(lambda: len(images) == len(self.frames), "keypoints of every image")
        for image, pair in zip(images[1:], pairs):
            n = len(image.u)
            self.assertEqual((image.header.stamp, image.header.frame_id), (pair.header.stamp, pair.header.frame_id))
            self.assertEqual((image.width, image.height, image.pixel_space, image.K), (640, 480, pair.pixel_space, pair.K))
            self.assertEqual({len(c) for c in (image.v, image.octave, image.size, image.angle, image.response, image.sigma,
                                               image.track_id)}, {n})
            self.assertEqual((len(image.descriptors), len(image.depth)), (32 * n, 0))
            where = {i: (u, v) for i, u, v in zip(image.track_id, image.u, image.v) if i}
            self.assertEqual(where, {i: tuple(p) for i, p in zip(pair.track_id, np.reshape(pair.current_points, (-1, 2))) if i})
            self.assertGreater(min(image.sigma), 0)
        # The descriptors of a track hardly change.
        rows = [{i: d for i, d in zip(m.track_id, np.frombuffer(m.descriptors, np.uint8).reshape(-1, 32)) if i} for m in images[1:]]
        bits = [np.unpackbits(rows[0][i] ^ rows[1][i]).sum() for i in rows[0] if i in rows[1]]
        self.assertGreater(len(bits), 100)
        self.assertLess(np.median(bits), 40)

    def stereo(self, listen):
        """A client, a function that sends it an image with that of the right camera, and its ~stereo_features."""
        client, raw = Client("stereo", "stereo/left/image", "stereo/left/camera_info", listen=listen), []
        right = rospy.Publisher("stereo/right/image", Image, queue_size=10)
        right_info = rospy.Publisher("stereo/right/camera_info", CameraInfo, queue_size=10)
        client.subscribe("stereo_features", rospy.AnyMsg, raw)
        client.connect()
        client.wait(lambda: right.get_num_connections() and right_info.get_num_connections(), "the filter to listen to the right")
        calibration = camera_info(0)
        calibration.P = calibration.P[:3] + [-K[0, 0] * BASELINE] + calibration.P[4:]
        right_info.publish(calibration)

        def send(i, start, ask):
            right.publish(image_message(self.scene.draw(t=STEP * i + (BASELINE, 0, 0)), start + 0.1 * i))
            return (client.ask if ask else client.send)(self.frames[i], start + 0.1 * i)

        return client, send, raw

    def check_stereo_features(self, raw):
        # Under the name that msckf_vio has for the fields; a bag or a tool reads them by the definition that comes along.
        header = raw[0]._connection_header
        self.assertEqual((header["type"], header["md5sum"]), ("msckf_vio/CameraMeasurement", StereoFeatures._md5sum))
        kinds = genpy.dynamic.generate_dynamic(header["type"], header["message_definition"])
        for message in raw:
            features = kinds[header["type"]]().deserialize(message._buff).features
            disparity = np.array([f.u0 - f.u1 for f in features])
            rows = np.array([f.v0 - f.v1 for f in features])
            self.assertGreater(len(rows), 100)
            self.assertLess(np.median(np.abs(rows)) * K[0, 0], 0.5)
            depths = np.array([board[0] for board in self.scene.boards])
            off = np.min(np.abs(BASELINE / disparity[:, None] / depths - 1), axis=1)
            self.assertLess(np.median(off), 0.04)

    def check_metres(self, client, stamps):
        pairs = [client.correspondence(stamp) for stamp in stamps]
        self.assertTrue(all(pair.metric_scale for pair in pairs))
        lengths = [np.linalg.norm(vector(pair.current_in_reference.pose.position)) for pair in pairs]
        self.assertLess(abs(np.median(lengths) / np.linalg.norm(STEP) - 1), 0.03, lengths)

    def test_two_cameras_see_metres(self):
        client, send, raw = self.stereo(listen=True)
        for i in range(len(self.frames)):
            answer = send(i, 1300, ask=True)
        self.assertEqual(answer.status, MatchStats.OK, answer.status_text)
        self.check_metres(client, [1300 + 0.1 * i for i in range(1, len(self.frames))])
        client.wait(lambda: len(raw) == len(self.frames) - 1, "features")
        self.check_stereo_features(raw)

    def test_stereo_features_alone(self):
        """They are the same without the keypoints of the right image, which the next subscriber gets metres from."""
        client, send, raw = self.stereo(listen=False)
        for i in range(4):
            send(i, 1250, ask=False)
            client.wait(lambda: len(raw) == i, "features")
        self.check_stereo_features(raw)
        client.listen()
        client.connect()
        self.assertEqual(send(4, 1250, ask=True).status, MatchStats.OK)
        self.check_metres(client, [1250.4])

    def test_reset_and_pause(self):
        client, restarts = self.client("mono"), []
        client.subscribe("restart", Bool, restarts)
        self.send_all(client.connect(), 700.0)
        last_id = max(client.correspondences[-1].track_id)
        for service in ("reset", "pause"):
            rospy.wait_for_service("mono/" + service)
        self.assertTrue(rospy.ServiceProxy("mono/reset", Trigger)().success)
        answer = client.ask(self.frames[0], 701.0)
        self.assertEqual(answer.status, MatchStats.FIRST_FRAME)
        client.wait(lambda: restarts and restarts[-1].data, "~restart")
        client.ask(self.frames[1], 701.1)
        self.assertGreater(min(i for i in client.correspondence(701.1).track_id if i), last_id, "ids are not used twice")

        pause = rospy.ServiceProxy("mono/pause", SetBool)
        self.assertTrue(pause(True).success)
        client.wait(lambda: client.image.get_num_connections() == 0, "the end of the subscription")
        self.assertTrue(pause(False).success)
        client.wait(lambda: client.image.get_num_connections() == 1, "the subscription")
        self.assertEqual(client.ask(self.frames[1], 702.0).status, MatchStats.FIRST_FRAME)

    def test_diagnostics(self):
        client, reports = self.client("fusion"), []
        client.subscribers.append(rospy.Subscriber("/diagnostics", DiagnosticArray, lambda m: reports.extend(m.status)))
        self.send_all(client.connect(), 800.0)

        def report(task, condition):
            return lambda: [s for s in reports if s.name.endswith(task) and "fusion" in s.name and condition(s)]

        client.wait(report("matches", lambda s: "agree" in s.message and any(v.key == "inlier ratio" for v in s.values)), "matches")
        client.wait(report("timing", lambda s: {"rate (Hz)", "latency (ms)", "dropped"} <= {v.key for v in s.values}), "timing")
        client.wait(report("input", lambda s: "/fusion/image" in s.message and s.level == 1), "the silent topic's name")

    def test_a_wrong_focal_length_is_doubted(self):
        client, reports = self.client("mono"), []
        client.subscribers.append(rospy.Subscriber("/diagnostics", DiagnosticArray, lambda m: reports.extend(m.status)))
        client.connect()
        # Nodding while moving sideways: where the optical axes lie in one plane, the focal length does not show.
        there_and_back = [self.scene.draw(t=(shift, 0, 0), r=(angle, 0, 0)) for shift, angle in ((0, -0.08), (0.5, 0.08))]
        wrong = np.array(K)
        wrong[0, 0] = wrong[1, 1] = 1.05 * K[0, 0]
        for i in range(62):
            answer = client.ask(there_and_back[i % 2], 1100 + 0.1 * i, info=camera_info(0, k=wrong))
        self.assertGreater(answer.camera_misfit, 1)

        def doubted(text):
            return "in the same way, as if " in text and "fx and fy of camera_info on /mono/camera_info" in text

        client.wait(lambda: any(doubted(s.message) and s.level == 1 for s in reports), "a word in diagnostics")



if __name__ == "__main__":
    rospy.init_node("outputs_test")
    rostest.rosrun("gms_ransac", "outputs", Outputs)
