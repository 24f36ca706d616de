#!/usr/bin/env python3
"""Watches a replay of the match filter and sums it up.

Runs as a node beside the filter until every image of the bag was answered, then writes summary.txt, match_image.png and
(where rviz is open) rviz.png to ~output_dir and ends. Poses are compared with the ground truth that the bag's /tf holds.
The launch file has the player wait until this node listens, or a short bag would be over before.

Parameters: ~bag, ~image_topic, ~output_dir, ~screenshot (bool). Topics: stats, correspondences, match_image.
"""
import os
import subprocess
import sys
import threading
import time
from collections import deque

try:
    import cv2
    import numpy as np
except ImportError as error:
    sys.exit("demo_summary.py: %s; install python3-opencv and python3-numpy" % error)
import rosbag
import rospy
import tf2_ros
from cv_bridge import CvBridge
from gms_ransac.msg import Correspondences, MatchStats
from sensor_msgs.msg import Image

# Image frames that some converters leave out of the tree, and the frame of the tree that stands for them.
FRAME_ALIASES = {"camera_gray_left": "camera_left", "camera_color_left": "camera_left"}
START_UP = 120.0  # seconds of wall time until the first answer
RVIZ_DRAWS = 3.0  # seconds of wall time that rviz, drawn by the processor, takes to show the last image
SILENCE = 15.0  # seconds of wall time without a new answer after which the replay is taken to be over


class GroundTruth:
    """Camera poses from a bag's /tf and /tf_static; none where the bag has no tree for the camera."""

    def __init__(self, path):
        self.buffer = tf2_ros.BufferCore(rospy.Duration(1e6))
        self.roots = set()
        children = set()
        with rosbag.Bag(path) as bag:
            for topic, message, _ in bag.read_messages(topics=["/tf", "/tf_static", "tf", "tf_static"]):
                for transform in message.transforms:
                    transform.header.frame_id = transform.header.frame_id.lstrip("/")
                    transform.child_frame_id = transform.child_frame_id.lstrip("/")
                    self.roots.add(transform.header.frame_id)
                    children.add(transform.child_frame_id)
                    add = self.buffer.set_transform_static if topic.endswith("static") else self.buffer.set_transform
                    add(transform, "bag")
        self.roots -= children

    def pose(self, frame, stamp):
        """4x4 camera-to-root matrix, or None."""
        for root in self.roots:
            for name in (frame, FRAME_ALIASES.get(frame, frame)):
                try:
                    transform = self.buffer.lookup_transform_core(root, name, stamp).transform
                    return pose_matrix(transform.translation, transform.rotation)
                except tf2_ros.TransformException:
                    continue
        return None


def numbers(message):
    """Of a vector, a point or a quaternion, in the order of its fields."""
    return [getattr(message, name) for name in message.__slots__]


def pose_matrix(t, q):
    """4 x 4, of messages."""
    t, q = numbers(t), numbers(q)
    *v, w = q / np.linalg.norm(q)
    axis, result = np.cross(np.eye(3), v), np.eye(4)
    result[:3, :3] += 2 * w * axis + 2 * axis @ axis
    result[:3, 3] = t
    return result


def degrees_between(a, b):
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b)), np.dot(a, b)))


def rotation_degrees(R):
    return np.degrees(np.arccos(np.clip((np.trace(R) - 1) / 2, -1, 1)))


class DemoSummary:
    def __init__(self):
        self.bag = rospy.get_param("~bag")
        self.image_topic = rospy.get_param("~image_topic")
        self.output = rospy.get_param("~output_dir")
        self.screenshot = rospy.get_param("~screenshot", False)
        with rosbag.Bag(self.bag) as bag:
            self.expected = bag.get_message_count(self.image_topic)
        if not self.expected:
            rospy.logfatal("%s has no images on %s", self.bag, self.image_topic)
            raise SystemExit(2)
        self.truth = GroundTruth(self.bag)
        self.stats, self.answers, self.overlays = [], [], deque(maxlen=1)
        self.changed = threading.Condition()
        rospy.Subscriber("stats", MatchStats, self.on_stats, queue_size=1000)
        rospy.Subscriber("correspondences", Correspondences, self.answers.append, queue_size=1000)
        rospy.Subscriber("match_image", Image, self.overlays.append, queue_size=2)

    def on_stats(self, message):
        with self.changed:
            self.stats.append(message)
            self.changed.notify()

    def is_over(self):
        """Whether every image of the bag has come, and none waits for its answer."""
        if not self.stats:
            return False
        last = self.stats[-1]
        answered = last.frames_processed + last.frames_passed_over + last.frames_dropped
        return last.frames_received >= self.expected and answered >= last.frames_received

    def run(self):
        """Waits for the last image and writes everything."""
        with self.changed:
            while not rospy.is_shutdown() and not self.is_over():
                seen = len(self.stats)
                if not self.changed.wait(SILENCE if self.stats else START_UP) and seen == len(self.stats):
                    break
        if self.screenshot:
            self.capture_rviz()
        if self.overlays:
            picture = CvBridge().imgmsg_to_cv2(self.overlays[-1], "bgr8")
            cv2.imwrite(os.path.join(self.output, "match_image.png"), picture)
        with open(os.path.join(self.output, "summary.txt"), "w") as out:
            out.write(self.table())

    def capture_rviz(self):
        path = os.path.join(self.output, "rviz.png")
        time.sleep(RVIZ_DRAWS)
        try:
            window = subprocess.check_output(["xdotool", "search", "--onlyvisible", "--name", "RViz"], text=True).split()[0]
            subprocess.check_call(["import", "-window", window, path])
        except (OSError, IndexError, subprocess.CalledProcessError) as error:
            rospy.logwarn("no picture of rviz: %s", error)

    def pose_errors(self):
        """(rotation, direction) in degrees for each pair with a pose and a true motion."""
        errors = []
        for answer in self.answers:
            if not answer.pose_valid:
                continue
            before = self.truth.pose(answer.reference_header.frame_id, answer.reference_header.stamp)
            after = self.truth.pose(answer.header.frame_id, answer.header.stamp)
            if before is None or after is None:
                continue
            true = np.linalg.inv(before) @ after
            pose = pose_matrix(answer.current_in_reference.pose.position, answer.current_in_reference.pose.orientation)
            rotation = rotation_degrees(true[:3, :3].T @ pose[:3, :3])
            known = np.linalg.norm(pose[:3, 3]) > 0 and np.linalg.norm(true[:3, 3]) > 0
            direction = degrees_between(pose[:3, 3], true[:3, 3]) if known else np.nan
            errors.append((rotation, direction))
        return np.array(errors).reshape(-1, 2)

    def table(self):
        pairs = [message for message in self.stats if message.matches_raw]
        if not pairs:
            return "no pair of images was answered: see roslaunch.log\n"
        median = lambda name: float(np.median([getattr(message, name) for message in pairs]))
        last = self.stats[-1]
        stamps = [message.header.stamp.to_sec() for message in self.stats]
        work = sum(message.time_total for message in pairs) / len(pairs)
        good = sum(message.status == MatchStats.OK for message in pairs)
        rows = [
            ("images in the bag", "%d" % self.expected),
            ("received / processed / dropped", "%d / %d / %d" % (last.frames_received, last.frames_processed, last.frames_dropped)),
            ("pairs with status OK", "%d of %d" % (good, len(pairs))),
            ("rate of the stream", "%.1f Hz" % ((len(stamps) - 1) / max(stamps[-1] - stamps[0], 1e-9))),
            ("rate the filter could sustain", "%.0f Hz" % (1 / max(work, 1e-9))),
        ] + [(what, "%.0f" % median(name)) for what, name in (
            ("keypoints", "keypoints_current"), ("matches, raw", "matches_raw"), ("matches, after GMS", "matches_gms"),
            ("matches, inliers", "inliers"), ("hypotheses", "hypotheses"))]
        for stage in ("convert", "detect", "match", "gms", "ransac", "total"):
            rows.append(("ms, " + stage, "%.2f" % (1e3 * median("time_" + stage))))
        errors = self.pose_errors()
        if len(errors):
            directions = errors[~np.isnan(errors[:, 1]), 1]
            rows.append(("rotation error, median", "%.3f deg" % np.median(errors[:, 0])))
            if len(directions):
                rows.append(("direction error, median", "%.2f deg" % np.median(directions)))
        else:
            rows.append(("pose error", "no ground truth for the camera in this bag"))
        rows.append(("pairs with a pose", "%d" % len([a for a in self.answers if a.pose_valid])))
        width = max(len(name) for name, _ in rows)
        return "".join("%-*s  %s\n" % (width, name, value) for name, value in rows)


if __name__ == "__main__":
    rospy.init_node("demo_summary")
    DemoSummary().run()
