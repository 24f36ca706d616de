"""Whether motions and rotations are right, and whether pose_probability and rotation_probability tell how often.
Writes calibration.csv and .png."""
import os

import numpy as np

from report.common import grouped, markdown, mean, naming, share_interval, write_csv
from report.odometry import angle
from report.plots import grid_of, save

BINS = 10  # of equal width
PROBABILITIES = ("pose", "rotation")
# Degrees within which a motion is right. The truth of real sets is less exact than that of drawn and rendered ones.
ROTATION_LIMIT, DIRECTION_LIMIT = {True: 3, False: 1}, 20  # by whether the pair is real


def rotation_error(a, b):
    return np.degrees(angle(a.T @ b))


def direction_error(a, b):
    lengths = np.linalg.norm(a) * np.linalg.norm(b)
    return 180.0 if lengths < 1e-12 else np.degrees(np.arccos(np.clip(a @ b / lengths, -1, 1)))


def rights_of(record):
    """What the truth confirms of a judged pair: its likeliest motion (None: not known), the rotation of that motion, and
    the rotation without a translation. Right is up to 20 degrees of direction and 3 of rotation, on drawn and rendered
    scenes 1, beyond two deviations of the truth."""
    judgement, truth, real = record["judgement"], record["truth"], record["kind"] == "real"
    noise = truth["noise"] if real else None
    true_rotation, true_translation = np.reshape(truth["R"], (3, 3)), np.array(truth["translation_m"])
    limit, slack = ROTATION_LIMIT[real], 0
    if noise:
        limit += 2 * np.degrees(np.sqrt(np.trace(np.reshape(noise["rotation"], (3, 3))) / 3))
        if truth["moved"]:
            share = 2 * noise["translation_sigma"] / np.linalg.norm(true_translation)
            slack = np.degrees(np.arcsin(min(1, share)))
    of_motion, of_rotation = (bool(rotation_error(true_rotation, np.reshape(judgement[key], (3, 3))) <= limit)
                              for key in ("motion_R", "rotation_R"))
    if truth["moved"]:
        direction = direction_error(np.array(judgement["motion_t"]), true_translation)
        return bool(of_motion and direction <= DIRECTION_LIMIT + slack), of_motion, of_rotation
    return None if real and of_motion else False, of_motion, of_rotation


def is_judged(record):
    """The pair has a motion and a truth to hold it against."""
    return bool(record.get("judgement") and record["truth"] and record["truth"].get("R"))


def columns_of(record):
    """Probability and right of pose and rotation, as far as they are known. A rotation is the motion's where that is
    as probable as it."""
    if not is_judged(record):
        return {}
    pose, of_motion, of_rotation = rights_of(record)
    probabilities = [record[name + "_probability"] for name in PROBABILITIES]
    return dict(pose_probability=probabilities[0], pose_right=pose, rotation_probability=probabilities[1],
                rotation_right=of_motion if probabilities[0] >= probabilities[1] else of_rotation)


def bin_of(probability):
    return min(BINS - 1, int(BINS * probability))


def rows_of(answers, name):
    """A row for each bin that is not empty: its lower end, answers, right ones, their share with its 95 % interval in
    percent, and the mean probability."""
    known = [a for a in answers if getattr(a, name + "_right") in (True, False)]
    bins = grouped(known, lambda a: bin_of(getattr(a, name + "_probability")))
    rows = []
    for place in sorted(bins):
        part = bins[place]
        right = sum(getattr(a, name + "_right") for a in part)
        rows.append((place / BINS, len(part), right, 100 * right / len(part), *share_interval(right, part),
                     mean([getattr(a, name + "_probability") for a in part])))
    return rows


def cells(row):
    _, count, right, share, low, high, probability = row
    return ["%d" % count, "%.1f %%" % share, "%.1f to %.1f %%" % (low, high), "%.3f" % probability]


def table(kinds):
    """A line for each bin of either probability, of answers by (kind, method)."""
    names = ["answers", "right", "95 %", "mean"]
    lines = []
    for key, answers in kinds.items():
        rows = {name: {row[0]: cells(row) for row in rows_of(answers, name)} for name in PROBABILITIES}
        for start in sorted(set().union(*rows.values())):
            lines.append([*key, "%.1f to %.1f" % (start, start + 1 / BINS)] +
                         [cell for name in PROBABILITIES for cell in rows[name].get(start, ["–"] * len(names))])
    return markdown(["", "method", "probability"] + ["%s: %s" % (PROBABILITIES[0], name) for name in names] +
                    ["%s: %s" % (PROBABILITIES[1], name) for name in names], lines)


def write(folder, kinds):
    """calibration.csv of answers by (kind, method)."""
    write_csv(os.path.join(folder, "calibration.csv"),
              ["kind", "method", "probability of", "from", "answers", "right", "right %", "low %", "high %", "mean"],
              [key + (name, "%.1f" % row[0], row[1], row[2]) + tuple("%.4f" % value for value in row[3:])
               for key, answers in kinds.items() for name in PROBABILITIES for row in rows_of(answers, name)])


def draw(reliability, histogram, answers):
    """The share of right answers with its interval against their mean probability, and below how many there are."""
    reliability.plot([0, 1], [0, 100], color="grey", linewidth=0.6)
    for place, name in enumerate(PROBABILITIES):
        rows = np.array(rows_of(answers, name)).reshape(-1, 7)
        start, count, _, share, low, high, probability = rows.T
        colour = "C%d" % place
        reliability.errorbar(probability, share, yerr=np.maximum(0, (share - low, high - share)), color=colour, marker="o",
                             markersize=3, linewidth=1, capsize=2, elinewidth=0.8, label=name)
        width = 0.4 / BINS
        histogram.bar(start + 0.5 / BINS + (place - 0.5) * width, count, width, color=colour)
    histogram.set_yscale("symlog", linthresh=1)
    histogram.set_xlim(0, 1)
    histogram.set_axisbelow(True)
    reliability.set_ylim(-3, 103)


def plot(plt, folder, kinds, titles):
    """A column of panels for each kind of input of one method: {kind: answers}."""
    figure, axes = grid_of(plt, len(kinds), 2, (4, 2.8), sharex=True, gridspec_kw=dict(height_ratios=(2.5, 1)))
    for (reliability, histogram), (kind, answers) in zip(axes.T, kinds.items()):
        draw(reliability, histogram, answers)
        reliability.set_title(titles[kind], fontsize=9)
        histogram.set_xlabel("probability", fontsize=9)
    axes[0][0].set_ylabel("right, %", fontsize=9)
    axes[1][0].set_ylabel("answers", fontsize=9)
    axes[0][0].legend(fontsize=8, loc="lower right")
    save(figure, folder, "calibration")
