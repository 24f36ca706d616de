#!/usr/bin/env python3
"""What other sensors say of the motion: a gyro that is right, mirrored or late, one beside a rolling shutter, wheels that
roll or slip, tf; and the ground, on a real road."""
import os
import unittest

import cv2
import numpy as np
import rospy
import rostest
import tf2_ros
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseWithCovarianceStamped, TransformStamped
from gms_ransac.msg import MatchStats
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu

from graph import HEIGHT, WIDTH, Client, Scene, camera_info, data_folder, vector

PERIOD, STILL, MOVING = 1 / 30.0, 8, 36  # seconds; images before and while the camera moves
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

    def stamp(self, seconds):
        return START + STILL * PERIOD + seconds

    def test_gyro(self):
        clients = {name: Client(name) for name in ("gyro", "mirrored", "late")}
        publishers = {name: rospy.Publisher(name + "/imu", Imu, queue_size=2000) for name in clients}
        reports = []
        listening = rospy.Subscriber("/diagnostics", DiagnosticArray, reports.append)
        sender = clients["gyro"]
        for client in clients.values():
            client.connect()
        sender.wait(lambda: listening.get_num_connections() >= 3, "diagnostics")
        sender.wait(lambda: all(p.get_num_connections() for p in publishers.values()), "the filters to want gyros")
        sender.wait(lambda: sender.image.get_num_connections() >= 3, "the filters to want images")
        for i in range(int((self.times[-1] - self.times[0] + 0.2) * RATE)):
            seconds = self.times[0] - 0.05 + i / RATE
            gyro = TO_IMU @ rate(seconds)
            for name, publisher in publishers.items():
                message = Imu()
                message.header.frame_id = "imu_link"
                message.header.stamp = rospy.Time.from_sec(self.stamp(seconds) + (LATE if name == "late" else 0))
                w = message.angular_velocity
                w.x, w.y, w.z = gyro * ([1, -1, 1] if name == "mirrored" else [1, 1, 1]) + BIAS
                publisher.publish(message)
        for seconds, frame in zip(self.times, self.frames):
            sender.send(frame, self.stamp(seconds))
        for name, client in clients.items():
            client.answer(len(self.frames), name)
            for stats in client.stats[1:]:
                self.assertIn(stats.status, (MatchStats.OK, MatchStats.LOW_PARALLAX), stats.status_text)
        for stats in clients["gyro"].stats[2:]:
            self.assertNotIn("no rotation prior", stats.status_text)
        # A wrong prior takes nothing away.
        good, wrong = ([s.inliers for s in clients[name].stats[1:]] for name in ("gyro", "mirrored"))
        self.assertGreater(np.sum(wrong), 0.99 * np.sum(good))

        def said(name, words, offset):
            """The values beside such a summary, if it came with an estimate of the offset wherever one is asked for."""
            for report in reports:
                for status in report.status:
                    values = {v.key: v.value for v in status.values}
                    if status.name.strip("/").startswith(name + ": priors") and words in status.message and \
                            int(values["pairs compared"]) > 0 and (
                                not offset or "deviation" in values["~image_time_offset (s)"]):
                        return values
            return None

        def number(text):
            return [float(x) for x in text.split("(")[-1].split(")")[0].replace(", standard deviation", ",").split(",")]

        values = sender.wait(lambda: said("gyro", "agrees", True), "a gyro that agrees")
        self.assertLess(abs(number(values["~image_time_offset (s)"])[0]), 0.01)
        bias = number(values["learnt"].split("rad/s")[0])
        self.assertLess(np.abs(np.array(bias) - BIAS).max(), 0.02)
        sender.wait(lambda: said("mirrored", "its axes explain it", False), "the mirrored axis")
        values = sender.wait(lambda: said("late", "a time offset explains it", True), "the time offset")
        self.assertAlmostEqual(number(values["~image_time_offset (s)"])[0], LATE, delta=0.01)

        # The gyro falls silent: answered all the same, and said.
        count = len(sender.stats)
        sender.send(self.frames[0], self.stamp(self.times[-1] + 0.5))
        text = sender.answer(count + 1, "an image without gyro").status_text
        self.assertIn("no rotation prior: the newest sample is", text)
        self.assertIn("/gyro/imu", text)

    def roll(self, scene, seconds):
        """What a camera sees that reads its middle row at that time."""
        picture = np.empty((HEIGHT, WIDTH), np.uint8)
        rows = HEIGHT // BANDS
        for band in range(BANDS):
            time = seconds + READOUT * ((band + 0.5) / BANDS - 0.5)
            picture[band * rows:(band + 1) * rows] = scene.draw(t=place(time), r=turn(time))[band * rows:(band + 1) * rows]
        return picture

    def test_rolling_shutter(self):
        client, reports, scene = Client("rolling", "rolling/image", "rolling/camera_info"), [], Scene()
        gyro = rospy.Publisher("rolling/imu", Imu, queue_size=2000)
        listening = rospy.Subscriber("/diagnostics", DiagnosticArray, reports.append)
        client.connect()
        client.wait(lambda: listening.get_num_connections() > 0, "diagnostics")
        client.wait(gyro.get_num_connections, "the filter to want a gyro")
        times = self.times[STILL:STILL + 14]
        for i in range(int((times[-1] + 0.2) * RATE)):
            message = Imu()
            message.header.frame_id = "imu_link"
            message.header.stamp = rospy.Time.from_sec(self.stamp(i / RATE - 0.05))
            w = message.angular_velocity
            w.x, w.y, w.z = TO_IMU @ rate(i / RATE - 0.05)
            gyro.publish(message)
        for seconds in times:
            text = client.ask(self.roll(scene, seconds), self.stamp(seconds)).status_text
            self.assertNotIn("no rotation prior", text)

        def turned():
            values = [v.value for report in reports for status in report.status for v in status.values
                      if status.name.strip("/").startswith("rolling: priors") and v.key == "pairs corrected for readout"]
            return values and int(values[-1]) > len(times) / 2
        client.wait(turned, "rows that the gyro turned")

    def send_wheels(self, publisher, seconds, slip=False):
        message = Odometry()
        message.header.stamp = rospy.Time.from_sec(self.stamp(seconds))
        message.header.frame_id, message.child_frame_id = "odom", "imu_link"
        camera = cv2.Rodrigues(turn(seconds))[0]
        fill(message.pose.pose, TO_IMU @ camera @ TO_IMU.T, TO_IMU @ place(0 if slip else seconds))
        publisher.publish(message)

    def test_wheels(self):
        client, poses = Client("wheels", "wheels/image", "wheels/camera_info"), []
        client.subscribe("relative_pose", PoseWithCovarianceStamped, poses)
        odometry = rospy.Publisher("wheels/prior_odom", Odometry, queue_size=200)
        client.connect()
        client.wait(odometry.get_num_connections, "the filter to want wheels")
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
        self.send_wheels(odometry, self.times[chosen[-1]] + 0.001, slip=True)
        last = self.times[chosen[-1] + 5]
        self.send_wheels(odometry, last, slip=True)
        # From standing to standing is what it says: the camera moved all the same.
        client.ask(self.frames[chosen[-1] + 2], self.stamp(self.times[chosen[-1] + 2]))
        text = client.ask(self.frames[chosen[-1] + 5], self.stamp(last)).status_text
        self.assertIn("no length: by the odometry the camera stood", text)

    def test_tf(self):
        client = Client("by_tf", "by_tf/image", "by_tf/camera_info").connect()
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
        self.assertIn("no rotation prior: tf does not know unheard_of in map: no transform names unheard_of", text)

    def test_ground(self):
        folder = data_folder("kitti_06")
        if folder is None:
            self.skipTest("no kitti_06")
        with open(os.path.join(folder, "calib.txt")) as calibration:
            P = np.array([float(x) for x in calibration.readline().split()[1:]]).reshape(3, 4)
        truth = np.loadtxt(os.path.join(folder, "poses.txt")).reshape(-1, 3, 4)[:, :, 3]
        client, poses = Client("ground", "ground/image", "ground/camera_info"), []
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
    rospy.init_node("priors_test")
    rostest.rosrun("gms_ransac", "priors", PriorsTest)
