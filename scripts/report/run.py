"""`evaluate run`: a table with a row for each method, and a plot over time."""
import math
import sys

import numpy as np

from report.common import (FAILED, POSED, area, grouped, match_truth, mean, median, name_of, naming,
                           pose_errors, pyplot, records_of)
from report.plots import grid_of

SMALLEST = 1e-3  # degrees; smaller errors are drawn there, since the axis is logarithmic
STRIPS = {"OK": "tab:green", "LOW_PARALLAX": "tab:orange", "failed": "tab:red"}  # colours of the strip of statuses
LEGEND = """
OK low failed pairs with status OK, with LOW_PARALLAX (a rotation, no direction), and without a pose
AUC5/10/20    area under the recall curve of the larger of rotation and direction error, up to so many degrees, %;
              a missing pose counts as 180 degrees
RAUC2         the same of the rotation error alone, up to 2 degrees, %
R med deg     median rotation error of the posed pairs, degrees
prec %        kept matches that are correct, by the truth; mean over the pairs
recall %      points with a correct kept match, of the points with a correct raw match; mean over the pairs
kept correct  matches kept in a pair, and those of them that are correct; medians
hypoth.       hypotheses drawn, median
detect ...    milliseconds of each stage, medians; total is their sum
most          milliseconds of the longest robust stage (ransac)
-             the set has no truth for it
"""


def summarize(records):
    """The figures of one method. Matches are judged where there is a pose, or where the set has no poses."""
    errors = [pose_errors(record) for record in records]
    posed = [record["status"] in POSED for record in records]
    known = [error for error in errors if error]
    worst, rotation = [max(error) for error in known], [error[0] for error in known]
    judged = [(record, match_truth(record)) for record, error, has_pose in zip(records, errors, posed)
              if match_truth(record) and (has_pose or not error)]
    times = {stage: median([record["times_ms"][stage] for record in records])
             for stage in ("detect", "match", "gms", "ransac", "total")}
    return dict(
        times, most=max(record["times_ms"]["ransac"] for record in records),
        pairs=len(records), ok=sum(record["status"] == "OK" for record in records),
        low=sum(record["status"] == "LOW_PARALLAX" for record in records), failed=len(records) - sum(posed),
        auc5=area(worst, 5), auc10=area(worst, 10), auc20=area(worst, 20),
        rauc2=area(rotation, 2),
        rotation=median([error[0] for error, has_pose in zip(errors, posed) if error and has_pose]),
        precision=mean([100 * t["kept_correct"] / t["kept_known"] for _, t in judged if t["kept_known"]]),
        recall=mean([100 * t["kept_points"] / t["raw_points"] for _, t in judged if t["raw_points"]]),
        kept=median([record["inliers"] for record, _ in judged] or [record["inliers"] for record in records]),
        correct=median([t["kept_correct"] for _, t in judged]),
        hypotheses=median([record["hypotheses"] for record in records]))


COLUMNS = (("auc5", "AUC5", 7, 1), ("auc10", "AUC10", 7, 1), ("auc20", "AUC20", 7, 1), ("rauc2", "RAUC2", 7, 1),
           ("rotation", "R med deg", 11, 3), ("precision", "prec %", 8, 2), ("recall", "recall %", 10, 2),
           ("kept", "kept", 7, 0), ("correct", "correct", 8, 0), ("hypotheses", "hypoth.", 9, 0),
           ("detect", "detect", 8, 2), ("match", "match", 8, 2), ("gms", "gms", 8, 3), ("ransac", "ransac", 8, 3),
           ("most", "most", 7, 2), ("total", "total ms", 10, 2))


def table(by_method):
    lines = ["%-17s %5s %5s %5s %6s" % ("method", "pairs", "OK", "low", "failed") +
             "".join("%*s" % (width, head) for _, head, width, _ in COLUMNS)]
    for method, records in by_method.items():
        row = summarize(records)
        lines.append("%-17s %5d %5d %5d %6d" % (method, row["pairs"], row["ok"], row["low"], row["failed"]) + "".join(
            "%*s" % (width, "-" if math.isnan(row[key]) else "%.*f" % (digits, row[key]))
            for key, _, width, digits in COLUMNS))
    return "\n".join(lines) + "\n"


def running_median(values, window):
    """Medians of the values around each; NaN where there is none. The window is cut off at the ends."""
    half = window // 2
    around = [[v for v in values[max(0, k - half):k + half + 1] if not math.isnan(v)] for k in range(len(values))]
    return np.array([median(part) for part in around])


def plot(by_method, path):
    """Errors and inliers over time, or over the pairs where images have no stamps: a point for each pair, a line for
    the running median, and a strip of statuses for each method."""
    plt = pyplot()
    if not plt:
        return
    figure, axes = grid_of(plt, 1, 4, (10, 2.3), sharex=True,
                           gridspec_kw={"height_ratios": [3, 3, 3, 0.4 + 0.3 * len(by_method)]})
    axes = axes[:, 0]
    stamped = known = False
    for place, (method, records) in enumerate(by_method.items()):
        stamps = [record["stamp"] for record in records]
        stamped = None not in stamps
        x = np.asarray(stamps) - stamps[0] if stamped else np.arange(len(records))
        errors = np.array([pose_errors(record) or (math.nan, math.nan) for record in records], float)
        errors[errors == FAILED] = math.nan
        known = known or bool(np.isfinite(errors).any())
        colour = plt.get_cmap("tab10")(place % 10)
        window = max(1, len(records) // 40)
        inliers = np.array([record["inliers"] for record in records], float)
        for axis, values in zip(axes, (*np.maximum(errors, SMALLEST).T, inliers)):
            axis.plot(x, values, ".", markersize=3, alpha=0.35, color=colour)
            axis.plot(x, running_median(values, window), linewidth=1.3, color=colour, label=method)
        statuses = [record["status"] if record["status"] in POSED else "failed" for record in records]
        for status, strip in STRIPS.items():
            at = x[[name == status for name in statuses]]
            axes[3].plot(at, np.full(len(at), -place), "|", markersize=8, color=strip,
                         label=status if place == 0 else None)
    for axis, label in zip(axes, ("rotation error, degrees", "direction error, degrees", "inliers", "status")):
        axis.set_ylabel(label, fontsize=9)
    for axis in axes[:2]:
        if known:  # a logarithmic axis needs a value
            axis.set_yscale("log")
    axes[0].legend(fontsize=8, loc="upper right")
    axes[3].legend(fontsize=7, loc="upper left", bbox_to_anchor=(1, 1))
    axes[3].set_yticks([-place for place in range(len(by_method))])
    axes[3].set_yticklabels(list(by_method), fontsize=7)
    axes[3].set_ylim(0.6 - len(by_method), 0.6)
    axes[3].set_xlabel("seconds" if stamped else "pair")
    figure.tight_layout()
    with naming(path):
        figure.savefig(path, dpi=100)
    print("wrote %s" % path, file=sys.stderr)


def report(lines, plot_file):
    sets = grouped(records_of(lines), lambda record: name_of(record["set"], record["gap"]))
    several = len(sets) > 1
    for name, part in sets.items():
        print(name + "\n" if several else "", end="")
        print(table(grouped(part, lambda record: record["method"])), end="\n" if several else "")
    print(LEGEND, end="")
    if plot_file and sets:
        plot({method + (", " + name if several else ""): by_method for name, part in sets.items()
              for method, by_method in grouped(part, lambda record: record["method"]).items()}, plot_file)
