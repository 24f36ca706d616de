"""Statistics of records and what all reports write with."""
import contextlib
import csv
import json
import math
import os
import sys

import numpy as np

FAILED = 180.0  # degrees; the error of a pair without a pose
POSED = ("OK", "LOW_PARALLAX")
Z95 = 1.959964  # two-sided 95 % of a normal distribution
CLOCK = 1e8  # seconds; later stamps are of one clock for all recordings, earlier ones begin anew in each


def area(errors, limit):
    """Exact area under the recall-error curve up to the limit over the limit, percent: sorted errors raise the recall by
    1/n each, joined by straight lines (the convention of LoFTR's evaluation). NaN without errors."""
    errors = np.asarray(errors, float)
    if len(errors) == 0:
        return math.nan
    near = np.sort(errors[errors < limit])
    recall = np.arange(len(near) + 1) / len(errors)
    x, y = np.concatenate(([0], near, [limit])), np.append(recall, recall[-1])
    return 50 * np.sum((y[1:] + y[:-1]) * np.diff(x)) / limit


def median(values):
    return float(np.median(values)) if len(values) else math.nan


def mean(values):
    return float(np.mean(values)) if len(values) else math.nan


def match_truth(record):
    """Counts of correct matches, by epipolar lines where the set has them, else by transfer; None without truth."""
    truth = record["truth"] or {}
    return truth.get("epipolar") or truth.get("transfer")


def pose_errors(record):
    """(rotation, direction), degrees; None where the true pose is unknown."""
    truth = record["truth"]
    if not truth or not truth["has_pose"]:
        return None
    error = truth["pose_error"]
    return (error["rotation_deg"], error["direction_deg"]) if error else (FAILED, FAILED)


def name_of(dataset, gap):
    """A set or scene, and how many frames apart its images are."""
    return dataset + (", gap %d" % gap if gap else "")


def grouped(items, key):
    """{key of an item: items that have it}, in order of appearance."""
    found = {}
    for item in items:
        found.setdefault(key(item), []).append(item)
    return found


def wilson(events, trials):
    """95 % interval of a share (Wilson 1927), percent; all of it without trials."""
    if trials == 0:
        return 0.0, 100.0
    share, z2 = events / trials, Z95 * Z95
    middle = (share + z2 / (2 * trials)) / (1 + z2 / trials)
    half = Z95 / (1 + z2 / trials) * math.sqrt(share * (1 - share) / trials + z2 / (4 * trials * trials))
    return 100 * max(0.0, middle - half), 100 * min(1.0, middle + half)


def stretches(answers):
    """The largest number of pairs that have no part of a recording in common. Pairs that overlap err alike, and so do
    two cameras of a rig (`set/camera`); drawn and listed pairs, which have no stamps, are apart."""
    count = sum(math.isnan(a.to_s) for a in answers)
    timed = [a for a in answers if not math.isnan(a.to_s)]
    for recording in grouped(timed, lambda a: (a.kind, "" if a.to_s > CLOCK else a.set.split("/")[0])).values():
        end = -math.inf
        for answer in sorted(recording, key=lambda a: a.to_s):
            if answer.from_s >= end:
                count, end = count + 1, answer.to_s
    return count


def share_interval(events, answers):
    """95 % interval of the share of answers with an event, percent. Stretches are its trials, because answers that overlap
    err alike."""
    trials = stretches(answers)
    return wilson(events * trials / max(1, len(answers)), trials)


def records_of(lines):
    """Without their correspondences, of which a record has a megabyte once it is read."""
    for line in lines:
        record = json.loads(line)
        record.pop("correspondences", None)
        yield record


def lines_of(folder):
    """(line, unit) of a folder of measurements. A line that was cut off is left out."""
    with open(os.path.join(folder, "measurements.jsonl")) as stream:
        for line in stream:
            try:
                yield line, json.loads(line)
            except ValueError:
                continue


def read_units(path):
    """The records of each unit in a folder of measurements, in the order of the plan; those of a file are one unit."""
    if os.path.isfile(path):
        with open(path) as stream:
            return [list(records_of(stream))]
    units = {unit["unit"]: unit["runs"] for _, unit in lines_of(path)}
    return [units[number] for number in sorted(units)]


@contextlib.contextmanager
def naming(path):
    """An error while the file is written names it; Python names one that cannot be opened, but not a full disk."""
    try:
        yield
    except OSError as error:
        error.filename = path
        raise


def write_csv(path, head, rows):
    with naming(path), open(path, "w", newline="") as stream:
        csv.writer(stream, lineterminator="\n").writerows([head, *rows])


def markdown(head, rows):
    lines = ["| %s |\n" % " | ".join(row) for row in [head] + rows]
    return lines[0] + "|" + "---|" * len(head) + "\n" + "".join(lines[1:])


def replaced(text, made):
    """A document with what was made, by name, between `<!-- begin of the NAME -->` and `<!-- end of the NAME -->`; None
    if it has no such lines."""
    found = None
    for name, part in made.items():
        begin, end = "<!-- begin of the %s -->" % name, "<!-- end of the %s -->" % name
        if begin in text and end in text.split(begin)[1]:
            before, after = text.split(begin)
            found = text = before + begin + "\n\n" + part.strip("\n") + "\n\n" + end + after.split(end)[1]
    return found


def insert(document, made):
    """Replaces what is between the marks of a document; ends the program where it has none."""
    with open(document) as stream:
        text = replaced(stream.read(), made)
    if text is None:
        sys.exit("evaluate_report.py: %s has no lines '<!-- begin of the %s -->' and '<!-- end of ... -->'" %
                 (document, " -->' or '<!-- begin of the ".join(made)))
    with naming(document), open(document, "w") as stream:
        stream.write(text)


def printed(path):
    """What a program printed, as a document quotes it."""
    with open(path) as stream:
        return "".join("    %s" % line for line in stream)


def pyplot():
    """matplotlib.pyplot for files, or None with a sentence."""
    try:
        import matplotlib
    except ImportError:
        print("evaluate_report.py: no plots without matplotlib; install python3-matplotlib", file=sys.stderr)
        return None
    matplotlib.use("Agg")
    import matplotlib.pyplot
    return matplotlib.pyplot
