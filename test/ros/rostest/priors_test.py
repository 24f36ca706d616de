#!/usr/bin/env python3
"""What other sensors say of the motion: a gyro that is right, mirrored or late, one beside a rolling shutter, wheels that
roll or slip, tf; and the ground, on a real road."""
import os
import unittest

import cv2
import numpy as np
import rospy
import tf2_ros
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseWithCovarianceStamped, TransformStamped
from gms_ransac.msg import MatchStats
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu

from graph import HEIGHT, WIDTH, Scene, camera_info, client_of, data_folder, run, said_by, vector

PERIOD, STILL, MOVING = 1 / 30.0, 8, 80  # seconds; images before and while the camera moves
RATE = 200.0  # Hz, of the gyro
BIAS = np.array([0.02, -0.03, 0.01])  # rad/s, in the gyro's axes
LATE = 0.05  # seconds
TO_IMU = np.array([[0.0, 0, 1], [-1, 0, 0], [0, -1, 0]])  # camera axes in imu_link
START = 100.0
READOUT, BANDS = 0.02, 12  # seconds from the first row to the last, which are drawn in bands


def turn(seconds):
    """Rotation vector of the camera in the world: a hand that shakes about all axes."""
    t = max(0.0, seconds)
    return 0.05 * np.array([np.sin(6 * t), 1.2 * np.sin(8.1 * t), 0.8 * np.sin(10.3 * t)])


def place(seconds):
    t = max(0.0, seconds)
    return np.array([0.5 * t, 0.1 * t, 0.0])


def rate(seconds):
    """rad/s in the camera's own axes."""
    step = 1e-4
    R = [cv2.Rodrigues(turn(seconds + d))[0] for d in (-step, step)]
    return cv2.Rodrigues(R[0].T @ R[1])[0].ravel() / (2 * step)


def quaternion(R):
    v = cv2.Rodrigues(R)[0].ravel()
    angle = np.linalg.norm(v)
    axis = v / angle if angle > 0 else v
    return (*(np.sin(angle / 2) * axis), np.cos(angle / 2))


def fill(pose, R, t):
    pose.position.x, pose.position.y, pose.position.z = t
    q = pose.orientation
    q.x, q.y, q.z, q.w = quaternion(R)


class PriorsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        scene = Scene()
        cls.times = [PERIOD * (i - STILL) for i in range(STILL + MOVING)]  # seconds since it started to move
        cls.frames = [scene.draw(t=place(s), r=turn(s)) for s in cls.times]
        cls.reports = []
        cls.listening = rospy.Subscriber("/diagnostics", DiagnosticArray, cls.reports.append)
        cls.log = said_by()
        # imu_link and base_link look ahead, left and up; the camera looks ahead.
        mount = TransformStamped()
        mount.header.frame_id, mount.child_frame_id = "imu_link", "camera"
        q = mount.transform.rotation
        q.x, q.y, q.z, q.w = quaternion(TO_IMU)
        cls.static = tf2_ros.StaticTransformBroadcaster()
        cls.static.sendTransform(mount)

    def stamp(self, seconds):
        return START + STILL * PERIOD + seconds

    def connect(self, name, topic, kind):
        """A client, and a publisher of a sensor, to both of which the filter listens."""
        client, sensor = client_of(name), rospy.Publisher(name + "/" + topic, kind, queue_size=2000)
        client.connect().wait(sensor.get_num_connections, "the filter to want " + topic)
        return client, sensor

    def send_gyro(self, publisher, start, end, axes=(1, 1, 1), bias=(0, 0, 0), late=0):
        for i in range(int((end - start) * RATE)):
            seconds = start + i / RATE
            message = Imu()
            message.header.frame_id = "imu_link"
            message.header.stamp = rospy.Time.from_sec(self.stamp(seconds) + late)
            w = message.angular_velocity
            w.x, w.y, w.z = TO_IMU @ rate(seconds) * axes + bias
            publisher.publish(message)

    def said(self, name, words):
        """The values beside the last such summary; None: there is none."""
        values = [{v.key: v.value for v in s.values} for report in self.reports for s in report.status
                  if s.name.strip("/").startswith(name + ": priors") and words in s.message]
        return values[-1] if values else None

    def test_gyro(self):
        """One camera, three gyros: a good one, one with an axis mirrored, and one whose stamps are late."""
        clients, gyros = {}, {}
        for name, options in (("gyro", {}), ("mirrored", {"axes": (1, -1, 1)}), ("late", {"late": LATE})):
            clients[name], gyros[name] = self.connect(name, "imu", Imu)
            self.send_gyro(gyros[name], self.times[0] - 0.05, self.times[-1] + 0.15, bias=BIAS, **options)
        for seconds, frame in zip(self.times, self.frames):
            for client in clients.values():
                client.send(frame, self.stamp(seconds))
        for name, client in clients.items():
            client.answer(len(self.frames), name)
            for stats in client.stats[1:]:
                self.assertIn(stats.status, (MatchStats.OK, MatchStats.LOW_PARALLAX), stats.status_text)
        sender = clients["gyro"]
        for stats in sender.stats[2:]:
            self.assertNotIn("no rotation prior", stats.status_text)
        # A wrong prior takes nothing away.
        good, wrong = ([s.inliers for s in clients[name].stats[1:]] for name in ("gyro", "mirrored"))
        self.assertGreater(np.sum(wrong), 0.99 * np.sum(good))

        def numbers(text):
            return [float(x) for x in text.split(", standard")[0].strip("()").split(",")]

        for name, late in (("gyro", 0), ("late", LATE)):
            values = sender.wait(lambda: self.said(name, "agrees"), "a gyro that agrees")
            self.assertAlmostEqual(numbers(values["~image_time_offset (s)"])[0], late, delta=0.003)
            bias = TO_IMU @ numbers(values["bias about the camera's axes (rad/s)"])
            self.assertLess(np.abs(bias - BIAS).max(), 0.02)
        sender.wait(lambda: self.said("mirrored", "its axes explain it"), "the mirrored axis")
        sender.wait(lambda: any("stamps of /late/imu are 0.0" in line for line in self.log), "the time offset in the log")
        self.assertFalse([line for line in self.log if "/gyro/imu" in line or "/mirrored/imu" in line])

        # The gyro falls silent: answered all the same, and said.
        text = sender.ask(self.frames[0], self.stamp(self.times[-1] + 0.5)).status_text
        self.assertIn("no rotation prior: the newest sample is", text)
        self.assertIn("/gyro/imu", text)

        message = Imu()
        message.header.frame_id, message.angular_velocity.z = "imu_link", float("nan")
        self.refused(sender, "gyro/imu", gyros["gyro"], message, self.times[-1] + 0.5)

    def refused(self, client, topic, sensor, message, after):
        """The sensor sends this message, whose numbers are impossible: answered all the same, and said."""
        stamps = iter(self.stamp(after) + PERIOD * np.arange(1, 1000))

        def reason():
            message.header.stamp = rospy.Time.from_sec(next(stamps))
            sensor.publish(message)
            return client.ask(self.frames[0], message.header.stamp.to_sec()).status_text

        client.wait(lambda: "messages on /%s are not used: their numbers are not finite" % topic in reason(), "the reason")

    def roll(self, scene, seconds):
        """What a camera sees that reads its middle row at that time."""
        picture = np.empty((HEIGHT, WIDTH), np.uint8)
        rows = HEIGHT // BANDS
        for band in range(BANDS):
            time = seconds + READOUT * ((band + 0.5) / BANDS - 0.5)
            picture[band * rows:(band + 1) * rows] = scene.draw(t=place(time), r=turn(time))[band * rows:(band + 1) * rows]
        return picture

    def test_rolling_shutter(self):
        client, gyro = self.connect("rolling", "imu", Imu)
        times, scene = self.times[STILL:STILL + 14], Scene()
        self.send_gyro(gyro, -0.05, times[-1] + 0.15)
        for seconds in times:
            text = client.ask(self.roll(scene, seconds), self.stamp(seconds)).status_text
            self.assertNotIn("no rotation prior", text)

        def turned():
            values = self.said("rolling", "")
            return values and int(values["pairs corrected for readout"]) > len(times) / 2
        client.wait(turned, "rows that the gyro turned")

    def send_wheels(self, publisher, seconds, slip=False):
        message = Odometry()
        message.header.stamp = rospy.Time.from_sec(self.stamp(seconds))
        message.header.frame_id, message.child_frame_id = "odom", "imu_link"
        camera = cv2.Rodrigues(turn(seconds))[0]
        fill(message.pose.pose, TO_IMU @ camera @ TO_IMU.T, TO_IMU @ place(0 if slip else seconds))
        publisher.publish(message)

    def test_wheels(self):
        (client, odometry), poses = self.connect("wheels", "prior_odom", Odometry), []
        client.subscribe("relative_pose", PoseWithCovarianceStamped, poses)
        client.connect()
        self.send_wheels(odometry, self.times[STILL] - PERIOD)
        chosen = range(STILL, STILL + 30, 3)
        for i in chosen:
            self.send_wheels(odometry, self.times[i])
            text = client.ask(self.frames[i], self.stamp(self.times[i])).status_text
            self.assertNotIn("no length", text)
            self.assertNotIn("no rotation prior", text)
        client.wait(lambda: len(poses) >= len(chosen) - 1, "poses")
        truth = np.linalg.norm(place(3 * PERIOD))
        moved = [p for p in poses if np.linalg.norm(vector(p.pose.pose.position)) > 0]
        self.assertGreater(len(moved), len(chosen) // 2)
        for pose in moved:
            t = vector(pose.pose.pose.position)
            self.assertAlmostEqual(np.linalg.norm(t), truth, delta=0.01 * truth)
            C = np.array(pose.pose.covariance).reshape(6, 6)[:3, :3]
            along = t / np.linalg.norm(t)
            self.assertAlmostEqual(np.sqrt(along @ C @ along), 0.03 * truth, delta=0.02 * truth)
        # After a loss the wheels still measure: the length is not missing.
        lost, found = chosen[-1] + 1, chosen[-1] + 2
        client.ask(np.zeros_like(self.frames[0]), self.stamp(self.times[lost]))
        self.send_wheels(odometry, self.times[found])
        answer = client.ask(self.frames[found], self.stamp(self.times[found]))
        self.assertEqual(answer.status, MatchStats.RECOVERED, answer.status_text)
        self.assertNotIn("length", answer.status_text)
        self.send_wheels(odometry, self.times[found] + 0.001, slip=True)
        last = self.times[chosen[-1] + 5]
        self.send_wheels(odometry, last, slip=True)
        # From standing to standing is what it says: the camera moved all the same.
        client.ask(self.frames[chosen[-1] + 3], self.stamp(self.times[chosen[-1] + 3]))
        text = client.ask(self.frames[chosen[-1] + 5], self.stamp(last)).status_text
        self.assertIn("no length: by the odometry the camera stood", text)
        message = Odometry()
        message.header.frame_id, message.child_frame_id = "odom", "imu_link"
        message.pose.pose.orientation.w, message.pose.pose.position.x = 1, float("nan")
        self.refused(client, "wheels/prior_odom", odometry, message, self.times[chosen[-1] + 5])

    def test_tf(self):
        client = client_of("by_tf").connect()
        broadcaster = tf2_ros.TransformBroadcaster()
        client.wait(lambda: broadcaster.pub_tf.get_num_connections() >= 6, "all six filters to listen to tf")
        for i in range(STILL, STILL + 9, 3):
            message = TransformStamped()
            message.header.stamp = rospy.Time.from_sec(self.stamp(self.times[i]))
            message.header.frame_id, message.child_frame_id = "map", "camera_t"
            q = message.transform.rotation
            q.x, q.y, q.z, q.w = quaternion(cv2.Rodrigues(turn(self.times[i]))[0])
            broadcaster.sendTransform(message)
            text = client.ask(self.frames[i], self.stamp(self.times[i]), frame="camera_t").status_text
            self.assertNotIn("no rotation prior", text)
        text = client.ask(self.frames[i + 3], self.stamp(self.times[i + 3]), frame="camera_t").status_text
        self.assertIn("no rotation prior: tf does not know camera_t in map", text)
        text = client.ask(self.frames[i + 6], self.stamp(self.times[i + 6]), frame="unheard_of").status_text
        self.assertIn("the frame_id changed from 'camera_t' to 'unheard_of'", text)
        text = client.ask(self.frames[i + 7], self.stamp(self.times[i + 7]), frame="unheard_of").status_text
        self.assertIn("no rotation prior: tf does not know unheard_of in map: no transform names unheard_of", text)

    def test_ground(self):
        folder = data_folder("kitti_06")
        if folder is None:
            self.skipTest("no kitti_06")
        with open(os.path.join(folder, "calib.txt")) as calibration:
            P = np.array([float(x) for x in calibration.readline().split()[1:]]).reshape(3, 4)
        truth = np.loadtxt(os.path.join(folder, "poses.txt")).reshape(-1, 3, 4)[:, :, 3]
        client, poses = client_of("ground"), []
        client.subscribe("relative_pose", PoseWithCovarianceStamped, poses)
        client.connect()
        count = 20
        for i in range(count):
            image = cv2.imread(os.path.join(folder, "image_0", "%06d.png" % i), cv2.IMREAD_GRAYSCALE)
            info = camera_info(START + 0.1 * i, k=P[:, :3], size=image.shape[::-1])
            text = client.ask(image, START + 0.1 * i, info=info).status_text
            self.assertNotIn("no length", text)
        client.wait(lambda: len(poses) >= count - 1, "poses")
        lengths = np.array([np.linalg.norm(vector(p.pose.pose.position)) for p in poses])
        errors = lengths / np.linalg.norm(np.diff(truth[:count], axis=0), axis=1) - 1
        self.assertLess(np.median(np.abs(errors)), 0.05)
        self.assertLess(np.abs(errors).max(), 0.12)


if __name__ == "__main__":
    GYRO = {"rotation_prior": "imu", "publish_relative_tf": False, "queue_size": 200}
    run("priors", PriorsTest, gyro=GYRO, mirrored=GYRO, late=GYRO, rolling=dict(GYRO, rolling_shutter_readout=0.02),
        wheels={"rotation_prior": "odom", "scale": "odometry", "recovery_frames": 3}, by_tf={"rotation_prior": "tf", "prior_frame": "map"},
        ground={"scale": "ground", "camera_height": 1.65})  # metres above a road
