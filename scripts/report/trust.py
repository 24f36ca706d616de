"""`evaluate trust`: how often an answer that is OK is wrong, and whether covariances and match probabilities are true.
Writes pairs.csv, trust.md, trust.csv, risk_coverage.csv and .png, reliability.csv and .png, calibration.csv and .png;
doc/measured/trust.md defines each figure."""
import collections
import math
import os
import shutil
import sys
from types import SimpleNamespace

import numpy as np

from report import calibration
from report.common import (POSED, grouped, insert, markdown, name_of, naming, pyplot, read_units, share_interval, stretches,
                           write_csv)
from report.odometry import angle
from report.plots import grid_of, save

ENOUGH = 20  # answers of one set or scene, for a share of them to mean something
PLOTS = ("risk_coverage.png", "reliability.png", "calibration.png")
AXES = ("rx", "ry", "rz")
FAST = 90.0  # degrees a second
CONTRADICTED = 16.27 / 3  # normalised square of a rotation that its covariance allows in one of a thousand cases
# Rotation and direction in degrees; an answer with a larger error is wrong.
LIMITS = {"real": (3, 30), "rendered": (1, 20), "drawn": (1, 20), "sequence": (1, 20)}
TITLES = {"real": "Real images", "rendered": "Rendered scenes", "drawn": "Drawn scenes",
          "sequence": "Drawn sequences"}


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
    answered = sorted((a for a in answers if a.ok), key=lambda a: a.uncertainty_deg)
    wrong = np.cumsum([a.wrong for a in answered])
    count = np.arange(1, len(answered) + 1)
    return count / max(1, len(answers)), wrong / count


def spreads(covariance):
    """Standard deviation along the worst axis of 3 x 3 covariances, degrees."""
    return np.degrees(np.sqrt(np.maximum(0, np.linalg.eigvalsh(covariance)[:, -1])))


def normalized_squares(error, covariance):
    """e^T S^-1 e over the dimension: 1 on average where S is the covariance of e. NaN where S has no inverse."""
    usable = np.linalg.eigvalsh(covariance)[:, 0] > 0
    result = np.full(len(error), math.nan)
    solved = np.linalg.solve(covariance[usable], error[usable][..., None])[..., 0]
    result[usable] = np.sum(error[usable] * solved, axis=1) / error.shape[1]
    return result


def tangent_errors(estimate, truth, covariance):
    """In the tangent planes of unit vectors: the error of the estimate against the truth, radians, and the part of its
    covariance that lies there."""
    least = np.eye(3)[np.argmin(np.abs(estimate), axis=1)]
    first = np.cross(estimate, least)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    basis = np.stack((first, np.cross(estimate, first)), axis=2)
    angle = np.arctan2(np.linalg.norm(np.cross(estimate, truth), axis=1), np.sum(estimate * truth, axis=1))
    across = np.einsum("nij,ni->nj", basis, truth)
    length = np.linalg.norm(across, axis=1, keepdims=True)
    side = np.divide(across, length, out=np.tile([1.0, 0], (len(across), 1)), where=length > 0)  # behind: any will do
    return angle[:, None] * side, np.einsum("nji,njk,nkl->nil", basis, covariance, basis)


COLUMNS = ("kind", "set", "gap", "pair", "from_s", "to_s", "method", "status", "survivors", "inliers", "has_truth",
           "stationary", "baseline_m", "rate_deg_s", "moved", "right", "wrong", "rotation_wrong", "rotation_error_deg", "direction_error_deg", "rx_deg", "ry_deg",
           "rz_deg", "rotation_sigma_deg", "direction_sigma_deg", "uncertainty_deg", "nees_rotation", "nees_direction",
           "parallax_px", "sigma_px", "covariance", "reliability", "pose_probability", "pose_right", "rotation_probability",
           "rotation_right")


def row_of(record):
    """A line of pairs.csv, as far as the record says it by itself."""
    truth = record["truth"] if record["truth"] and record["truth"]["has_pose"] else None
    row = dict(dict.fromkeys(COLUMNS, math.nan), covariance=None)
    row.update((key, record[key]) for key in ("kind", "set", "method", "status", "stationary", "inliers", "reliability"))
    row.update(gap=record["gap"] or 0, survivors=record["matches_gms"], has_truth=truth is not None, moved=False,
               right=False, wrong=False, rotation_wrong=False, pair=(record["reference"] + " " + record["current"]).strip())
    row.update(calibration.columns_of(record))
    if record["stamp"] is not None:
        row.update(from_s=record.get("reference_stamp", math.nan), to_s=record["stamp"])
    if truth:
        row.update(baseline_m=float(np.linalg.norm(truth["translation_m"])), moved=truth["moved"])
        if "R" in truth and row["to_s"] > row["from_s"]:  # earlier versions recorded no rotation
            row.update(rate_deg_s=math.degrees(angle(np.reshape(truth["R"], (3, 3)))) / (row["to_s"] - row["from_s"]))
    if record["status"] in POSED:
        row.update(covariance=record["covariance"], parallax_px=record["median_parallax_px"],
                   sigma_px=record["sigma_px"] or 0.0)
    return row


def judge(records):
    """The rows of records: each answer held against what it says of itself and against the truth."""
    rows = [row_of(record) for record in records]
    posed = [(row, record) for row, record in zip(rows, records) if row["covariance"]]
    if not posed:
        return rows
    covariance = np.array([row["covariance"] for row, _ in posed]).reshape(-1, 6, 6)
    ok = np.array([row["status"] == "OK" for row, _ in posed])
    rotation_sigma = spreads(covariance[:, 3:, 3:])
    direction_sigma = np.where(ok, spreads(covariance[:, :3, :3]), math.nan)
    for (row, _), rotation, direction in zip(posed, rotation_sigma, direction_sigma):
        row.update(rotation_sigma_deg=rotation, direction_sigma_deg=direction, uncertainty_deg=rotation + direction)

    known = np.array([row["has_truth"] for row, _ in posed])
    posed = [entry for entry, has_truth in zip(posed, known) if has_truth]
    if not posed:
        return rows
    covariance, ok = covariance[known], ok[known]
    truths = [record["truth"] for _, record in posed]
    nothing = {"rotation": [0.0] * 9, "translation": [0.0] * 9, "translation_sigma": 0.0}
    noises = [truth["noise"] or nothing for truth in truths]
    noise = {key: np.array([n[key] for n in noises]).reshape(-1, 3, 3) for key in ("rotation", "translation")}
    error = np.array([truth["pose_error"]["rotation_vector_deg"] for truth in truths])
    nees_rotation = normalized_squares(np.radians(error), covariance[:, 3:, 3:] + noise["rotation"])

    baseline = np.array([row["baseline_m"] for row, _ in posed])
    t = np.array([record["t"] for _, record in posed])
    length = np.linalg.norm(t, axis=1)
    moved = np.array([row["moved"] for row, _ in posed])
    directed = moved & (length > 0)
    direction_error, nees_direction = np.full((2, len(posed)), math.nan)
    if directed.any():
        of_unit = noise["translation"][directed] / baseline[directed, None, None] ** 2
        tangent, of_tangent = tangent_errors(
            t[directed] / length[directed, None],
            np.array([truth["translation_m"] for truth in truths])[directed] / baseline[directed, None],
            covariance[directed, :3, :3] + of_unit)
        direction_error[directed] = np.degrees(np.linalg.norm(tangent, axis=1))
        nees_direction[directed] = np.where(ok[directed], normalized_squares(tangent, of_tangent), math.nan)

    rotation_limit, direction_limit = np.array([LIMITS[row["kind"]] for row, _ in posed]).T
    rotation_error = np.linalg.norm(error, axis=1)
    right = (rotation_error <= rotation_limit) & (~moved | (direction_error <= direction_limit))
    # An answer that is OK claims a direction; a camera that is known to be static has none.
    static = ~moved & np.array([n["translation_sigma"] == 0 for n in noises])
    wrong = ok & (~right | static)
    of_truth = np.degrees(np.sqrt(np.trace(noise["rotation"], axis1=1, axis2=2) / 3))
    rotation_wrong = rotation_error > rotation_limit + 2 * of_truth
    for k, (row, _) in enumerate(posed):
        row.update(zip(("rx_deg", "ry_deg", "rz_deg"), error[k]))
        row.update(rotation_error_deg=rotation_error[k], direction_error_deg=direction_error[k],
                   nees_rotation=nees_rotation[k], nees_direction=nees_direction[k], right=bool(right[k]),
                   wrong=bool(wrong[k]), rotation_wrong=bool(rotation_wrong[k]))
    return rows


def cell(value):
    """As in pairs.csv: booleans as 0 and 1, lists separated by blanks, nothing for what is no number."""
    if value is None or isinstance(value, float) and math.isnan(value):
        return ""
    if isinstance(value, list):
        return " ".join(cell(number) for number in value)
    if isinstance(value, bool):
        return str(int(value))
    return value if isinstance(value, str) else "%.12g" % value


def read(folder):
    """An answer for each row: its columns, and whether its pair is an even or an odd one of its set."""
    counts, answers = collections.Counter(), []
    for row in (row for unit in read_units(folder) for row in judge(unit)):
        key = row["set"], row["gap"], row["method"]
        answers.append(SimpleNamespace(**row, half=counts[key] % 2, ok=row["status"] == "OK",
                                       low=row["status"] == "LOW_PARALLAX",
                                       key=(row["kind"], row["set"], row["gap"], row["pair"], row["method"]),
                                       bins=np.reshape(row["reliability"], (-1, 3))))
        counts[key] += 1
    return answers


def figures(answers):
    """The figures of some answers of one method."""
    posed = [a for a in answers if a.has_truth]
    ok = [a for a in posed if a.ok]
    low = [a for a in posed if a.low]
    right = [a for a in posed if a.right and a.moved]
    row = dict(pairs=len(posed), ok=len(ok), wrong=sum(a.wrong for a in ok))
    row["wrong_percent"] = 100 * row["wrong"] / len(ok) if ok else math.nan
    row["stretches"] = stretches(ok)
    row["wrong_at_most"] = share_interval(row["wrong"], ok)[1]
    row["directions"] = sum(not math.isnan(a.direction_error_deg) for a in ok)
    row["right"], row["refused"] = len(right), sum(not a.ok for a in right)
    row["refused_percent"] = 100 * row["refused"] / len(right) if right else math.nan
    for name, values in (("rotation", [a.nees_rotation for a in ok]), ("direction", [a.nees_direction for a in ok]),
                         ("low", [a.nees_rotation for a in low])):
        for statistic, value in zip(("median", "mean", "p90"), spread(values)):
            row["nees_%s_%s" % (name, statistic)] = value
    row["low_parallax"] = len(low)
    for axis in AXES:
        row["bias_%s_deg" % axis], row["bias_%s_z" % axis] = bias([getattr(a, axis + "_deg") for a in ok])
    bins = sum((a.bins for a in answers), np.zeros((1, 3)))
    row["matches"], row["ece"] = int(bins[:, 0].sum()), calibration_error(bins)
    return row


def number(value, digits=2):
    if isinstance(value, float) and math.isnan(value):
        return "–"
    if isinstance(value, float):
        return "%.0f" % value if abs(value) >= 100 else "%.*f" % (digits, value)
    return str(value)


def wrong_cell(row):
    return "%d (%.1f %%)" % (row["wrong"], row["wrong_percent"]) if row["ok"] else "–"


def at_most_cell(row):
    return "%.1f %%" % row["wrong_at_most"] if row["ok"] else "–"


def refused_cell(row):
    return "%d of %d" % (row["refused"], row["right"]) if row["right"] else "–"


def nees_cell(row, name):
    values = [number(row["nees_%s_%s" % (name, statistic)]) for statistic in ("median", "mean", "p90")]
    return " / ".join(values) if any(value != "–" for value in values) else "–"


def bias_cell(row, axis):
    if math.isnan(row["bias_%s_deg" % axis]):
        return "–"
    return "%+.3f (%+.1f)" % (row["bias_%s_deg" % axis], row["bias_%s_z" % axis])


CELLS = {
    "pairs": lambda row: number(row["pairs"]), "OK": lambda row: number(row["ok"]), "wrong, at most": at_most_cell,
    "OK and wrong": wrong_cell, "stretches": lambda row: number(row["stretches"]),
    "direction judged": lambda row: number(row["directions"]),
    "refused though right": refused_cell, "NEES rotation": lambda row: nees_cell(row, "rotation"),
    "NEES direction": lambda row: nees_cell(row, "direction"), "LOW_PARALLAX": lambda row: number(row["low_parallax"]),
    "its NEES rotation": lambda row: nees_cell(row, "low"), "ECE": lambda row: number(row["ece"], 3)}
CELLS.update(("mean %s (z)" % axis, lambda row, axis=axis: bias_cell(row, axis)) for axis in AXES)
TRUSTED = ["pairs", "OK", "wrong, at most", "OK and wrong", "stretches", "direction judged"]
JUDGED = ["refused though right", "NEES rotation", "NEES direction"]


def cells(row, names):
    return [CELLS[name](row) for name in names]


def table(head, lines):
    return markdown(head, lines) + "\n"


def detail_table(rows, axes=AXES):
    names = TRUSTED + JUDGED + ["LOW_PARALLAX", "its NEES rotation"] + [
        "mean %s (z)" % axis for axis in axes] + ["ECE"]
    return table(["", "method"] + names, [[name, method] + cells(row, names) for (name, method), row in rows.items()])


def summary_table(kinds, details, halves=(0, 1)):
    """One line for each kind of input and method; with halves of the pairs, and the worst line of the details."""
    first, last = TRUSTED, JUDGED + ["ECE"]
    head = ["", "method"] + first + [("even pairs", "odd pairs")[half] for half in halves] + [
        "worst line of %d OK or more" % ENOUGH] + last
    lines = []
    for (kind, method), answers in kinds.items():
        row = figures(answers)
        wrong_of_half = [wrong_cell(figures([a for a in answers if a.half == half])) for half in halves]
        worst = max(((r["wrong_percent"], name) for (name, m), r in details[kind].items()
                     if m == method and r["ok"] >= ENOUGH), default=None)
        lines.append([kind, method] + cells(row, first) + wrong_of_half + ["%.0f %% %s" % worst if worst else "–"] +
                     cells(row, last))
    return table(head, lines)


def recordings_table(answers):
    """A line for each set over all gaps, of one method."""
    return table(["recording"] + TRUSTED, [[name] + cells(figures(part), TRUSTED) for name, part in
                                           grouped((a for a in answers if a.has_truth), lambda a: a.set).items()])


def statuses_table(answers):
    """What each status promises, of one method over all sets and gaps: rotations, directions where it is OK, rest where
    it is stationary."""
    known = [a for a in answers if a.has_truth]

    def line(name, part, wrong):
        against = sum(a.rotation_wrong and a.nees_rotation > CONTRADICTED for a in part)
        median, _, p90 = spread([a.nees_rotation for a in part])
        share = "%d (%.1f %%)" % (len(wrong), 100 * len(wrong) / len(part)) if part else "–"
        return [name, str(len(part)), share, str(against), number(median), number(p90)]

    ok, low, still = ([a for a in known if test(a)] for test in (
        lambda a: a.ok, lambda a: a.low, lambda a: a.stationary))
    return table(["status", "answers", "wrong", "against their covariance", "NEES of rotation p50", "p90"], [
        line("OK", ok, [a for a in ok if a.wrong]),
        line("LOW_PARALLAX", low, [a for a in low if a.rotation_wrong]),
        ["MOTION_UNKNOWN", str(sum(a.status == "MOTION_UNKNOWN" for a in known)), "no pose", "–", "–", "–"],
        line("stationary", still, [a for a in still if a.moved])])


def motions_table(answers):
    """A line for each set and method: its statuses, also of the pairs whose camera rotates faster than FAST."""
    def line(part):
        row, fast = figures(part), figures([a for a in part if a.rate_deg_s > FAST])
        low = sum(a.low for a in part)
        return [str(len(part)), number(row["ok"]), str(low), str(len(part) - row["ok"] - low), wrong_cell(row),
                nees_cell(row, "rotation"), nees_cell(row, "direction"), "%d of %d" % (fast["ok"], fast["pairs"]),
                wrong_cell(fast)]
    return table(["", "method", "pairs", "OK", "LOW_PARALLAX", "no pose", "OK and wrong", "NEES rotation", "NEES direction",
                  "above %.0f degrees/s: OK" % FAST, "of these wrong"],
                 [[name, method] + line(part) for (name, method), part in
                  grouped((a for a in answers if a.has_truth), lambda a: (name_of(a.set, a.gap), a.method)).items()])


def halves_table(answers):
    """What may be tuned on, the even pairs, beside what may not, the odd ones."""
    names = TRUSTED + JUDGED + ["ECE"]
    return table(["", "method", "half"] + names, [
        [kind, method, name] + cells(figures([a for a in part if a.half == half]), names)
        for (kind, method), part in grouped(answers, lambda a: (a.kind, a.method)).items()
        for half, name in enumerate(("even", "odd"))])


def kept_table(answers, before):
    """Of the answers that were OK and right in an earlier folder, those that still are."""
    now = {answer.key: answer for answer in answers}
    lines = []
    for (kind, method), earlier in grouped(before, lambda a: (a.kind, a.method)).items():
        good = [a for a in earlier if a.ok and a.has_truth and not a.wrong and a.key in now]
        kept = [a for a in good if now[a.key].ok and not now[a.key].wrong]
        lost = grouped([a for a in good if not (now[a.key].ok and not now[a.key].wrong)], lambda a: name_of(a.set, a.gap))
        most = sorted(lost.items(), key=lambda item: -len(item[1]))[:3]
        if good:
            lines.append([kind, method, "%d of %d (%.1f %%)" % (len(kept), len(good), 100 * len(kept) / len(good)),
                          "; ".join("%s: %d" % (name, len(group)) for name, group in most) or "–"])
    return table(["", "method", "still OK and right", "most lost"], lines)


def write_tables(folder, answers, before):
    """Writes trust.md and trust.csv. Returns what documents show, by the name of its marks: `tables`, a summary of each
    method and the real sets of the first; `recordings`, these sets alone."""
    details = {}
    for kind, part in grouped(answers, lambda a: a.kind).items():
        lines = grouped(part, lambda a: (name_of(a.set, a.gap), a.method))
        details[kind] = {key: figures(group) for key, group in lines.items()}
    head = list(next(iter(next(iter(details.values())).values())))
    write_csv(os.path.join(folder, "trust.csv"), ["kind", "set", "method"] + head,
              [[kind, name, method] + ["" if isinstance(v, float) and math.isnan(v) else v for v in row.values()]
               for kind, rows in details.items() for (name, method), row in rows.items()])
    kinds = grouped(answers, lambda a: (a.kind, a.method))
    first = answers[0].method
    recordings = recordings_table(kinds.get(("real", first), []))
    of_first = "### Real images, all gaps, %s\n\n%s" % (first, recordings)
    statuses = "### Each status, real images, all gaps\n\n" + "".join(
        "%s:\n\n%s\n" % (method, statuses_table(part)) for (kind, method), part in kinds.items() if kind == "real")
    text = ("### All\n\n" + summary_table(kinds, details) + of_first + statuses + "### Probabilities of pose and rotation\n\n" +
            calibration.table(kinds) + "\n### The two halves\n\n" + halves_table(answers))
    if before:
        text += "### Of what was OK and right before\n\n" + kept_table(answers, before)
    text += "".join("### %s\n\n%s" % (TITLES[kind], detail_table(rows)) for kind, rows in details.items())
    path = os.path.join(folder, "trust.md")
    with naming(path), open(path, "w") as stream:
        stream.write(text)
    real = dict((key, row) for key, row in details.get("real", {}).items() if key[1] == first and row["pairs"])
    return {"recordings": recordings, "statuses": statuses_table(kinds.get(("real", first), [])),
            "calibration": calibration.table({key: part for key, part in kinds.items() if key[1] == first}),
            "tables": "### All\n\n" + summary_table(kinds, details, halves=()) + of_first + statuses +
            "### Real images, each gap, %s\n\n%s" % (first, detail_table(real, axes=()))}


def write_curves(folder, answers):
    """risk_coverage.csv, reliability.csv and calibration.csv; returns the rows of the first two by (kind, method)."""
    kinds = grouped(answers, lambda a: (a.kind, a.method))
    risks = dict((key, risk_coverage([a for a in group if a.has_truth])) for key, group in kinds.items())
    write_csv(os.path.join(folder, "risk_coverage.csv"), ["kind", "method", "coverage", "risk"],
              [key + ("%.5f" % c, "%.5f" % r) for key, curve in risks.items() for c, r in zip(*curve)])
    bins = dict((key, sum(a.bins for a in group)) for key, group in kinds.items())
    bins = dict((key, rows) for key, rows in bins.items() if rows[:, 0].any()) or bins  # without labels: sequences
    write_csv(os.path.join(folder, "reliability.csv"), ["kind", "method", "matches", "probability", "right"],
              [key + (int(n), "%.4f" % (p / n), "%.4f" % (k / n))
               for key, rows in bins.items() for n, p, k in rows if n])
    calibration.write(folder, kinds)
    return risks, bins


def plot(plt, folder, name, curves, draw, labels):
    """A panel for each kind of input, a line for each method."""
    kinds = grouped(curves, lambda key: key[0])
    figure, axes = grid_of(plt, len(kinds), 1, (5, 4))
    for axis, (kind, keys) in zip(axes[0], kinds.items()):
        for place, key in enumerate(keys):
            draw(axis, curves[key], dict(label=key[1], linewidth=1.2, color=plt.get_cmap("tab10")(place % 10),
                                         linestyle="--" if place >= 10 else "-"))
        axis.set_title(TITLES[kind], fontsize=9)
        axis.set_xlabel(labels[0], fontsize=9)
    axes[0][0].set_ylabel(labels[1], fontsize=9)
    axes[0][0].legend(fontsize=7)
    save(figure, folder, name)


def draw_risk(axis, curve, style):
    axis.plot(curve[0], 100 * curve[1], **style)
    axis.set_ylim(0, max(1.0, axis.get_ylim()[1]))  # where nothing is wrong: a line at 0 of 1 %


def draw_reliability(axis, bins, style):
    bins = bins[bins[:, 0] > 0]
    axis.plot([0, 1], [0, 1], color="grey", linewidth=0.6)
    axis.plot(bins[:, 1] / bins[:, 0], bins[:, 2] / bins[:, 0], marker="o", markersize=3, **style)


def plot_all(folder, answers, risks, bins):
    plt = pyplot()
    if not plt:
        return
    of_first = [a for a in answers if a.method == answers[0].method]
    calibration.plot(plt, folder, grouped(of_first, lambda a: a.kind), TITLES)
    plot(plt, folder, "risk_coverage", risks, draw_risk,
         ("share of pairs answered, the most certain first", "wrong of these, %"))
    plot(plt, folder, "reliability", bins, draw_reliability, ("probability of a match", "share that is right"))


def copy_plots(document, folder):
    """Puts the plots that a document shows into the folder of its name."""
    beside = os.path.splitext(document)[0]
    with open(document) as stream:
        text = stream.read()
    for name in PLOTS:
        if "(%s/%s)" % (os.path.basename(beside), name) in text and os.path.exists(os.path.join(folder, name)):
            os.makedirs(beside, exist_ok=True)
            shutil.copy(os.path.join(folder, name), beside)


def motions(folder):
    """Prints the table of rendered motions, and writes it to motion.md of the folder."""
    text = motions_table(read(folder))
    path = os.path.join(folder, "motion.md")
    with naming(path), open(path, "w") as stream:
        stream.write(text)
    print(text, end="")


def report(path, with_tables=True, before=None, into=()):
    """Of a folder of measurements; of a file of records into the folder of its name without the ending."""
    answers = read(path)
    if not answers:
        sys.exit("evaluate_report.py: %s holds no answer" % path)
    folder = os.path.splitext(path)[0] if os.path.isfile(path) else path
    os.makedirs(folder, exist_ok=True)
    write_csv(os.path.join(folder, "pairs.csv"), COLUMNS, [[cell(getattr(a, key)) for key in COLUMNS] for a in answers])
    if not with_tables:
        return
    made = write_tables(folder, answers, read(before) if before else [])
    plot_all(folder, answers, *write_curves(folder, answers))
    for document in into:
        insert(document, made)
        copy_plots(document, folder)
    print("wrote trust.md, trust.csv, risk_coverage, reliability and calibration (.csv, .png) in " + folder)
