"""`evaluate odometry`: drift of whole sequences against their truth and a witness, as KITTI and TUM define it, beside that
of another system; and whether the covariances are true."""
import json
import math
import sys
from types import SimpleNamespace

import numpy as np

from report.common import grouped, mean, median, naming, pyplot
from report.plots import grid_of

LENGTHS = (10, 20, 50, 100, 200, 300, 400, 500, 600, 700, 800)  # metres; KITTI's are those from 100 on
KITTI_FROM = 100
SECOND = 1.0
LATE = 0.02  # seconds between an image and a pose of it, as TUM's tools have it
# Standard deviations of a pose of the witness, metres and degrees: registered LiDAR scans of KITTI 01 and 06, by how their
# errors from image to image cancel.
WITNESS_NOISE = (0.015, 0.017)
METRES_WEIGHT = 0.02  # radians that count as much as a metre where the rotation between two camera frames is fitted
UNKNOWN = 999.0  # variance from which a coordinate is published as unknown
LEGEND = """
against  truth: the poses of the set. witness: those of --witness. With --align each a second time, with the constant
         rotation between its camera's axes and ours fitted out (degrees)
lost     images after which the motion is not known; the pose before them is kept
t r      KITTI's errors: of the translation, %, and of the rotation, degrees per 100 m, over parts of the drive of that
         length, a part beginning at every image. KITTI: mean over the parts of 100 to 800 m
long     how much longer a part is than the truth, %, mean over the parts of the longest length that the drive has
RPE      root mean square error of the motions of a second: metres and degrees
ATE      root mean square distance of the paths after alignment, metres
         With propagate all errors are those of the path scaled to the truth.
ms       processor time an image, mean
"""
NEES_LEGEND = """
NEES     squared error by the published covariance plus the noise of the truth, over its dimension: median, 90th percentile,
         number. True covariances of six dimensions have 0.9 and 1.8. Without metres of the rotation alone
pair     ~relative_pose. N m, N s: ~odom since ~set_pose at an image so far back, with a covariance of zero
noise    standard deviations of the true motion of a pair, median: millimetres and degrees. That of the frames' rotation
         against each other, which grows with the way, is left out where it is fitted
"""


class BadPoses(ValueError):
    """A file of poses in neither form."""


def two_numbers(text):
    """"0.1,2" -> (0.1, 2.0)."""
    first, second = text.split(",")
    return float(first), float(second)


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

    def aligned(self):
        """(this path with the truth in its own camera's axes, radians between them before)."""
        X = frame_rotation(self.poses, self.truth)
        other = Path(self.name, self.stamps, self.poses, inverse(X) @ self.truth @ X)
        return other, angle(X[:3, :3])

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


def steps(poses):
    return [inverse(a) @ b for a, b in zip(poses[:-1], poses[1:])]


def frame_rotation(poses, truth):
    """The constant rotation X, 4 x 4, with X (step of the poses) X^-1 nearest to the step of the truth: Kabsch's, over the
    rotation vectors and the translations of all steps."""
    def vectors(path):
        moved = steps(path)
        return np.array([rotation_vector(step[:3, :3]) for step in moved] +
                        [METRES_WEIGHT * step[:3, 3] for step in moved]).reshape(-1, 3)
    U, _, Vt = np.linalg.svd(vectors(truth).T @ vectors(poses))
    X = np.eye(4)
    X[:3, :3] = U @ np.diag([1, 1, np.linalg.det(U @ Vt)]) @ Vt
    return X


def across(sigma, v):
    """Covariance of a vector in axes that are rotated by `sigma` about each."""
    return sigma ** 2 * (v @ v * np.eye(3) - np.outer(v, v))


def blocks(upper, lower):
    return np.block([[upper, np.zeros((3, 3))], [np.zeros((3, 3)), lower]])


class Truth:
    """True poses by the stamps of the images, and the noise of the motions between them."""

    def __init__(self, stamps, poses, alignment, witness_noise=None):
        self.poses = {self.key(stamp): pose for stamp, pose in zip(stamps, poses) if pose is not None}
        self.alignment = alignment
        self.witness_noise = witness_noise  # metres, radians; None: that of the records

    @staticmethod
    def key(stamp):  # ROS rounds to nanoseconds
        return round(stamp, 6)

    def motion(self, since, to):
        """None where one of the two poses is not known."""
        a, b = self.poses.get(self.key(since)), self.poses.get(self.key(to))
        return None if a is None or b is None else inverse(a) @ b

    def noise(self, recorded, true):
        """6 x 6, translation first, in the axes of the first image."""
        t, w = true[:3, 3], rotation_vector(true[:3, :3])
        if self.witness_noise:
            metres, radians = self.witness_noise
            return blocks(2 * metres ** 2 * np.eye(3) + across(radians, t), 2 * radians ** 2 * np.eye(3))
        white = blocks(*(np.reshape(recorded[name], (3, 3)) if recorded else np.zeros((3, 3))
                         for name in ("translation", "rotation")))
        return white + blocks(across(self.alignment, t), across(self.alignment, w))


def squared(error, covariance, noise, metric):
    """Over the dimension: all coordinates that are published as known; without metres of the rotation alone."""
    known = np.diag(covariance) < UNKNOWN
    if not metric:
        known[:3] = False
    if not known.any():
        return math.nan
    S = (covariance + noise)[np.ix_(known, known)]
    return float(error[known] @ np.linalg.solve(S, error[known])) / np.count_nonzero(known)


def consistency(records, truth):
    """({what: squared errors}, [noise of a pair's motion: metres, radians])."""
    values, noises = {}, []

    def add(what, value):
        if not math.isnan(value):
            values.setdefault(what, []).append(value)

    def compare(what, since, record, given, metric):
        true = truth.motion(since, record["stamp"])
        if true is None:
            return None
        motion, noise = matrix(given["motion"]), truth.noise(given.get("noise"), true)
        error = np.concatenate((true[:3, 3] - motion[:3, 3], rotation_vector(true[:3, :3] @ motion[:3, :3].T)))
        add(what, squared(error, np.reshape(given["covariance"], (6, 6)), noise, metric))
        return true, noise

    for record in records:
        metres = record["scale"] != "propagate"
        pair = record["pair"]
        compared = pair and compare("pair", pair["reference_stamp"], record, pair, pair["metric"])
        if compared:
            true, noise = compared
            noises.append(np.sqrt([np.trace(noise[:3, :3]) / 3, np.trace(noise[3:, 3:]) / 3]))
            if record.get("twist"):
                seconds = record["stamp"] - pair["reference_stamp"]
                R = true[:3, :3].T / seconds
                rate = np.concatenate((R @ true[:3, 3], rotation_vector(true[:3, :3]) / seconds))
                turned = blocks(R, R)
                add("twist", squared(rate - record["twist"]["velocity"], np.reshape(record["twist"]["covariance"], (6, 6)),
                                     turned @ noise @ turned.T, metres))
        for part in record.get("parts", ()):
            compare((part["unit"], part["length"]), part["from"], record, part, metres)
    return values, noises


def read_poses(path, stamps):
    """A pose of each image, or None: KITTI's 12 numbers a line, or TUM's stamp, position and quaternion."""
    with open(path) as stream:
        try:
            rows = [[float(word) for word in line.split()] for line in stream if line.strip() and line[0] != "#"]
        except ValueError as error:
            raise BadPoses("%s: %s" % (path, error)) from error
    if rows and all(len(row) == 12 for row in rows):
        if len(rows) != len(stamps):
            print("evaluate_report.py: %s: has %d poses for %d images; line i belongs to the i-th image" %
                  (path, len(rows), len(stamps)), file=sys.stderr)
        return [matrix(rows[i]) if i < len(rows) else None for i in range(len(stamps))]
    if not rows or any(len(row) != 8 for row in rows):
        raise BadPoses("%s: not 12 numbers a line (KITTI) nor 8 (TUM)" % path)
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


def read(lines, peers=(), witnesses=(), leave_out=0, align=False, witness_noise=WITNESS_NOISE):
    """[(set, rows)]: ours and then the peer's, against the truth and against the witness, each as it is and aligned."""
    sets = []
    for number, records in grouped(map(json.loads, lines), lambda record: record["number"]).items():
        stamps = [record["stamp"] for record in records]
        scale, alignment = records[0]["scale"], records[0].get("alignment", 0.0)
        paths = [(scale, [matrix(record["pose"]) for record in records])]
        if number < len(peers):
            paths.append(("peer", read_poses(peers[number], stamps)))
        against = [("truth", [matrix(record["truth"]) for record in records], None)]
        if number < len(witnesses):
            against.append(("witness", read_poses(witnesses[number], stamps),
                            (witness_noise[0], math.radians(witness_noise[1]))))
        rows = []
        for name, poses, noise in against:
            poses = [None if i < leave_out else pose for i, pose in enumerate(poses)]
            if all(pose is None for pose in poses):
                continue
            for path_name, path_poses in paths:
                path = Path(path_name, stamps, path_poses, poses, path_name == "propagate")
                for fitted in (False, True) if align and len(path.poses) > 2 else (False,):
                    path, rotation = path.aligned() if fitted else (path, None)
                    rows.append(row_of(name, path, rotation, None if path_name == "peer" else records,
                                       Truth(path.stamps, path.truth, 0.0 if fitted else alignment, noise)))
        if not rows:
            path = Path(scale, stamps, [None] * len(stamps), [None] * len(stamps))
            rows = [row_of("-", path, None, records, Truth([], [], 0.0))]
        sets.append((records[0]["set"], rows))
    return sets


def without_truth(sets):
    """A sentence for each set that cannot be compared; empty: all can."""
    return "".join("%s: has no truth (poses.txt, groundtruth.txt, or tf from world, map or odom to the camera), so its %d "
                   "images have no errors\n" % (name, rows[0].images) for name, rows in sets if not len(rows[0].path.poses))


def row_of(against, path, rotation, records, truth):
    """`records`: of ours; None: a peer's path, of which nothing else is known. `rotation`: fitted, radians, or None."""
    row = SimpleNamespace(against=against + ("" if rotation is None else " %.2f" % math.degrees(rotation)), path=path,
                          images=len(path.poses), lost="-", ms=math.nan, nees={}, noise=[])
    if records is not None:
        row.images = row.images if against != "-" else len(records)
        row.lost = sum(not record["known"] for record in records)
        row.ms = mean([record["ms"] for record in records])
        row.nees, row.noise = consistency(records, truth)
    return row


def table(sets):
    lengths = [length for length in LENGTHS if any(row.path.parts(length) for _, rows in sets for row in rows)]
    columns = [("t, r %d m" % length, 15, "%.2f %.2f", lambda path, length=length: path.drift([length]))
               for length in lengths] + [
        ("KITTI", 13, "%.2f %.2f", lambda path: path.drift([length for length in LENGTHS if length >= KITTI_FROM])),
        ("long", 7, "%+.2f", lambda path: [path.lengthening()]), ("RPE m, deg", 15, "%.4f %.3f", lambda path: path.rpe()),
        ("ATE m", 8, "%.3f", lambda path: [path.ate()])]
    lines = ["%-20s %-9s %-12s %6s %5s" % ("set", "", "against", "images", "lost") +
             "".join("%*s" % (width, head) for head, width, *_ in columns) + "%7s" % "ms"]
    for name, rows in sets:
        for row in rows:
            cells = [(width, form, value(row.path)) for _, width, form, value in columns] + [(7, "%.2f", [row.ms])]
            lines.append("%-20s %-9s %-12s %6d %5s" % (name, row.path.name, row.against, row.images, row.lost) +
                         "".join("%*s" % (width, "-" if math.isnan(figures[0]) else form % tuple(figures))
                                 for width, form, figures in cells))
    return "\n".join(lines) + "\n" + LEGEND


def nees_table(sets):
    rows = [(name, row) for name, drives in sets for row in drives if row.nees]
    if not rows:
        return ""
    found = {what for _, row in rows for what in row.nees}
    parts = sorted(what for what in found if isinstance(what, tuple))
    columns = [what for what in ("pair", "twist") if what in found] + parts
    heads = [what if isinstance(what, str) else "%g %s" % (what[1], what[0]) for what in columns]
    lines = ["%-20s %-9s %-12s" % ("NEES of", "", "against") + "".join("%15s" % head for head in heads) + "%14s" % "noise"]
    for name, row in rows:
        cells = ["%.2f %.2f %d" % (median(values), np.quantile(values, 0.9), len(values)) if values else "-"
                 for values in (row.nees.get(what) for what in columns)]
        metres, radians = np.median(row.noise, axis=0) if len(row.noise) else (math.nan, math.nan)
        lines.append("%-20s %-9s %-12s" % (name, row.path.name, row.against) + "".join("%15s" % cell for cell in cells) +
                     "%14s" % ("%.1f %.3f" % (1e3 * metres, math.degrees(radians))))
    return "\n" + "\n".join(lines) + "\n" + NEES_LEGEND


def plot(sets, file):
    """A row for each set: the paths from above, if the first camera is level, and the errors over the length."""
    plt = pyplot()
    if not plt:
        return
    figure, axes = grid_of(plt, 3, len(sets), (4, 3.4))
    for (name, rows), (above, translation, rotation) in zip(sets, axes):
        above.set_title(name, fontsize=9)
        lines = {}
        for row in rows:
            lines.setdefault(row.against, row.path.truth)
            lines.setdefault(row.path.name, row.path.poses)
        for label, poses in lines.items():
            seen = [inverse(poses[0]) @ pose for pose in poses]
            above.plot([pose[0, 3] for pose in seen], [pose[2, 3] for pose in seen], linewidth=1.2, label=label,
                       color="black" if label == "truth" else None)
        above.set_aspect("equal", adjustable="datalim")
        above.legend(fontsize=8)
        above.set_xlabel("x of the first camera, m", fontsize=9)
        above.set_ylabel("z, m", fontsize=9)
        for row in rows:
            lengths = [length for length in LENGTHS if row.path.parts(length)]
            for axis, k in ((translation, 0), (rotation, 1)):
                axis.plot(lengths, [row.path.drift([length])[k] for length in lengths], marker="o", markersize=3,
                          label="%s, %s" % (row.path.name, row.against))
        for axis, label in ((translation, "translation, %"), (rotation, "rotation, degrees per 100 m")):
            if not any(row.path.parts(LENGTHS[0]) for row in rows):
                axis.text(0.5, 0.5, "the path is shorter than %d m" % LENGTHS[0], ha="center", transform=axis.transAxes, fontsize=9)
            axis.set_xlabel("length of the part, m", fontsize=9)
            axis.set_ylabel(label, fontsize=9)
            axis.set_ylim(bottom=0)
        if any(row.path.parts(LENGTHS[0]) for row in rows):
            rotation.legend(fontsize=8)
    figure.tight_layout()
    with naming(file):
        figure.savefig(file, dpi=100)
    print("wrote %s" % file, file=sys.stderr)


def report(lines, plot_file, peers, witnesses=(), leave_out=0, align=False, witness_noise=WITNESS_NOISE):
    sets = read(lines, peers, witnesses, leave_out, align, witness_noise)
    print(table(sets) + nees_table(sets) + without_truth(sets), end="")
    sets = [(name, rows) for name, rows in sets if len(rows[0].path.poses)]
    if plot_file and sets:
        plot(sets, plot_file)
