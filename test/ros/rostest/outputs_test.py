#!/usr/bin/env python3
"""Track ids, keypoints, triangulated points, markers, features, scale, pairs, two cameras, services and diagnostics."""
import itertools
import subprocess
import unittest

import genpy.dynamic
import numpy as np
import roslib.packages
import rospy
import sensor_msgs.point_cloud2
import tf2_ros
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseWithCovarianceStamped, TwistWithCovarianceStamped
from gms_ransac.msg import Keypoints, MatchStats, StereoFeatures
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, Image, PointCloud, PointCloud2
from std_msgs.msg import Bool
from std_srvs.srv import SetBool, Trigger
from visualization_msgs.msg import Marker, MarkerArray

from graph import STEP, Client, K, Scene, camera_info, client_of, degrees_between, image_message, run, vector, walk
from tcpros import RawPublisher

BASELINE = 0.2  # metres


class Outputs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scene = Scene()
        cls.frames = walk(5)

    def send_all(self, client, start=100.0):
        for i, frame in enumerate(self.frames):
            answer = client.ask(frame, start + 0.1 * i)
        self.assertEqual(answer.status, MatchStats.OK, answer.status_text)
        return [client.correspondence(start + 0.1 * i) for i in range(1, len(self.frames))]

    def publisher(self, client, topic, kind=Image):
        """A further publisher of this test's, connected as the client is."""
        publisher = rospy.Publisher(topic, kind, queue_size=10)
        client.connect().wait(publisher.get_num_connections, "the filter to subscribe to " + topic)
        return publisher

    def test_the_first_images_wait_for_camera_info(self):
        client = client_of("late").connect()
        for i, frame in enumerate(self.frames[:3]):
            client.image.publish(image_message(frame, 100 + 0.1 * i))
        client.info.publish(camera_info(100))
        client.answer(3)
        self.assertEqual([s.status for s in client.stats], [MatchStats.FIRST_FRAME, MatchStats.OK, MatchStats.OK])

    def test_an_image_waits_in_vain_for_camera_info_though_nothing_follows_it(self):
        client = client_of("uncalibrated", camera=False).connect()
        for i, status in enumerate((MatchStats.FIRST_FRAME, MatchStats.UNCALIBRATED)):
            self.assertEqual(client.ask(self.frames[i], 100 + 0.1 * i).status, status)

    def test_pairs_and_keypoints_carry_the_same_tracks(self):
        client, images = client_of("fixed"), []
        client.subscribe("keypoints", Keypoints, images)
        pairs = self.send_all(client.connect(), 1200.0)
        client.wait(lambda: len(images) == len(self.frames), "keypoints of every image")
        of_stamp = {image.header.stamp: image for image in images}
        for image, pair in zip(images[1:], pairs):
            before, n = of_stamp[pair.reference_header.stamp], len(image.u)
            self.assertEqual((image.header.stamp, image.header.frame_id), (pair.header.stamp, pair.header.frame_id))
            self.assertEqual((image.width, image.height, image.pixel_space, image.K), (640, 480, pair.pixel_space, pair.K))
            self.assertEqual({len(c) for c in (image.v, image.octave, image.size, image.angle, image.response, image.sigma,
                                               image.track_id)}, {n})
            self.assertEqual((len(image.descriptors), len(image.depth)), (32 * n, 0))
            # The id of a feature is in the pair with the place that it has in both images.
            places = [{i: (u, v) for i, u, v in zip(message.track_id, message.u, message.v) if i} for message in (before, image)]
            points = [{i: tuple(p) for i, p in zip(pair.track_id, np.reshape(column, (-1, 2))) if i}
                      for column in (pair.reference_points, pair.current_points)]
            # Points of the current image are its keypoints, or aligned with the reference image within three pixels.
            self.assertEqual(places[1].keys(), points[1].keys())
            self.assertLess(max(np.hypot(*np.subtract(places[1][i], at)) for i, at in points[1].items()), 4.5)
            followed = {i: at for i, at in places[0].items() if i in points[0]}
            self.assertEqual(followed, {i: points[0][i] for i in followed})
            self.assertTrue(len(followed) > 100 or before is images[0])
            self.assertGreater(min(image.sigma), 0)
            probability, sigma = np.array(pair.probability), np.array(pair.current_sigma)
            self.assertTrue(np.all((probability >= 0) & (probability <= 1)) and np.median(probability) > 0.9)
            self.assertTrue(min(pair.reference_sigma) > 0 and 0.05 < np.median(sigma) < 1, "noise of a drawn scene")
            self.assertGreater(sigma.max() / sigma.min(), 1.1, "coarse levels are less accurate")
        self.assertGreaterEqual(max(pairs[-1].track_length), 4)
        # The descriptors of a track hardly change.
        rows = [{i: d for i, d in zip(m.track_id, np.frombuffer(m.descriptors, np.uint8).reshape(-1, 32)) if i} for m in images[1:]]
        bits = [np.unpackbits(rows[0][i] ^ rows[1][i]).sum() for i in rows[0] if i in rows[1]]
        self.assertGreater(len(bits), 100)
        self.assertLess(np.median(bits), 40)

    def test_points_lie_on_the_boards(self):
        client, clouds, markers = client_of("fixed"), [], []
        client.subscribe("inlier_points", PointCloud2, clouds)
        client.subscribe("match_markers", MarkerArray, markers)
        self.send_all(client.connect(), 300.0)
        client.wait(lambda: len(clouds) == 4 and len(markers) == 5, "points of every pair and markers of every image")
        depths = np.array([board[0] for board in self.scene.boards])
        for cloud in clouds:
            self.assertEqual([f.name for f in cloud.fields], ["x", "y", "z", "intensity", "id", "rgb"])
            points = np.array(list(sensor_msgs.point_cloud2.read_points(cloud, ("x", "y", "z", "intensity"))))
            self.assertGreater(len(points), 100)
            # ~scale fixed holds the true step, so depths are metres. Four percent of the farthest board is half a pixel.
            self.assertLess(np.median(np.min(np.abs(points[:, 2:3] / depths - 1), axis=1)), 0.04)
            self.assertTrue(np.all((points[:, 3] >= 0) & (points[:, 3] <= 1)))
            colours = np.frombuffer(cloud.data, np.uint8).reshape(-1, cloud.point_step)[:, cloud.fields[5].offset:][:, :3]
            self.assertTrue(np.all(colours == colours[:, :1]), "grey as the images")
            self.assertGreater(np.ptp(colours[:, 0]), 20, "and not all the same")
        self.assertEqual(markers[-1].markers[0].action, Marker.DELETEALL)
        self.assertEqual([m.ns for m in markers[-1].markers[1:]], ["flow", "current", "reference", "names"])
        self.assertEqual(markers[-1].markers[4].text, "now", "the name of a reference this close would cover it")
        corner = vector(markers[-1].markers[2].points[1])
        self.assertTrue(0.08 * depths.min() < corner[2] < 0.15 * depths.max(), "the frustum is as large as the scene: %s" % corner)
        self.assertEqual(len(markers[-1].markers[1].points), len(markers[-1].markers[1].colors))

    def test_the_view_of_rviz_is_as_far_as_the_scene_is_deep(self):
        client, clouds, buffer = client_of("fixed"), [], tf2_ros.Buffer()
        self.addCleanup(tf2_ros.TransformListener(buffer).unregister)
        client.subscribe("inlier_points", PointCloud2, clouds)
        program = roslib.packages.find_node("gms_ransac", "view_frames.py")[0]
        process = subprocess.Popen([program, "__name:=view", "_fixed_frame:=camera",
                                    "match_markers:=fixed/match_markers", "inlier_points:=fixed/inlier_points"])
        self.addCleanup(process.wait)
        self.addCleanup(process.terminate)
        client.connect()
        stamps = itertools.count(1)

        def ahead():
            """Metres from the camera to the frame that rviz looks at; zero until the depth is known."""
            i = next(stamps)
            client.ask(self.frames[i % 2], 400 + 0.1 * i)
            try:
                view = buffer.lookup_transform("camera", "match_filter_view", rospy.Time(0)).transform
                return np.linalg.norm(vector(view.translation))
            except tf2_ros.TransformException:
                return 0

        # rviz looks at it from 4 m, and should look at the camera from 1.4 median depths.
        distance = client.wait(ahead, "a view that knows the depth")
        depths = [point[0] for point in sensor_msgs.point_cloud2.read_points(clouds[0], ("z",))]
        self.assertAlmostEqual(abs(4 - 1.4 * np.median(depths)), distance, delta=0.1 * np.median(depths))

    def test_depth_gives_metres_and_images_without_it_the_usual_length(self):
        client, start, twist, odom = client_of("depth"), 560.0, [], []
        client.subscribe("twist", TwistWithCovarianceStamped, twist)
        client.subscribe("odom", Odometry, odom)
        depth = self.publisher(client, "depth/depth/image")
        stamps = [start + 0.1 * i for i in range(10)]
        for i, stamp in enumerate(stamps):
            k = i if i < 5 else 8 - i if i < 9 else 1  # there and back
            if not 3 <= i < 6:
                metres = self.scene.depth(STEP * k) + np.float32(1e-5 * i)  # no two are the same
                depth.publish(image_message(metres, stamp + 0.004, encoding="32FC1"))
            client.send(self.frames[k], stamp)
        answers = client.wait(lambda: len(client.stats) == len(stamps) and client.stats, "every answer")
        self.assertEqual([round(m.header.stamp.to_sec(), 3) for m in answers], [round(s, 3) for s in stamps])
        for i, answer in enumerate(answers[1:], 1):  # one image with depth is enough for a pair
            self.assertEqual(answer.status, MatchStats.OK, answer.status_text)
            self.assertEqual("no length: no depth image" in answer.status_text, i in (4, 5), (i, answer.status_text))
            pair = client.correspondence(stamps[i])
            self.assertEqual((pair.pose_valid, pair.metric_scale), (True, i not in (4, 5)))
            if pair.metric_scale:
                position = vector(pair.current_in_reference.pose.position)
                self.assertLess(abs(np.linalg.norm(position) / np.linalg.norm(STEP) - 1), 0.05)
        client.wait(lambda: len(twist) == 9 and len(odom) == 10, "rotation and twist of every pair")
        lengths = np.linalg.norm(np.diff([vector(m.pose.pose.position) for m in odom], axis=0), axis=1)
        self.assertTrue(np.allclose(lengths, np.linalg.norm(STEP), rtol=0.1), lengths)

    def test_a_back_end_gets_motions_that_are_uncertain(self):
        """No pair is probable enough for a status with a pose; the messages without a probability stay silent."""
        client, poses, moved = client_of("uncertain"), [], []
        client.subscribe("relative_pose", PoseWithCovarianceStamped, poses)
        client.subscribe("twist", TwistWithCovarianceStamped, moved)
        client.subscribe("odom", Odometry, moved)
        buffer = tf2_ros.Buffer()
        self.addCleanup(tf2_ros.TransformListener(buffer).unregister)
        client.connect()
        answers = [client.ask(frame, 1300 + 0.1 * i) for i, frame in enumerate(self.frames)][1:]
        client.wait(lambda: len(poses) == 4, "a pose of every pair")
        for i, (answer, pose) in enumerate(zip(answers, poses), 1):
            pair = client.correspondence(1300 + 0.1 * i)
            self.assertEqual((answer.status, pair.pose_valid, pair.metric_scale), (MatchStats.MOTION_UNKNOWN, True, False))
            self.assertEqual(pose.pose, pair.current_in_reference)
            self.assertEqual((pose.header.stamp, pose.header.frame_id), (pair.header.stamp, "camera_reference"))
            self.assertTrue(0.9 < pair.pose_probability < 1)
            position = vector(pose.pose.pose.position)
            self.assertTrue(degrees_between(position, STEP) < 5 and abs(np.linalg.norm(position) - 1) < 1e-6)
        self.assertEqual([round(m.header.stamp.to_sec(), 3) for m in moved], [1300.0], "the origin of ~odom alone")
        self.assertFalse(buffer.can_transform("camera", "camera_reference", rospy.Time.from_sec(1300.4)))

    def test_pairs(self):
        client = Client("pair", "pair/current/image", "pair/camera_info")
        reference = self.publisher(client, "pair/reference/image")
        for i in range(3):
            reference.publish(image_message(self.frames[0], 600 + i))
            client.send(self.frames[1 + i], 600 + i + 0.005)
        reference.publish(image_message(self.frames[0], 604))  # lets the synchroniser settle what came before
        client.send(self.frames[1], 604.0)
        client.wait(lambda: len(client.correspondences) >= 3, "pairs")
        for message in client.correspondences[:3]:
            self.assertAlmostEqual((message.header.stamp - message.reference_header.stamp).to_sec(), 0.005, 3)
            self.assertLess(degrees_between(vector(message.current_in_reference.pose.position), STEP), 5)

    def test_two_cameras(self):
        """~stereo_features need no keypoints of the right image, which the next subscriber gets metres from."""
        client, raw = Client("stereo", "stereo/left/image", "stereo/left/camera_info", listen=False), []
        client.subscribe("stereo_features", rospy.AnyMsg, raw)
        right = self.publisher(client, "stereo/right/image")
        calibration = camera_info(0)
        calibration.P = calibration.P[:3] + [-K[0, 0] * BASELINE] + calibration.P[4:]
        self.publisher(client, "stereo/right/camera_info", CameraInfo).publish(calibration)

        def send(i):
            right.publish(image_message(self.scene.draw(t=STEP * i + (BASELINE, 0, 0)), 1250 + 0.1 * i))
            client.send(self.frames[i], 1250 + 0.1 * i)

        for i in range(4):
            send(i)
            client.wait(lambda: len(raw) == i, "features")
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
        client.listen()
        client.connect()
        send(4)
        pair = client.correspondence(1250.4)
        self.assertTrue(pair.metric_scale)
        length = np.linalg.norm(vector(pair.current_in_reference.pose.position))
        self.assertLess(abs(length / np.linalg.norm(STEP) - 1), 0.03)

    def test_features_in_the_layout_of_lvi_sam(self):
        """Images that carry no message are passed over while nothing else has a subscriber. Depth of the left half alone."""
        client, clouds = client_of("lvi", listen=False), []
        client.subscribe("features", PointCloud, clouds)
        depth = self.publisher(client, "lvi/depth/image")
        metres = np.full((480, 640), np.nan, np.float32)
        metres[:, :320] = 3
        stamps = iter(100 + 0.05 * np.arange(100))

        def send(i):
            stamp = next(stamps)
            metres[:, 320:] = (np.nan, 0)[i % 2]  # unknown, but no copy
            depth.publish(image_message(metres, stamp, encoding="32FC1"))
            client.send(self.scene.draw(t=0.2 * STEP * i), stamp)

        for i in range(10):
            send(i)
        client.wait(lambda: len(clouds) == 5, "features of every second image")
        self.assertEqual([round((c.header.stamp.to_sec() - 100) / 0.05) for c in clouds], [1, 3, 5, 7, 9])
        for cloud in clouds:
            columns = {channel.name: np.array(channel.values) for channel in cloud.channels}
            left = np.rint(columns["u"]) < 320
            self.assertTrue(20 < np.count_nonzero(left) < len(left) - 20)
            self.assertEqual((set(columns["depth"][left]), set(columns["depth"][~left])), ({3.0}, {-1.0}))
        client.listen()
        client.connect()
        for i in range(10, 13):
            send(i)
            answer = client.answer(i - 9)
            self.assertEqual((answer.frames_received, answer.frames_processed, answer.frames_passed_over), (i + 1, i - 3, 4))
        self.assertGreater(answer.feature_age_p90, 0.2)
        self.assertGreaterEqual(answer.track_length_p90, answer.track_length_median)

    def test_reset_and_pause(self):
        client, restarts = client_of("mono"), []
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
        client, reports = client_of("fixed"), []
        client.subscribers.append(rospy.Subscriber("/diagnostics", DiagnosticArray, lambda m: reports.extend(m.status)))
        self.send_all(client.connect(), 800.0)

        def report(task, condition):
            return lambda: [s for s in reports if s.name.endswith(task) and "fixed" in s.name and condition(s)]

        client.wait(report("matches", lambda s: "agree" in s.message and any(v.key == "inlier ratio" for v in s.values)), "matches")
        client.wait(report("timing", lambda s: {"rate (Hz)", "latency (ms)", "dropped"} <= {v.key for v in s.values}), "timing")
        client.wait(report("input", lambda s: "/fixed/image" in s.message and s.level == 1), "the silent topic's name")
        stamps = iter(810 + 0.1 * np.arange(1000))

        def warned(words, **info):
            """What the input is warned of while images come with such a camera_info."""
            stamp = next(stamps)
            client.ask(self.frames[round(10 * stamp) % 5], stamp, info=camera_info(stamp, **info))
            return report("input", lambda s: words in s.message and s.level == 1)()

        client.wait(lambda: warned("is for 400x300 images", size=(400, 300)), "the size of camera_info")
        beside = K + np.array([[0, 0, 280], [0, 0, 0], [0, 0, 0]])
        client.wait(lambda: warned("% of the width", k=beside, p=beside), "the doubt of the matrix")
        other = RawPublisher("/another_camera", rospy.resolve_name("fixed/image"), Image)
        client.wait(lambda: warned("2 nodes publish /fixed/image"), "both publishers")
        other.close()
        # Simulated time goes by steps, and may be behind the stamp.
        self.assertEqual(client.ask(self.frames[0], 4e9).latency, 0)


if __name__ == "__main__":
    run("outputs", Outputs, mono={"always_subscribe": True}, fixed={"scale": "fixed", "fixed_scale": 0.158114},
        depth={"scale": "depth"}, pair={"input": "pair"}, lvi={"scale": "depth", "feature_layout": "lvi_sam"}, late={}, uncalibrated={},
        uncertain={"publish_uncertain": True, "min_pose_probability": 1.0, "min_rotation_probability": 1.0},
        stereo={"input": "stereo", "feature_rate": 0, "stereo_features_type": "msckf_vio/CameraMeasurement"})
