"""The paper's Figures 5, 6, 8 and 9, of the tables by name: dicts of the cells by their heading."""
import math
import os

from report.common import grouped, naming, pyplot


def groups(rows, *keys):
    return grouped(rows, lambda row: tuple(row[key] for key in keys))


def column(rows, key):
    return [float(row[key]) for row in rows]


def line(axis, rows, x, label, value, low=None, high=None, **style):
    drawn, = axis.plot(column(rows, x), column(rows, value), marker="o", markersize=3, linewidth=1.2, label=label,
                       **style)
    if low:
        axis.fill_between(column(rows, x), column(rows, low), column(rows, high), alpha=0.2, linewidth=0,
                          color=drawn.get_color())


LEAST_WIDTH = 6.4  # inches of a figure: one panel alone is wider than its share of many
LEGEND_LINE, LEGEND_LETTER, LEGEND_HANDLE = 0.2, 0.07, 0.6  # inches, of font size 8


def grid_of(plt, count, rows_of_panels, size=(3.2, 2.6), **options):
    """Panels of that size, inches each; few ones are wider."""
    figure, axes = plt.subplots(rows_of_panels, count, figsize=(max(LEAST_WIDTH, size[0] * count), size[1] * rows_of_panels),
                                squeeze=False, **options)
    for axis in axes.flat:
        axis.grid(True, linewidth=0.3)
        axis.tick_params(labelsize=8)
    return figure, axes


def panels_of(plt, sequences, labels):
    """A column for each sequence, a row for each label, over presets. One empty column without sequences: Table 1 has
    no rows when ratio 1/2 was not asked for."""
    figure, axes = grid_of(plt, max(1, len(sequences)), len(labels))
    for axis, (sequence,) in zip(axes[0], sequences):
        axis.set_title(sequence, fontsize=9)
    for axis in axes[-1]:
        axis.set_xlabel("preset number of features", fontsize=9)
    for axis, label in zip(axes[:, 0], labels):
        axis.set_ylabel(label, fontsize=9)
    return figure, axes


def save(figure, folder, name, legend_of=None):
    """With the legend of one of its panels below all of them, if given: inside it would cover curves."""
    lines = 0
    if legend_of and legend_of.get_legend_handles_labels()[1]:
        handles, labels = legend_of.get_legend_handles_labels()
        width = LEGEND_HANDLE + LEGEND_LETTER * max(map(len, labels))
        columns = max(1, min(len(labels), int(figure.get_figwidth() / width)))
        lines = math.ceil(len(labels) / columns)
        figure.legend(handles, labels, loc="lower center", ncol=columns, fontsize=8)
    figure.tight_layout(rect=(0, (0.1 * (lines > 0) + LEGEND_LINE * lines) / figure.get_figheight(), 1, 1))
    path = os.path.join(folder, name + ".png")
    with naming(path):
        figure.savefig(path, dpi=100)


def figure5(plt, folder, rows):
    sequences = groups(rows, "sequence")
    figure, axes = panels_of(plt, sequences, ("matches kept", "filter stage [ms]"))
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


def figure6(plt, folder, rows):
    """Against the paper's ratio where there is one: the growth with the presets, Figure 5, would hide all else."""
    sequences = groups(rows, "sequence")
    ratios = list(groups(rows, "ratio"))
    base = ("1/2",) if ("1/2",) in ratios else ratios[0]
    figure, axes = panels_of(plt, sequences, ["matches kept, %% above %s" % base, "filter stage, %% above %s" % base,
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


def figures8_9(plt, folder, rows):
    sequences = groups(rows, "sequence")
    for name, value, label in (("figure8", "matches", "matches kept"), ("figure9", "filter ms", "filter stage [ms]"),
                               ("hypotheses", "hypotheses", "hypotheses drawn")):
        figure, axes = panels_of(plt, sequences, (label,))
        for axis, part in zip(axes[0], sequences.values()):
            for (method,), rows in groups(part, "method").items():
                line(axis, rows, "preset", method, value)
            axis.set_ylim(bottom=0)
        save(figure, folder, name, legend_of=axes[0][0])


def draw(folder, tables):
    plt = pyplot()
    if not plt:
        return
    figure5(plt, folder, tables["table1"])
    figure6(plt, folder, tables["table2_3"])
    figures8_9(plt, folder, tables["fig8_9"])
    plt.close("all")
    print("wrote %s/figure5.png, figure6.png, figure8.png, figure9.png and hypotheses.png" % folder)
