"""`evaluate tables`: the paper's tables, tables.md and a CSV file for each. doc/evaluate.md says what each figure is.
Columns in ms hold times; all others depend only on images and options."""
import fractions
import json
import os
import sys
import warnings

import numpy as np

from report import plots
from report.common import area, grouped, lines_of, markdown, match_truth, naming, pose_errors, read_units, write_csv

TABLE4_PRESET = 2000
RESAMPLES = 2000  # of the pairs, for an interval

# The paper's values, to compare with ours. Its counts and times are of another machine and of unnamed images.
PAPER_RATIOS = ("1/5", "1/4", "1/3", "1/2", "2/3", "3/4", "4/5")
PAPER_MATCHES = {  # Table 2
    1000: (47, 47, 51, 45, 47, 40, 52), 2000: (92, 128, 85, 126, 105, 125, 116),
    3000: (111, 128, 133, 138, 146, 136, 146), 4000: (124, 148, 152, 154, 160, 163, 154),
    5000: (132, 152, 171, 160, 168, 175, 170), 6000: (199, 190, 156, 195, 184, 203, 209),
    7000: (159, 217, 210, 213, 219, 222, 233), 8000: (179, 264, 234, 229, 246, 230, 215),
    9000: (231, 234, 252, 237, 270, 242, 260), 10000: (262, 284, 264, 274, 285, 272, 268)}
PAPER_TIMES = {  # Table 3, ms
    1000: (1.06, 1.38, 1.44, 2.11, 2.52, 3.48, 2.05), 2000: (3.13, 4.23, 4.31, 2.58, 2.67, 4.06, 4.23),
    3000: (5.34, 4.18, 7.95, 7.31, 6.39, 8.29, 5.89), 4000: (6.91, 5.5, 7.13, 7.43, 9.23, 8.5, 7.69),
    5000: (8.03, 8.34, 7.68, 7.5, 8.24, 10.91, 12.38), 6000: (7.01, 9.56, 7.7, 7.55, 8.17, 8.81, 8.62),
    7000: (4.2, 6.33, 8.22, 7.63, 8.58, 10.16, 8.54), 8000: (4.64, 7.46, 7.79, 7.73, 8.65, 10.01, 10.5),
    9000: (4.54, 8.96, 7.91, 7.98, 9.28, 11.41, 13.46), 10000: (4.23, 9.87, 9.46, 8.93, 10.97, 8.62, 12.76)}
PAPER_PRESETS = {  # Table 1: matches, ms
    1000: (45, 2.11), 2000: (126, 2.58), 2500: (131, 4.31), 3000: (138, 7.31), 3500: (144, 7.37), 4000: (154, 7.43),
    5000: (160, 7.50), 6000: (195, 7.55), 7000: (213, 7.63), 8000: (229, 7.73), 9000: (237, 7.98), 10000: (274, 8.93)}
# Table 5: the three sets (TUM desk, KITTI, TUM doll) and their mean.
PAPER_REDUCTIONS = {"gms_ransac": "37.19 / 28.32 / 30.48; 32.00", "lan": "18.26 / 24.22 / 6.29; 16.26"}
# Range of "precision" in Table 4 for GMS-RANSAC and the paper's method, percent, with the digits its counts prove.
PAPER_PRECISION = (61.55, 81.95)
NEVER_A_BASELINE = ("cp_ransac", "lo_prosac")


class Run:
    """One pipeline on one pair at one preset. Columns have one entry for each repetition of the robust stage."""

    def __init__(self, records, raw_points):
        """`raw_points`: current points of correct raw matches, the denominator of recall; None without truth."""
        first = records[0]
        self.sequence, self.pair = first["set"], first["reference"] + " " + first["current"]
        self.preset, self.method, self.model = first["features"], first["method"], first["model"]
        self.ratio = ratio_name(first["ratio"])
        column = {key: np.array([record[key] for record in records], float)
                  for key in ("inliers", "hypotheses", "models_scored", "point_evaluations")}
        times = {key: np.array([record["times_ms"][key] for record in records]) for key in first["times_ms"]}
        truths = [match_truth(record) for record in records if match_truth(record)]
        known, correct, points = (np.array([truth["kept_" + key] for truth in truths], float)
                                  for key in ("known", "correct", "points"))
        errors = np.array([pose_errors(record) for record in records if pose_errors(record)]).reshape(-1, 2)
        survivors, nothing = first["matches_gms"], np.empty(0)
        self.columns = dict(
            column, correct=correct, gms=np.array([survivors]), ransac_ms=times["ransac"],
            filter_ms=times["gms"] + times["ransac"], total_ms=times["total"],
            rotation_error=errors[:, 0], pose_error=errors.max(axis=1),
            # Percent. The paper's ratios need no truth: survivors of RANSAC over those of GMS, and over the preset.
            precision=100 * correct[known > 0] / known[known > 0], recall=100 * points / raw_points if raw_points else nothing,
            paper_precision=100 * column["inliers"] / survivors if survivors > 0 else nothing,
            paper_recall=100 * column["inliers"] / self.preset)


def runs_of(records):
    """The runs of a unit. Recall has the raw matches of the first for all: mutual matching leaves fewer to be found."""
    truth = match_truth(records[0])
    parts = grouped(records, lambda record: (record["method"], record["model"], record["ratio"]))
    return [Run(part, truth and truth["raw_points"]) for part in parts.values()]


def ratio_name(ratio):
    """ "1/5" for 0.2 and so on for the paper's ratios, else the number."""
    fraction = fractions.Fraction(ratio).limit_denominator(10)
    return "%d/%d" % (fraction.numerator, fraction.denominator) if abs(fraction - ratio) < 1e-9 else "%g" % ratio


def ratio_value(name):
    return float(fractions.Fraction(name))


def pick(runs, **values):
    return [run for run in runs if all(getattr(run, key) == value for key, value in values.items())]


def values_of(runs, key):
    """In order of appearance; presets and ratios ascending."""
    found = list(dict.fromkeys(getattr(run, key) for run in runs))
    return sorted(found) if key == "preset" else sorted(found, key=ratio_value) if key == "ratio" else found


def groups(runs, *keys):
    """(values of the keys, runs that have them), for all that occur."""
    if not keys:
        return [((), runs)]
    return [((value,) + others, part) for value in values_of(runs, keys[0])
            for others, part in groups(pick(runs, **{keys[0]: value}), *keys[1:])]


def pooled(runs, key):
    return np.concatenate([run.columns[key] for run in runs]) if runs else np.empty(0)


def text(value, digits):
    return "-" if np.isnan(value) else "%.*f" % (digits, value)


# Columns of a table: heading and what makes a cell of the runs of a row.

def quantile(heading, key, digits, percent=50):
    def cell(runs):
        values = pooled(runs, key)
        return text(np.percentile(values, percent) if len(values) else np.nan, digits)
    return heading, cell


def spread(heading, key, digits, unit=""):
    return [quantile(heading + part + unit, key, digits, percent)
            for part, percent in (("", 50), (" p10", 10), (" p90", 90))]


def mean(heading, key):
    def cell(runs):
        values = pooled(runs, key)
        return text(np.mean(values) if len(values) else np.nan, 2)
    return heading, cell


MATCHES, FILTER = spread("matches", "inliers", 0), spread("filter", "filter_ms", 3, " ms")
TOTAL = [quantile("total ms", "total_ms", 2)]


def area_of(heading, key, limit):
    return heading, lambda runs: text(area(pooled(runs, key), limit), 2)


def from_paper(preset, ratio=None):
    """Matches and ms that the paper prints, or dashes."""
    if ratio is None:
        figures = PAPER_PRESETS.get(preset)
    elif preset in PAPER_MATCHES and ratio in PAPER_RATIOS:
        place = PAPER_RATIOS.index(ratio)
        figures = PAPER_MATCHES[preset][place], PAPER_TIMES[preset][place]
    else:
        figures = None
    return [text(figures[0], 0), text(figures[1], 2)] if figures else ["-", "-"]


def table_of(runs, keys, columns):
    head = list(keys) + [heading for heading, _ in columns]
    return head, [[str(key) for key in row] + [cell(part) for _, cell in columns]
                  for row, part in groups(runs, *keys)]


def preset_table(runs):
    runs = pick(runs, method="cp_ransac", model=main_model(runs), ratio="1/2")
    effort = [quantile("GMS", "gms", 0), mean("precision", "precision"), mean("recall", "recall"),
              quantile("hypotheses", "hypotheses", 0), quantile("models scored", "models_scored", 0),
              quantile("point evaluations", "point_evaluations", 0)]
    head, rows = table_of(runs, ("sequence", "preset"), MATCHES + effort + FILTER + TOTAL)
    return head + ["paper matches", "paper ms"], [row + from_paper(int(row[1])) for row in rows]


def ratio_table(runs):
    runs = pick(runs, method="cp_ransac", model=main_model(runs))
    columns = MATCHES + spread("hypotheses", "hypotheses", 0) + FILTER
    head, rows = table_of(runs, ("sequence", "preset", "ratio"), columns)
    return head + ["paper matches", "paper ms"], [row + from_paper(int(row[1]), row[2]) for row in rows]


def precision_table(runs):
    def inside(runs):
        values = pooled(runs, "paper_precision")
        within = len(values) and PAPER_PRECISION[0] <= np.median(values) <= PAPER_PRECISION[1]
        return "yes" if within else "no"
    columns = ([quantile("GMS", "gms", 0), quantile("kept", "inliers", 0)] +
               spread("paper precision", "paper_precision", 2, " %") +
               [quantile("paper recall %", "paper_recall", 2), mean("precision %", "precision"),
                mean("recall %", "recall")] +
               [area_of("AUC%d" % limit, "pose_error", limit) for limit in (5, 10, 20)] +
               [area_of("RAUC2", "rotation_error", 2), quantile("hypotheses", "hypotheses", 0),
                ("in the paper's 62-82 %", inside)])
    return table_of(pick(runs, preset=TABLE4_PRESET, ratio="1/2"), ("sequence", "model", "method"), columns)


def trend_table(runs):
    columns = MATCHES + [quantile("correct", "correct", 0), quantile("hypotheses", "hypotheses", 0)] + FILTER + TOTAL
    return table_of(pick(runs, model=main_model(runs), ratio="1/2"), ("sequence", "preset", "method"), columns)


# Comparisons: a figure of the pairs, and its 95 % interval when pairs are drawn with replacement.

def comparisons(runs):
    """What is compared with which baseline, each two once."""
    names = values_of(runs, "method")
    return [(ours, base) for i, ours in enumerate(names) for j, base in enumerate(names)
            if i != j and base not in NEVER_A_BASELINE and (i < j or ours in NEVER_A_BASELINE)]


def draws(pairs):
    """All pairs, then RESAMPLES times as many at random."""
    drawn = np.random.RandomState(0).randint(pairs, size=(RESAMPLES, pairs))
    return np.concatenate((np.arange(pairs)[None], drawn))


def with_interval(figures):
    """ "31.2 [28.0, 34.1]" of what draws() gave."""
    low, high = np.percentile(figures[1:], (2.5, 97.5))
    return "%s [%s, %s]" % (text(figures[0], 2), text(low, 2), text(high, 2))


def difference(ours, base, key, figure):
    """ours - base of a figure of the pooled repetitions of pairs; "-" where nothing was measured."""
    if len(pooled(ours, key)) == 0 or len(pooled(base, key)) == 0:
        return "-"
    pairs = values_of(ours, "pair")
    of_ours, of_base = ([pooled(pick(runs, pair=pair), key) for pair in pairs] for runs in (ours, base))

    def of_draw(places):
        drawn = [np.concatenate([columns[place] for place in places]) for columns in (of_ours, of_base)]
        return figure(drawn[0]) - figure(drawn[1]) if all(map(len, drawn)) else np.nan
    return with_interval([of_draw(places) for places in draws(len(pairs))])


def reduction(ours, base, key):
    """Mean over presets of (base - ours) / base, percent, of the medians over pairs of each pair's median repetition."""
    if not ours or not base:
        return "-"
    pairs, presets = values_of(ours, "pair"), values_of(ours, "preset")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of medians of nothing, which are NaN
        medians = np.array([[[np.median(pooled(pick(runs, preset=preset, pair=pair), key)) for pair in pairs]
                             for preset in presets] for runs in (base, ours)])
        medians[:, np.isnan(medians).any(axis=0)] = np.nan
        of_base, of_ours = np.nanmedian(medians[:, :, draws(len(pairs))], axis=-1)
        of_base[of_base <= 0] = np.nan
        return with_interval(np.nanmean(100 * (of_base - of_ours) / of_base, axis=0))


def difference_table(runs):
    head = ["sequence", "model", "method", "baseline", "paper precision", "recall", "AUC10", "RAUC2"]
    rows = []
    for (sequence, model), part in groups(pick(runs, preset=TABLE4_PRESET, ratio="1/2"), "sequence", "model"):
        for method, baseline in comparisons(part):
            sides = pick(part, method=method), pick(part, method=baseline)
            rows.append([sequence, model, method, baseline, difference(*sides, "paper_precision", np.mean),
                         difference(*sides, "recall", np.mean),
                         difference(*sides, "pose_error", lambda errors: area(errors, 10)),
                         difference(*sides, "rotation_error", lambda errors: area(errors, 2))])
    return head, rows


def reduction_table(runs):
    head = ["sequence", "method", "baseline", "hypotheses", "point evaluations", "robust-stage ms", "filter-stage ms",
            "total ms", "paper ms"]
    rows = []
    for (sequence,), part in groups(pick(runs, model=main_model(runs), ratio="1/2"), "sequence"):
        for method, baseline in comparisons(part):
            sides = pick(part, method=method), pick(part, method=baseline)
            rows.append([sequence, method, baseline] +
                        [reduction(*sides, key) for key in ("hypotheses", "point_evaluations", "ransac_ms", "filter_ms",
                                                            "total_ms")] +
                        [PAPER_REDUCTIONS.get(baseline, "-") if method == "cp_ransac" else "-"])
    return head, rows


def significance_table(runs):
    runs = pick(runs, model=main_model(runs), method="cp_ransac")
    rows = [[sequence, ratio] + [reduction(part, pick(runs, sequence=sequence, ratio="1/2"), key)
                                 for key in ("inliers", "hypotheses", "filter_ms")]
            for (sequence, ratio), part in groups(runs, "sequence", "ratio") if ratio != "1/2"]
    return ["sequence", "ratio", "matches", "hypotheses", "filter-stage ms"], [row for row in rows if row[2:] != ["-"] * 3]


def main_model(runs):
    """The one that most runs use."""
    models = [run.model for run in runs]
    return max(sorted(set(models)), key=models.count)


TABLES = (
    ("table1", "Table 1 and Figure 5: cp_ransac at ratio 1/2 for growing presets; medians, p10 and p90 over pairs and "
     "seeds", preset_table),
    ("table2_3", "Tables 2 and 3 and Figure 6: cp_ransac at each grouping ratio; medians, p10 and p90 over pairs and "
     "seeds", ratio_table),
    ("table4", "Table 4: 2000 features; the paper's ratios beside true precision, recall and pose errors",
     precision_table),
    ("table4_differences", "Table 4, differences: method less baseline at 2000 features, points, with its 95 % interval "
     "over pairs", difference_table),
    ("table5", "Table 5: reduction against each baseline, percent, mean over presets with its 95 % interval over pairs",
     reduction_table),
    ("ratio_significance", "Change of each ratio against the paper's 1/2, percent (positive: fewer), mean over presets "
     "with its 95 % interval over pairs; an interval that holds 0 shows no difference", significance_table),
    ("fig8_9", "Figures 8 and 9: matches and time of each method for growing presets; medians over pairs and seeds",
     trend_table))


def refuse(folder, reason):
    print("evaluate_report.py: %s: %s" % (folder, reason), file=sys.stderr)
    sys.exit(2)


def merge(parts, folder, with_plots):
    """Joins what `evaluate tables --shard` wrote into folders, with the same options, in a new one, and makes its tables."""
    plans, lines = [], {}
    for part in parts:
        plan = os.path.join(part, "plan.json")
        if not os.path.exists(plan):
            refuse(part, "holds no plan.json, so it is no folder of measurements")
        with open(plan) as stream:
            plans.append(stream.read())
        if plans[-1] != plans[0]:
            refuse(part, "was measured with other options or sets than the first folder")
        if os.path.exists(os.path.join(part, "measurements.jsonl")):
            for line, unit in lines_of(part):
                lines.setdefault(unit["unit"], line)
    os.makedirs(folder, exist_ok=True)
    if os.path.exists(os.path.join(folder, "measurements.jsonl")):
        refuse(folder, "already holds measurements; choose another --out")
    for name, texts in (("plan.json", plans[:1]), ("measurements.jsonl", lines.values())):
        path = os.path.join(folder, name)
        with naming(path), open(path, "w") as stream:
            stream.writelines(texts)
    report(folder, with_plots)


def report(folder, with_plots):
    units = read_units(folder)
    if not units:
        sys.exit("evaluate_report.py: %s holds no measurement" % folder)
    runs = [run for unit in units for run in runs_of(unit)]
    with open(os.path.join(folder, "plan.json")) as stream:
        plan = json.dumps(json.load(stream), separators=(",", ":"), ensure_ascii=False)
    document = "# Tables\n\n%d pieces of work. Settings: `%s`\n" % (len(units), plan)
    made = {}
    for name, title, make in TABLES:
        head, rows = make(runs)
        write_csv(os.path.join(folder, name + ".csv"), head, rows)
        document += "\n## %s\n\n%s" % (title, markdown(head, rows))
        made[name] = [dict(zip(head, row)) for row in rows]
    path = os.path.join(folder, "tables.md")
    with naming(path), open(path, "w") as stream:
        stream.write(document)
    print("wrote %s/tables.md and its .csv files" % folder)
    if with_plots:
        plots.draw(folder, made)
