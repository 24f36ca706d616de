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
    sys.exit("plot_tables.py: matplotlib is missing; install python3-matplotlib (the tables are complete without)")
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
        axis.fill_between(column(rows, x), column(rows, low), column(rows, high), alpha=0.2, linewidth=0,
                          color=drawn.get_color())


def grid_of(count, rows_of_panels):
    figure, axes = plt.subplots(rows_of_panels, count, figsize=(3.2 * count, 2.6 * rows_of_panels), squeeze=False)
    for axis in axes.flat:
        axis.grid(True, linewidth=0.3)
        axis.tick_params(labelsize=8)
    return figure, axes


def panels_of(sequences, labels):
    """A column for each sequence, a row for each label, over presets. One empty column without sequences: Table 1 has
    no rows when ratio 1/2 was not asked for."""
    figure, axes = grid_of(max(1, len(sequences)), len(labels))
    for axis, (sequence,) in zip(axes[0], sequences):
        axis.set_title(sequence, fontsize=9)
    for axis in axes[-1]:
        axis.set_xlabel("preset number of features", fontsize=9)
    for axis, label in zip(axes[:, 0], labels):
        axis.set_ylabel(label, fontsize=9)
    return figure, axes


def save(figure, folder, name, legend_of=None):
    """With the legend of one of its panels below all of them, if given: inside it would cover curves."""
    if legend_of:
        figure.legend(*legend_of.get_legend_handles_labels(), loc="lower center", ncol=7, fontsize=8)
    figure.tight_layout(rect=(0, 0.3 / figure.get_figheight() if legend_of else 0, 1, 1))
    figure.savefig(os.path.join(folder, name + ".png"), dpi=100)
    plt.close(figure)


def figure5(folder):
    sequences = groups(read(folder, "table1"), "sequence")
    figure, axes = panels_of(sequences, ("matches kept", "filter stage [ms]"))
    for panel, rows in enumerate(sequences.values()):
        line(axes[0][panel], rows, "preset", "median, p10 to p90", "matches", "matches p10", "matches p90")
        line(axes[1][panel], rows, "preset", "median, p10 to p90", "filter ms", "filter p10 ms", "filter p90 ms")
        for axis in axes[:, panel]:
            axis.set_ylim(bottom=0)
    if sequences:
        axes[0][0].legend(fontsize=8, loc="upper left")
    save(figure, folder, "figure5")


def against(rows, base, key):
    """Values of a column in percent above those of other rows, preset by preset."""
    reference = {row["preset"]: float(row[key]) for row in base}
    return [100 * (float(row[key]) / reference[row["preset"]] - 1) for row in rows]


def figure6(folder):
    """Against the paper's ratio where there is one: the growth with the presets, Figure 5, would hide all else."""
    sequences = groups(read(folder, "table2_3"), "sequence")
    ratios = list(groups(read(folder, "table2_3"), "ratio"))
    base = ("1/2",) if ("1/2",) in ratios else ratios[0]
    figure, axes = panels_of(sequences, ["matches kept, %% above %s" % base, "filter stage, %% above %s" % base,
                                         "hypotheses drawn"])
    for panel, part in enumerate(sequences.values()):
        by_ratio = groups(part, "ratio")
        for number, (ratio, rows) in enumerate(by_ratio.items()):
            colour = "black" if ratio == base else plt.get_cmap("plasma")(0.9 * number / max(1, len(ratios) - 1))
            style = {"marker": "o", "markersize": 3, "linewidth": 1.2, "color": colour, "label": ratio[0]}
            for axis, key in zip(axes[:2, panel], ("matches", "filter ms")):
                axis.plot(column(rows, "preset"), against(rows, by_ratio[base], key), **style)
            axes[2][panel].plot(column(rows, "preset"), column(rows, "hypotheses"), **style)
    save(figure, folder, "figure6", legend_of=axes[2][0])


def figures8_9(folder):
    sequences = groups(read(folder, "fig8_9"), "sequence")
    for name, value, label in (("figure8", "matches", "matches kept"), ("figure9", "filter ms", "filter stage [ms]"),
                               ("hypotheses", "hypotheses", "hypotheses drawn")):
        figure, axes = panels_of(sequences, (label,))
        for axis, part in zip(axes[0], sequences.values()):
            for (method,), rows in groups(part, "method").items():
                line(axis, rows, "preset", method, value)
            axis.set_ylim(bottom=0)
        save(figure, folder, name, legend_of=axes[0][0])


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
        style = {"linestyle": "--" if rows[0]["order"] == "uniform" else "-", "color": plt.get_cmap("tab10")(number % 10)}
        line(axes[0][0], rows, "outlier_ratio", label, "success_rate", **style)
        line(axes[0][1], rows, "outlier_ratio", label, "hypotheses", **style)
    figure.set_size_inches(9, 3.6)
    axes[0][0].set_ylabel("success rate", fontsize=9)
    axes[0][1].set_ylabel("hypotheses drawn, median", fontsize=9)
    axes[0][1].set_yscale("log")
    for axis in axes[0]:
        axis.set_xlabel("outlier ratio", fontsize=9)
    axes[0][0].legend(fontsize=7, loc="lower left")
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
