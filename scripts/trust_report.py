#!/usr/bin/env python3
"""Tables and plots of the answers that `evaluate trust` held against the truth (pairs.csv of its folder): trust.md,
trust.csv, risk_coverage.csv and .png, reliability.csv and .png. doc/trust.md says what each figure is."""
import argparse
import csv
import math
import os
import shutil
import sys
from collections import OrderedDict

try:
    import numpy as np
except ImportError:
    sys.exit("trust_report.py: numpy is missing; install python3-numpy")

Z95 = 1.959964  # two-sided 95 % of a normal distribution
ENOUGH = 20  # answers of one set or scene, for a share of them to mean something
BEGIN, END = "<!-- begin of the tables -->", "<!-- end of the tables -->"
PLOTS = ("risk_coverage.png", "reliability.png")
AXES = ("rx", "ry", "rz")
TITLES = {"real": "Real images", "rendered": "Rendered scenes", "drawn": "Drawn scenes"}


def wilson(events, trials):
    """95 % interval of a share (Wilson 1927), percent; all of it without trials."""
    if trials == 0:
        return 0.0, 100.0
    share, z2 = events / trials, Z95 * Z95
    middle = (share + z2 / (2 * trials)) / (1 + z2 / trials)
    half = Z95 / (1 + z2 / trials) * math.sqrt(share * (1 - share) / trials + z2 / (4 * trials * trials))
    return 100 * max(0.0, middle - half), 100 * min(1.0, middle + half)


def calibration_error(bins):
    """Expected calibration error: the distance of each bin's mean probability from its share of right matches, weighed
    by its matches (Naeini, Cooper & Hauskrecht 2015). `bins`: rows of count, sum of probabilities, right ones."""
    total = bins[:, 0].sum()
    return np.abs(bins[:, 1] - bins[:, 2]).sum() / total if total else math.nan


def spread(values):
    """Median, mean and 90th percentile."""
    values = np.asarray([value for value in values if not math.isnan(value)])
    if len(values) == 0:
        return math.nan, math.nan, math.nan
    return float(np.median(values)), float(np.mean(values)), float(np.percentile(values, 90))


def bias(values):
    """Signed mean and its z, the mean over its standard error."""
    values = np.asarray([value for value in values if not math.isnan(value)])
    if len(values) < 2:
        return math.nan, math.nan
    error = np.std(values, ddof=1) / math.sqrt(len(values))
    return float(np.mean(values)), float(np.mean(values) / error) if error > 0 else math.nan


def risk_coverage(answers):
    """Share of all pairs that is answered OK, and share of these that is wrong, while the most certain come first."""
    answered = sorted((a for a in answers if a.ok), key=lambda a: a.uncertainty)
    wrong = np.cumsum([a.wrong for a in answered])
    count = np.arange(1, len(answered) + 1)
    return count / max(1, len(answers)), wrong / count


class Answer:
    """One line of pairs.csv."""

    def __init__(self, row, number):
        real = lambda key: float(row[key]) if row[key] else math.nan  # noqa: E731
        self.kind, self.set, self.gap, self.method = row["kind"], row["set"], int(row["gap"]), row["method"]
        self.half = number % 2
        self.key = (row["kind"], row["set"], row["gap"], row["pair"], row["method"])
        self.has_truth, self.moved = row["has_truth"] == "1", row["moved"] == "1"
        self.right, self.wrong = row["right"] == "1", row["wrong"] == "1"
        self.ok, self.low = row["status"] == "OK", row["status"] == "LOW_PARALLAX"
        self.uncertainty = real("uncertainty_deg")
        self.nees_rotation, self.nees_direction = real("nees_rotation"), real("nees_direction")
        self.rotation = [real(axis + "_deg") for axis in AXES]
        self.bins = np.asarray([float(x) for x in row["reliability"].split()]).reshape(-1, 3)


def read(folder):
    path = os.path.join(folder, "pairs.csv")
    counts = {}
    answers = []
    with open(path, newline="") as stream:
        for row in csv.DictReader(stream):
            key = (row["set"], row["gap"], row["method"])
            counts[key] = counts.get(key, -1) + 1
            answers.append(Answer(row, counts[key]))
    return answers


def groups(answers, key):
    found = OrderedDict()
    for answer in answers:
        found.setdefault(key(answer), []).append(answer)
    return found


def figures(answers):
    """The figures of some answers of one method."""
    posed = [a for a in answers if a.has_truth]
    ok = [a for a in posed if a.ok]
    low = [a for a in posed if a.low]
    right = [a for a in posed if a.right and a.moved]
    row = OrderedDict(pairs=len(posed), ok=len(ok), wrong=sum(a.wrong for a in ok))
    row["wrong_percent"] = 100 * row["wrong"] / len(ok) if ok else math.nan
    row["wrong_low"], row["wrong_high"] = wilson(row["wrong"], len(ok))
    row["right"], row["refused"] = len(right), sum(not a.ok for a in right)
    row["refused_percent"] = 100 * row["refused"] / len(right) if right else math.nan
    for name, values in (("rotation", [a.nees_rotation for a in ok]), ("direction", [a.nees_direction for a in ok]),
                         ("low", [a.nees_rotation for a in low])):
        for statistic, value in zip(("median", "mean", "p90"), spread(values)):
            row["nees_%s_%s" % (name, statistic)] = value
    row["low_parallax"] = len(low)
    for k, axis in enumerate(AXES):
        row["bias_%s_deg" % axis], row["bias_%s_z" % axis] = bias([a.rotation[k] for a in ok])
    bins = sum(a.bins for a in answers)
    row["matches"], row["ece"] = int(bins[:, 0].sum()), calibration_error(bins)
    return row


def number(value, digits=2):
    if isinstance(value, float) and math.isnan(value):
        return "–"
    if isinstance(value, float):
        return "%.0f" % value if abs(value) >= 100 else "%.*f" % (digits, value)
    return str(value)


def markdown(head, rows):
    text = "| " + " | ".join(head) + " |\n|" + "---|" * len(head) + "\n"
    return text + "".join("| " + " | ".join(row) + " |\n" for row in rows) + "\n"


def wrong_cell(row):
    if row["ok"] == 0:
        return "–"
    return "%d (%.1f %%, %.1f–%.1f)" % (row["wrong"], row["wrong_percent"], row["wrong_low"], row["wrong_high"])


def refused_cell(row):
    return "%d of %d" % (row["refused"], row["right"]) if row["right"] else "–"


def nees_cell(row, name):
    return " / ".join(number(row["nees_%s_%s" % (name, statistic)]) for statistic in ("median", "mean", "p90"))


def bias_cell(row, axis):
    if math.isnan(row["bias_%s_deg" % axis]):
        return "–"
    return "%+.3f (%+.1f)" % (row["bias_%s_deg" % axis], row["bias_%s_z" % axis])


def detail_table(rows):
    head = ["", "method", "pairs", "OK", "OK and wrong", "refused though right", "NEES rotation", "NEES direction",
            "LOW_PARALLAX", "its NEES rotation", "mean rx (z)", "ry", "rz", "ECE"]
    return markdown(head, [[name, method, number(row["pairs"]), number(row["ok"]), wrong_cell(row), refused_cell(row),
                            nees_cell(row, "rotation"), nees_cell(row, "direction"), number(row["low_parallax"]),
                            nees_cell(row, "low")] + [bias_cell(row, axis) for axis in AXES] + [number(row["ece"], 3)]
                           for (name, method), row in rows.items()])


def summary_table(kinds, details):
    """One line for each kind of input and method; with both halves of the pairs, and the worst line of the details."""
    head = ["", "method", "pairs", "OK", "OK and wrong", "even pairs", "odd pairs", "worst line of %d OK or more" % ENOUGH,
            "refused though right", "NEES rotation", "NEES direction", "ECE"]
    lines = []
    for (kind, method), answers in kinds.items():
        row = figures(answers)
        halves = [wrong_cell(figures([a for a in answers if a.half == half])) for half in (0, 1)]
        worst = max(((r["wrong_percent"], name) for (name, m), r in details[kind].items()
                     if m == method and r["ok"] >= ENOUGH), default=None)
        lines.append([kind, method, number(row["pairs"]), number(row["ok"]), wrong_cell(row)] + halves +
                     ["%.0f %% %s" % worst if worst else "–", refused_cell(row), nees_cell(row, "rotation"),
                      nees_cell(row, "direction"), number(row["ece"], 3)])
    return markdown(head, lines)


def halves_table(answers):
    """What may be tuned on, the even pairs, beside what may not, the odd ones."""
    head = ["", "method", "half", "pairs", "OK", "OK and wrong", "refused though right", "NEES rotation",
            "NEES direction", "ECE"]
    lines = []
    for (kind, method), part in groups(answers, lambda a: (a.kind, a.method)).items():
        for half, name in enumerate(("even", "odd")):
            row = figures([a for a in part if a.half == half])
            lines.append([kind, method, name, number(row["pairs"]), number(row["ok"]), wrong_cell(row), refused_cell(row),
                          nees_cell(row, "rotation"), nees_cell(row, "direction"), number(row["ece"], 3)])
    return markdown(head, lines)


def name_of(answer):
    return answer.set + (", gap %d" % answer.gap if answer.gap else "")


def kept_table(answers, before):
    """Of the answers that were OK and right in an earlier folder, those that still are."""
    now = {answer.key: answer for answer in answers}
    lines = []
    for (kind, method), earlier in groups(before, lambda a: (a.kind, a.method)).items():
        good = [a for a in earlier if a.ok and a.has_truth and not a.wrong and a.key in now]
        kept = [a for a in good if now[a.key].ok and not now[a.key].wrong]
        lost = groups([a for a in good if not (now[a.key].ok and not now[a.key].wrong)], name_of)
        most = sorted(lost.items(), key=lambda item: -len(item[1]))[:3]
        if good:
            lines.append([kind, method, "%d of %d (%.1f %%)" % (len(kept), len(good), 100 * len(kept) / len(good)),
                          "; ".join("%s: %d" % (name, len(group)) for name, group in most) or "–"])
    return markdown(["", "method", "still OK and right", "most lost"], lines)


def write_csv(path, head, rows):
    with open(path, "w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(head)
        writer.writerows(rows)


def write_tables(folder, answers, methods, before):
    """trust.md, trust.csv; returns the Markdown."""
    details = OrderedDict()
    for kind, part in groups(answers, lambda a: a.kind).items():
        details[kind] = OrderedDict((key, figures(group))
                                    for key, group in groups(part, lambda a: (name_of(a), a.method)).items())
    head = list(next(iter(next(iter(details.values())).values())))
    write_csv(os.path.join(folder, "trust.csv"), ["kind", "set", "method"] + head,
              [[kind, name, method] + ["" if isinstance(v, float) and math.isnan(v) else v for v in row.values()]
               for kind, rows in details.items() for (name, method), row in rows.items()])
    text = "### All\n\n" + summary_table(groups(answers, lambda a: (a.kind, a.method)), details)
    text += "### The two halves\n\n" + halves_table([a for a in answers if not methods or a.method in methods])
    if before:
        text += "### Of what was OK and right before\n\n" + kept_table(answers, before)
    for kind, rows in details.items():
        rows = OrderedDict((key, row) for key, row in rows.items() if not methods or key[1] in methods)
        text += "### %s\n\n" % TITLES[kind] + detail_table(rows)
    with open(os.path.join(folder, "trust.md"), "w") as stream:
        stream.write(text)
    return text


def write_curves(folder, answers):
    """risk_coverage.csv and reliability.csv; returns their rows by (kind, method)."""
    kinds = groups(answers, lambda a: (a.kind, a.method))
    risks = OrderedDict((key, risk_coverage([a for a in group if a.has_truth])) for key, group in kinds.items())
    write_csv(os.path.join(folder, "risk_coverage.csv"), ["kind", "method", "coverage", "risk"],
              [key + ("%.5f" % c, "%.5f" % r) for key, curve in risks.items() for c, r in zip(*curve)])
    bins = OrderedDict((key, sum(a.bins for a in group)) for key, group in kinds.items())
    write_csv(os.path.join(folder, "reliability.csv"), ["kind", "method", "matches", "probability", "right"],
              [key + (int(n), "%.4f" % (p / n), "%.4f" % (k / n))
               for key, rows in bins.items() for n, p, k in rows if n])
    return risks, bins


def plot(folder, name, curves, draw, labels):
    """A panel for each kind of input, a line for each method."""
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    kinds = list(groups(curves, lambda key: key[0]))
    figure, axes = plt.subplots(1, len(kinds), figsize=(5 * len(kinds), 4), squeeze=False)
    for axis, kind in zip(axes[0], kinds):
        for number_of_method, (_, method) in enumerate(key for key in curves if key[0] == kind):
            style = {"label": method, "linewidth": 1.2, "color": plt.get_cmap("tab20")(number_of_method % 20)}
            draw(axis, curves[kind, method], style)
        axis.set_title(TITLES[kind], fontsize=9)
        axis.set_xlabel(labels[0], fontsize=9)
        axis.grid(True, linewidth=0.3)
    axes[0][0].set_ylabel(labels[1], fontsize=9)
    axes[0][0].legend(fontsize=7)
    figure.tight_layout()
    figure.savefig(os.path.join(folder, name + ".png"), dpi=100)
    plt.close(figure)


def draw_reliability(axis, bins, style):
    bins = bins[bins[:, 0] > 0]
    axis.plot([0, 1], [0, 1], color="grey", linewidth=0.6)
    axis.plot(bins[:, 1] / bins[:, 0], bins[:, 2] / bins[:, 0], marker="o", markersize=3, **style)


def plot_all(folder, risks, bins):
    try:
        plot(folder, "risk_coverage", risks, lambda axis, curve, style: axis.plot(curve[0], 100 * curve[1], **style),
             ("share of pairs answered, the most certain first", "wrong of these, %"))
        plot(folder, "reliability", bins, draw_reliability, ("probability of a match", "share that is right"))
    except ImportError:
        print("trust_report.py: no plots without matplotlib; install python3-matplotlib", file=sys.stderr)


def insert(document, tables, folder):
    """Puts the tables between the two marks of a document, and the plots into a folder of its name."""
    with open(document) as stream:
        text = stream.read()
    if BEGIN not in text or END not in text:
        sys.exit("trust_report.py: %s lacks the lines '%s' and '%s'" % (document, BEGIN, END))
    before, after = text.split(BEGIN)[0], text.split(END)[1]
    with open(document, "w") as stream:
        stream.write(before + BEGIN + "\n\n" + tables + END + after)
    beside = os.path.splitext(document)[0]
    os.makedirs(beside, exist_ok=True)
    for name in PLOTS:
        if os.path.exists(os.path.join(folder, name)):
            shutil.copy(os.path.join(folder, name), beside)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", help="of evaluate trust")
    parser.add_argument("--detail", default="", help="methods, with commas, that get a line for each set and scene; all")
    parser.add_argument("--before", help="an earlier folder of the same pairs: how many of its right answers are kept")
    parser.add_argument("--into", help="document whose marked tables are replaced")
    arguments = parser.parse_args()
    try:
        answers = read(arguments.folder)
        if not answers:
            sys.exit("trust_report.py: %s/pairs.csv holds no answer" % arguments.folder)
        tables = write_tables(arguments.folder, answers, [m for m in arguments.detail.split(",") if m],
                              read(arguments.before) if arguments.before else [])
        plot_all(arguments.folder, *write_curves(arguments.folder, answers))
        if arguments.into:
            insert(arguments.into, tables, arguments.folder)
    except OSError as error:
        sys.exit("trust_report.py: %s: %s" % (error.filename, error.strerror))
    print("wrote trust.md, trust.csv, risk_coverage and reliability (.csv, .png) in " + arguments.folder)
    return 0


if __name__ == "__main__":
    sys.exit(main())
