"""`evaluate odometry`: drift of whole sequences against their truth, as KITTI and TUM define it, beside that of another
system."""
import json
import math
import sys

import numpy as np

from report.common import grouped, mean, pyplot
from report.plots import grid_of

LENGTHS = (10, 20, 50, 100, 200, 300, 400, 500, 600, 700, 800)  # metres; KITTI's are those from 100 on
KITTI_FROM = 100
SECOND = 1.0
LATE = 0.02  # seconds between an image and a pose of it, as TUM's tools have it
LEGEND = """
lost     images after which the motion is not known; the pose before them is kept
t r      KITTI's errors: of the translation, %, and of the rotation, degrees per 100 m, over parts of the drive of that
         length, a part beginning at every image. KITTI: mean over the parts of 100 to 800 m
long     how much longer a part is than the truth, %, mean over the parts of the longest length that the drive has
RPE      root mean square error of the motions of a second: metres and degrees
ATE      root mean square distance of the paths after alignment, metres
         With propagate all errors are those of the path scaled to the truth.
NEES     squared error of a pair's motion by its covariance over its dimension, median over pairs over that of chi2; 1 is
         right. Only of metric pairs, and as good as the truth is from image to image
ms       processor time an image, mean
"""
CHI2_MEDIAN = 5.348 / 6  # of six degrees of freedom, over six


class BadPeer(ValueError):
    """A file of poses in neither form."""


class Path:
    """Poses of a camera, and the truth of the same images: X_first = pose X_image, 4 x 4; None where there is none."""

    def __init__(self, name, stamps, poses, truth, free_scale=False):
        known = [i for i, (pose, true) in enumerate(zip(poses, truth)) if pose is not None and true is not None]
        self.name = name
        self.stamps = np.array([stamps[i] for i in known])
        self.poses = np.array([poses[i] for i in known]).reshape(-1, 4, 4)
        self.truth = np.array([truth[i] for i in known]).reshape(-1, 4, 4)
        if free_scale and len(known) > 1:
            self.poses[:, :3, 3] *= aligned(self.poses[:, :3, 3], self.truth[:, :3, 3], True)[1]
        steps = np.linalg.norm(np.diff(self.truth[:, :3, 3], axis=0), axis=1)
        self.distance = np.concatenate(([0], np.cumsum(steps)))[:len(known)]

    def error(self, i, j):
        """(metres, radians) by which the motion from image i to image j is wrong."""
        wrong = inverse(inverse(self.poses[i]) @ self.poses[j]) @ inverse(self.truth[i]) @ self.truth[j]
        return float(np.linalg.norm(wrong[:3, 3])), angle(wrong[:3, :3])

    def parts(self, length):
        """(i, j) of the parts longer than a length, each as short as can be (the development kit of KITTI odometry)."""
        ends = np.searchsorted(self.distance, self.distance + length, side="right")
        return [(i, int(j)) for i, j in enumerate(ends) if j < len(self.distance)]

    def drift(self, lengths):
        """(translation %, rotation degrees per 100 m), mean over the parts of these lengths; NaN without."""
        errors = [(100 * t / length, 100 * math.degrees(r) / length)
                  for length in lengths for t, r in (self.error(i, j) for i, j in self.parts(length))]
        return tuple(mean([error[k] for error in errors]) for k in (0, 1))

    def lengthening(self):
        """Percent by which the parts of the longest length are too long."""
        longest = [length for length in LENGTHS if self.parts(length)]
        gaps = [[np.linalg.norm(p[j][:3, 3] - p[i][:3, 3]) for p in (self.poses, self.truth)]
                for i, j in (self.parts(longest[-1]) if longest else ())]
        return mean([100 * (ours / true - 1) for ours, true in gaps])

    def rpe(self, seconds=SECOND):
        """(metres, degrees), root mean squares over pairs of images about so long apart."""
        errors = []
        for i, stamp in enumerate(self.stamps):
            j = int(np.searchsorted(self.stamps, stamp + seconds - 1e-6))
            if j < len(self.stamps) and self.stamps[j] < stamp + 1.5 * seconds:
                errors.append(self.error(i, j))
        rms = [math.sqrt(mean([error[k] ** 2 for error in errors])) for k in (0, 1)] if errors else (math.nan, math.nan)
        return rms[0], math.degrees(rms[1])

    def ate(self):
        if len(self.poses) < 3:
            return math.nan
        return float(np.sqrt(np.mean(np.sum((aligned(self.poses[:, :3, 3], self.truth[:, :3, 3])[0] -
                                             self.truth[:, :3, 3]) ** 2, axis=1))))


def inverse(pose):
    result = np.eye(4)
    result[:3, :3] = pose[:3, :3].T
    result[:3, 3] = -pose[:3, :3].T @ pose[:3, 3]
    return result


def angle(R):
    """Of a rotation, radians; exact for small ones, which the trace is not."""
    sine = 0.5 * np.linalg.norm([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    return math.atan2(sine, 0.5 * (np.trace(R) - 1))


def rotation_vector(R):
    axis = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    norm = np.linalg.norm(axis)
    return axis / norm * angle(R) if norm > 0 else axis


def aligned(points, truth, scaled=False):
    """(points moved on the truth by least squares, scale); Umeyama 1991."""
    a, b = points - points.mean(0), truth - truth.mean(0)
    U, D, Vt = np.linalg.svd(b.T @ a)
    sign = np.array([1, 1, np.sign(np.linalg.det(U @ Vt))])
    scale = float(np.sum(D * sign) / max(np.sum(a * a), 1e-300)) if scaled else 1.0
    return scale * a @ (U * sign @ Vt).T + truth.mean(0), scale


def matrix(numbers):
    return np.vstack([np.reshape(numbers, (3, 4)), [0, 0, 0, 1]]) if numbers else None


def nees(records):
    """Of the metric pairs with truth, over six."""
    def key(stamp):  # ROS rounds to nanoseconds
        return round(stamp, 6)
    truth = {key(record["stamp"]): matrix(record["truth"]) for record in records}
    values = []
    for record in records:
        pair = record["pair"]
        if not pair or not pair["metric"] or truth.get(key(pair["reference_stamp"])) is None or not record["truth"]:
            continue
        motion, true = matrix(pair["motion"]), inverse(truth[key(pair["reference_stamp"])]) @ matrix(record["truth"])
        error = np.concatenate((true[:3, 3] - motion[:3, 3], rotation_vector(true[:3, :3] @ motion[:3, :3].T)))
        values.append(error @ np.linalg.solve(np.reshape(pair["covariance"], (6, 6)), error) / 6)
    return float(np.median(values)) / CHI2_MEDIAN if values else math.nan


def read_peer(path, stamps):
    """A pose of each image, or None: KITTI's 12 numbers a line, or TUM's stamp, position and quaternion."""
    with open(path) as stream:
        try:
            rows = [[float(word) for word in line.split()] for line in stream if line.strip() and line[0] != "#"]
        except ValueError as error:
            raise BadPeer("%s: %s" % (path, error)) from error
    if rows and all(len(row) == 12 for row in rows):
        return [matrix(rows[i]) if i < len(rows) else None for i in range(len(stamps))]
    if not rows or any(len(row) != 8 for row in rows):
        raise BadPeer("%s: not 12 numbers a line (KITTI) nor 8 (TUM)" % path)
    rows, poses = np.array(rows), []
    for stamp in stamps:
        row = rows[np.argmin(np.abs(rows[:, 0] - stamp))]
        x, y, z, w = row[4:] / np.linalg.norm(row[4:])
        R = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
             [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
             [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
        pose = matrix(np.column_stack((R, row[1:4])).tolist())
        poses.append(pose if abs(row[0] - stamp) <= LATE else None)
    return poses


def read(lines, peers):
    """[(set, [(path, lost, nees, ms, images)])], a peer after ours."""
    sets = []
    for number, records in grouped(map(json.loads, lines), lambda record: record["number"]).items():
        stamps = [record["stamp"] for record in records]
        truth = [matrix(record["truth"]) for record in records]
        scale = records[0]["scale"]
        ours = Path(scale, stamps, [matrix(record["pose"]) for record in records], truth, scale == "propagate")
        rows = [(ours, sum(not record["known"] for record in records), nees(records),
                 mean([record["ms"] for record in records]), len(records))]
        if number < len(peers):
            peer = Path("peer", stamps, read_peer(peers[number], stamps), truth)
            rows.append((peer, None, math.nan, math.nan, len(peer.poses)))
        sets.append((records[0]["set"], rows))
    return sets


def without_truth(sets):
    """A sentence for each set that cannot be compared; empty: all can."""
    return "".join("%s: has no truth (poses.txt, groundtruth.txt, or tf from world, map or odom to the camera), so its %d "
                   "images have no errors\n" % (name, rows[0][4]) for name, rows in sets if not len(rows[0][0].poses))


def table(sets):
    lengths = [length for length in LENGTHS if any(path.parts(length) for _, rows in sets for path, *_ in rows)]
    columns = [("t, r %d m" % length, 15, "%.2f %.2f", lambda row, length=length: row[0].drift([length]))
               for length in lengths] + [
        ("KITTI", 13, "%.2f %.2f", lambda row: row[0].drift([length for length in LENGTHS if length >= KITTI_FROM])),
        ("long", 7, "%+.2f", lambda row: [row[0].lengthening()]), ("RPE m, deg", 15, "%.4f %.3f", lambda row: row[0].rpe()),
        ("ATE m", 8, "%.3f", lambda row: [row[0].ate()]), ("NEES", 7, "%.2f", lambda row: [row[2]]),
        ("ms", 7, "%.2f", lambda row: [row[3]])]
    lines = ["%-20s %-9s %6s %5s" % ("set", "", "images", "lost") + "".join("%*s" % (width, head) for head, width, *_ in columns)]
    for name, rows in sets:
        for row in rows:
            cells = [(width, form, value(row)) for _, width, form, value in columns]
            lines.append("%-20s %-9s %6d %5s" % (name, row[0].name, row[4], "-" if row[1] is None else row[1]) +
                         "".join("%*s" % (width, "-" if math.isnan(figures[0]) else form % tuple(figures))
                                 for width, form, figures in cells))
    return "\n".join(lines) + "\n" + LEGEND


def plot(sets, file):
    """A row for each set: the paths from above, if the first camera is level, and the errors over the length."""
    plt = pyplot()
    if not plt:
        return
    figure, axes = grid_of(plt, 3, len(sets), (4, 3.4))
    for (name, rows), (above, translation, rotation) in zip(sets, axes):
        above.set_title(name, fontsize=9)
        first = rows[0][0]
        for label, poses in [("truth", first.truth)] + [(path.name, path.poses) for path, *_ in rows]:
            seen = [inverse(poses[0]) @ pose for pose in poses]
            above.plot([pose[0, 3] for pose in seen], [pose[2, 3] for pose in seen], linewidth=1.2, label=label,
                       color="black" if label == "truth" else None)
        above.set_aspect("equal", adjustable="datalim")
        above.legend(fontsize=8)
        above.set_xlabel("x of the first camera, m", fontsize=9)
        above.set_ylabel("z, m", fontsize=9)
        for path, *_ in rows:
            lengths = [length for length in LENGTHS if path.parts(length)]
            for axis, k in ((translation, 0), (rotation, 1)):
                axis.plot(lengths, [path.drift([length])[k] for length in lengths], marker="o", markersize=3, label=path.name)
        for axis, label in ((translation, "translation, %"), (rotation, "rotation, degrees per 100 m")):
            if not first.parts(LENGTHS[0]):
                axis.text(0.5, 0.5, "the path is shorter than %d m" % LENGTHS[0], ha="center", transform=axis.transAxes, fontsize=9)
            axis.set_xlabel("length of the part, m", fontsize=9)
            axis.set_ylabel(label, fontsize=9)
            axis.set_ylim(bottom=0)
    figure.tight_layout()
    figure.savefig(file, dpi=100)
    print("wrote %s" % file, file=sys.stderr)


def report(lines, plot_file, peers):
    sets = read(lines, peers)
    print(table(sets) + without_truth(sets), end="")
    sets = [(name, rows) for name, rows in sets if len(rows[0][0].poses)]
    if plot_file and sets:
        plot(sets, plot_file)
