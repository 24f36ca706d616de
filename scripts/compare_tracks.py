#!/usr/bin/env python3
"""compare_tracks.py IMAGES.bag FEATURES.bag: the tracks of ~features beside those of cv::calcOpticalFlowPyrLK on the same
images: how long they are and, where the bag of images has exact poses in /tf (render_scene, dataset_to_bag), how far each
observation is from the epipolar line of its track's first one. FEATURES.bag: what `rosbag record /match_filter/features`
wrote while the other was played. The KLT tracker is what front ends that live from it do: corners of
cv::goodFeaturesToTrack where there are none yet, flow from image to image, a fundamental matrix against what strays."""
import argparse

import cv2
import numpy as np
import rosbag

from demo_summary import pose_matrix

LIMIT, DISTANCE = 220, 15  # as ~feature_limit and ~feature_distance
WINDOW, LEVELS = (21, 21), 3
EPIPOLAR_DISTANCE = 1.0  # pixels
FAR_OFF = 3.0  # pixels
LEAST_BASELINE = 0.03  # metres; below it there is no epipolar line


class Tracker:
    """KLT, image after image."""

    def __init__(self):
        self.last, self.next_id = None, 0
        self.points, self.ids = np.zeros((0, 2), np.float32), np.zeros(0, int)

    def advance(self, image):
        if len(self.points):
            to, found, _ = cv2.calcOpticalFlowPyrLK(self.last, image, self.points, None, winSize=WINDOW, maxLevel=LEVELS)
            found = found.ravel() > 0
            found &= np.all((to >= 1) & (to < np.array(image.shape[::-1]) - 1), axis=1)
            if np.count_nonzero(found) >= 8:
                _, agrees = cv2.findFundamentalMat(self.points[found], to[found], cv2.FM_RANSAC, EPIPOLAR_DISTANCE, 0.99)
                if agrees is not None:
                    found[np.flatnonzero(found)] = agrees.ravel() > 0
            self.points, self.ids = to[found], self.ids[found]
        mask = np.full(image.shape, 255, np.uint8)
        for x, y in self.points:
            cv2.circle(mask, (int(round(x)), int(round(y))), DISTANCE, 0, -1)
        wanted = LIMIT - len(self.points)
        fresh = cv2.goodFeaturesToTrack(image, wanted, 0.01, DISTANCE, mask=mask) if wanted > 0 else None
        if fresh is not None:
            self.points = np.concatenate([self.points, fresh.reshape(-1, 2)])
            self.ids = np.concatenate([self.ids, self.next_id + np.arange(len(fresh))])
            self.next_id += len(fresh)
        self.last = image
        return self.ids, self.points


def read_images(path):
    """Yields stamp and grey image; fills the poses by stamp and K."""
    poses, K, images = {}, None, []
    with rosbag.Bag(path) as bag:
        for topic, message, _ in bag.read_messages():
            if topic == "/tf":
                # Camera in world: the transforms of a message follow on each other.
                pose = np.eye(4)
                for one in message.transforms:
                    pose = pose @ pose_matrix(one.transform.translation, one.transform.rotation)
                poses[message.transforms[0].header.stamp.to_nsec()] = (pose[:3, :3], pose[:3, 3])
            elif message._type == "sensor_msgs/CameraInfo":
                K = np.reshape(message.K, (3, 3))
            elif message._type == "sensor_msgs/Image" and message.encoding in ("mono8", "rgb8", "bgr8"):
                pixels = np.frombuffer(message.data, np.uint8).reshape(message.height, message.width, -1)
                grey = pixels[:, :, 0] if pixels.shape[2] == 1 else cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY)
                images.append((message.header.stamp.to_nsec(), np.ascontiguousarray(grey)))
    return images, poses, K


def errors(track, poses, K):
    """Age in seconds and distance from the epipolar line of the first observation, pixels, of every later one."""
    result = []
    (R0, t0), first = poses[track[0][0]], np.linalg.solve(K, np.append(track[0][1], 1))
    for stamp, pixel in track[1:]:
        R, t = poses[stamp]
        if np.linalg.norm(t - t0) < LEAST_BASELINE:
            continue
        line = np.linalg.inv(K).T @ np.cross(R.T @ (t0 - t), R.T @ R0 @ first)
        result.append(((stamp - track[0][0]) * 1e-9, abs(line @ np.append(pixel, 1)) / np.hypot(line[0], line[1])))
    return result


def report(name, tracks, poses, K):
    tracks = [t for t in tracks.values() if len(t) > 1]
    seconds = np.array([(t[-1][0] - t[0][0]) * 1e-9 for t in tracks])
    weights = [len(t) for t in tracks]
    print("%-10s %6d tracks; seconds: median %.2f, p90 %.2f, of an observation's track %.2f" %
          (name, len(tracks), np.median(seconds), np.percentile(seconds, 90), np.average(seconds, weights=weights)))
    off = np.array([e for t in tracks if all(s in poses for s, _ in t) for e in errors(t, poses, K)])
    for low, high in ((0, 0.5), (0.5, 1), (1, np.inf)) if len(off) else ():
        of_age = off[(off[:, 0] > low) & (off[:, 0] <= high), 1]
        if len(of_age):
            print("%10s after %.1f to %.1f s: median %.3f px, p90 %.3f, above %g px %.2f %%" %
                  ("", low, high, np.median(of_age), np.percentile(of_age, 90), FAR_OFF, 100 * np.mean(of_age > FAR_OFF)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
                                     allow_abbrev=False)
    parser.add_argument("images")
    parser.add_argument("features")
    arguments = parser.parse_args()
    images, poses, K = read_images(arguments.images)
    ours, klt = {}, {}
    with rosbag.Bag(arguments.features) as bag:
        for _, message, _ in bag.read_messages():
            if message._type != "sensor_msgs/PointCloud":
                continue
            columns = {c.name: c.values for c in message.channels}
            for i, u, v in zip(columns["id"], columns["u"], columns["v"]):
                ours.setdefault(i, []).append((message.header.stamp.to_nsec(), (u, v)))
    sent = {stamp for track in ours.values() for stamp, _ in track}
    tracker = Tracker()
    for stamp, image in images:
        ids, points = tracker.advance(image)
        for i, point in zip(ids, points) if stamp in sent else ():
            klt.setdefault(i, []).append((stamp, point))
    report("~features", ours, poses, K)
    report("KLT", klt, poses, K)


if __name__ == "__main__":
    main()
