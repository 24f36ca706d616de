#!/usr/bin/env python3
"""Draws the paper's Figures 5, 6, 8 and 9 from the folder that `evaluate tables` wrote, or success and effort against the
outlier ratio from the CSV file that `evaluate sweep` wrote: plot_tables.py FOLDER|SWEEP.csv"""
import csv
import os
import sys
from collections import OrderedDict

try:
    import matplotlib
except ImportError:
    sys.exit("plot_tables.py: matplotlib is missing; install python3-matplotlib (the tables themselves need nothing)")
matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend has to be chosen first)


def read_file(path):
    with open(path, newline="") as stream:
        return list(csv.DictReader(stream))


def read(folder, name):
    return read_file(os.path.join(folder, name + ".csv"))


def groups(rows, *keys):
    """Rows by the values of the keys, in order of appearance."""
    found = OrderedDict()
    for row in rows:
        found.setdefault(tuple(row[key] for key in keys), []).append(row)
    return found


def column(rows, key):
    return [float(row[key]) for row in rows]


def line(axis, rows, x, label, value, low=None, high=None, **style):
    drawn, = axis.plot(column(rows, x), column(rows, value), marker="o", markersize=3, linewidth=1.2, label=label,
                       **style)
    if low:
        axis.fill_between(column(rows, x), column(rows, low), column(rows, high), alpha=0.12, color=drawn.get_color())


def grid_of(count, rows_of_panels):
    figure, axes = plt.subplots(rows_of_panels, count, figsize=(3.6 * count, 2.9 * rows_of_panels), squeeze=False)
    for axis in axes.flat:
        axis.grid(True, linewidth=0.3)
        axis.tick_params(labelsize=7)
    return figure, axes


def save(figure, folder, name):
    figure.tight_layout()
    figure.savefig(os.path.join(folder, name + ".png"), dpi=90)
    plt.close(figure)


def figure5(folder):
    rows = read(folder, "table1")
    figure, axes = grid_of(2, 1)
    for (sequence,), part in groups(rows, "sequence").items():
        line(axes[0][0], part, "preset", sequence, "matches", "matches p10", "matches p90")
        line(axes[0][1], part, "preset", sequence, "filter ms", "filter p10 ms", "filter p90 ms")
    axes[0][0].set_ylabel("matches kept", fontsize=8)
    axes[0][1].set_ylabel("filter stage [ms]", fontsize=8)
    for axis in axes[0]:
        axis.set_xlabel("preset number of features", fontsize=8)
    axes[0][0].legend(fontsize=6)
    save(figure, folder, "figure5")


def figure6(folder):
    sequences = groups(read(folder, "table2_3"), "sequence")
    figure, axes = grid_of(len(sequences), 3)
    for panel, ((sequence,), part) in enumerate(sequences.items()):
        for (ratio,), rows in groups(part, "ratio").items():
            for axis, value in zip(axes[:, panel], ("matches", "filter ms", "hypotheses")):
                line(axis, rows, "preset", ratio, value)
        axes[0][panel].set_title(sequence, fontsize=8)
        axes[2][panel].set_xlabel("preset number of features", fontsize=8)
    for axis, label in zip(axes[:, 0], ("matches kept", "filter stage [ms]", "hypotheses drawn")):
        axis.set_ylabel(label, fontsize=8)
    axes[0][0].legend(fontsize=6, title="ratio", title_fontsize=6)
    save(figure, folder, "figure6")


def figures8_9(folder):
    sequences = groups(read(folder, "fig8_9"), "sequence")
    for name, value, label in (("figure8", "matches", "matches kept"), ("figure9", "filter ms", "filter stage [ms]"),
                               ("hypotheses", "hypotheses", "hypotheses drawn")):
        figure, axes = grid_of(len(sequences), 1)
        for panel, ((sequence,), part) in enumerate(sequences.items()):
            axis = axes[0][panel]
            for (method,), rows in groups(part, "method").items():
                line(axis, rows, "preset", method, value)
            axis.set_title(sequence, fontsize=8)
            axis.set_xlabel("preset number of features", fontsize=8)
        axes[0][0].set_ylabel(label, fontsize=8)
        axes[0][0].legend(fontsize=6)
        save(figure, folder, name)


def sweep(path):
    """Uniform sampling dashed, confidence order solid; methods with the same curves share one line and label."""
    curves = OrderedDict()
    for (method,), rows in groups(read_file(path), "method").items():
        curve = tuple((row["success_rate"], row["hypotheses"]) for row in rows)
        curves.setdefault(curve, []).append((method, rows))
    figure, axes = grid_of(2, 1)
    for number, same in enumerate(curves.values()):
        label = ", ".join(method for method, _ in same)
        rows = same[0][1]
        style = {"linestyle": "--" if rows[0]["order"] == "uniform" else "-", "color": plt.get_cmap("tab20")(number % 20)}
        line(axes[0][0], rows, "outlier_ratio", label, "success_rate", **style)
        line(axes[0][1], rows, "outlier_ratio", label, "hypotheses", **style)
    axes[0][0].set_ylabel("success rate", fontsize=8)
    axes[0][1].set_ylabel("hypotheses drawn, median", fontsize=8)
    axes[0][1].set_yscale("log")
    for axis in axes[0]:
        axis.set_xlabel("outlier ratio", fontsize=8)
    axes[0][0].legend(fontsize=5, loc="lower left")
    folder, name = os.path.split(os.path.splitext(path)[0])
    save(figure, folder, name)


def main():
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        print(__doc__)
        return 0 if sys.argv[1:] and sys.argv[1] in ("-h", "--help") else 2
    try:
        if os.path.isfile(sys.argv[1]):
            sweep(sys.argv[1])
            print("wrote %s.png" % os.path.splitext(sys.argv[1])[0])
            return 0
        figure5(sys.argv[1])
        figure6(sys.argv[1])
        figures8_9(sys.argv[1])
    except OSError as error:
        sys.exit("plot_tables.py: %s: %s" % (error.filename, error.strerror))
    print("wrote %s/figure5.png, figure6.png, figure8.png, figure9.png and hypotheses.png" % sys.argv[1].rstrip("/"))
    return 0


if __name__ == "__main__":
    sys.exit(main())
