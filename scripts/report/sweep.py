"""`evaluate sweep`: success and effort of each method against the outlier ratio; medians over the trials."""
import csv
import json
import os
import sys

from report.common import grouped, match_truth, mean, median, naming, pose_errors, pyplot
from report.plots import grid_of, groups, line, save

# A trial is a success within these errors of rotation and direction, degrees: several times what a method reaches without
# outliers in the least favourable of its repetitions.
LIMITS = (1, 5)
MEDIANS = {
    "hypotheses": lambda trial: trial["hypotheses"],
    "models_scored": lambda trial: trial["models_scored"],
    "point_evaluations": lambda trial: trial["point_evaluations"],
    "milliseconds": lambda trial: trial["times_ms"]["ransac"],
    "precision": lambda trial: match_truth(trial)["kept_correct"] / max(1, trial["inliers"]),
    "recall": lambda trial: match_truth(trial)["kept_correct"] / max(1, match_truth(trial)["raw_correct"])}


def success(trial):
    return all(error < limit for error, limit in zip(pose_errors(trial), LIMITS))


def table(trials):
    rows = []
    for (method, order, ratio), part in grouped(trials, lambda t: (t["method"], t["order"], t["outlier_ratio"])).items():
        row = dict(method=method, order=order, outlier_ratio=ratio, trials=len(part),
                   success_rate=mean([success(trial) for trial in part]))
        row.update((key, median([figure(trial) for trial in part])) for key, figure in MEDIANS.items())
        rows.append({key: value if isinstance(value, str) else "%g" % value for key, value in row.items()})
    return rows


def report(lines, path, with_plot):
    with naming(path or "standard output"), open(path, "w", newline="") if path else sys.stdout as stream:
        rows = table(map(json.loads, lines))
        writer = csv.DictWriter(stream, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    if path and with_plot:
        plot(rows, os.path.splitext(path)[0])


def plot(rows, path):
    """Uniform sampling dashed, confidence order solid; methods with the same curves share one line and label."""
    plt = pyplot()
    if not plt:
        return
    curves = {}
    for (method,), part in groups(rows, "method").items():
        curve = tuple((row["success_rate"], row["hypotheses"]) for row in part)
        curves.setdefault(curve, []).append((method, part))
    figure, axes = grid_of(plt, 2, 1, (4.5, 3.6))
    for number, same in enumerate(curves.values()):
        label = ", ".join(method for method, _ in same)
        rows = same[0][1]
        style = {"linestyle": "--" if rows[0]["order"] == "uniform" else "-", "color": plt.get_cmap("tab10")(number % 10)}
        line(axes[0][0], rows, "outlier_ratio", label, "success_rate", **style)
        line(axes[0][1], rows, "outlier_ratio", label, "hypotheses", **style)
    axes[0][0].set_ylabel("success rate", fontsize=9)
    axes[0][1].set_ylabel("hypotheses drawn, median", fontsize=9)
    axes[0][1].set_yscale("log")
    for axis in axes[0]:
        axis.set_xlabel("outlier ratio", fontsize=9)
    axes[0][0].legend(fontsize=7, loc="lower left")
    save(figure, *os.path.split(path))
    print("wrote %s.png" % path, file=sys.stderr)
