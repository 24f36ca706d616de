#!/usr/bin/env python3
"""Fits the weights of the probabilities of a pose and of its rotation to records of `evaluate run`.

  fit_probability.py RECORDS... [--write]

RECORDS: files that `evaluate run SET --gaps 1,5,10 --out FILE` and `evaluate run --scenes drawn --out FILE` wrote, of sets
with truth. Prints how well weights that were fitted without a set predict it (cross-validation by set), and the table for
src/core/judgement/probability.cpp; --write replaces the table there.

The probability is a product of logistic factors, one for each piece of evidence, because any of them may rule a pose out.
Slopes and offsets are held by a prior: the limits below, and steps of that evidence which change the odds by e.
scripts/report/calibration.py defines what is right.
"""
import argparse
import json
import pathlib
import re
import sys

import numpy
from scipy.optimize import minimize

from report.calibration import is_judged, rights_of

SOURCE = pathlib.Path(__file__).resolve().parent.parent / "src/core/judgement/probability.cpp"
# Evidence: logarithmic, limit, step (negative: less is better), word if it weighs most.
POSE = {
    "rotation": (False, 2.5, 1, "kRotationExplains"),
    "static": (False, 0.45, -0.1, "kMostlyStatic"),
    "infinity": (False, 0.45, -0.07, "kMostlyStatic"),
    "rotation_sigma": (True, 1, -0.5, "kRotation"),
    "direction_sigma": (True, 1, -0.5, "kDirection"),
    "other_motion": (False, 1, 0.5, "kOtherMotion"),
    "second_body": (False, 0.7, -0.125, "kOtherMotion"),
    "torn": (False, 4, -1, "kOtherMotion"),
    "votes": (False, 0.35, 0.1, "kVotes"),
    "unconfirmed": (True, 0.5, -0.5, "kUnconfirmed"),
    "fixed_to_camera": (False, 0.1, -0.1, "kFixedToCamera"),
}
ROTATION = {
    "rotation_spread": (True, 3, -0.5, "kNone"),
    "rotation_votes": (False, 0.35, 0.1, "kNone"),
    "seen": (False, 0.15, 0.1, "kNone"),
    "inlier_share": (False, 0.5, 0.17, "kNone"),
}
PRIOR_OFFSET, PRIOR_SLOPE, PRIOR = 2, 1, 0.03  # in steps; weight of the prior
MOST = 20  # steps from the limit
# A set counts as so many pairs at most: all real ones alike, drawn and rendered scenes less, since there are many.
PAIRS_OF_SET, PAIRS_OF_SCENE = 60, 15


class Pair:
    """A record: evidence, and what of it the truth confirms (None: not known)."""

    def __init__(self, record):
        self.set, self.status, self.real = record["set"], record["status"], record["kind"] == "real"
        self.group = "sequence" if self.set.startswith("sequence") else re.sub("_noise_.*|_[0-9.]+$", "", self.set)
        self.evidence = record["judgement"]["evidence"]
        self.probability = record["pose_probability"], record["rotation_probability"]
        self.pose_right, _, self.rotation_right = rights_of(record)


def read(files):
    pairs = []
    for name in files:
        with open(name) as lines:
            for line in lines:
                record = json.loads(line)
                if is_judged(record):
                    pairs.append(Pair(record))
    return pairs


def columns(pairs, rows):
    """Steps from the limit, NaN where there is no evidence."""
    table = numpy.full((len(pairs), len(rows)), numpy.nan)
    for k, (name, (logarithmic, limit, step, _)) in enumerate(rows.items()):
        values = numpy.array([numpy.nan if p.evidence[name] is None else p.evidence[name] for p in pairs], float)
        if logarithmic:
            values, limit = numpy.log(numpy.maximum(values, 1e-6)), numpy.log(limit)
        table[:, k] = numpy.clip((values - limit) / step, -MOST, MOST)
    return table


def log_odds(parameters, table):
    """Infinite where there is no evidence: its factor is 1."""
    offsets, slopes = numpy.split(parameters, 2)
    return numpy.where(numpy.isnan(table), numpy.inf, offsets + slopes * numpy.nan_to_num(table))


def log_probability(odds):
    return -numpy.logaddexp(0, -odds).sum(axis=1)


def predict(parameters, table):
    return numpy.exp(log_probability(log_odds(parameters, table)))


def fit(table, right, weights):
    steps, n = numpy.nan_to_num(table), table.shape[1]
    weights = weights / weights.sum()

    def loss(parameters):
        offsets, slopes = numpy.split(parameters, 2)
        odds = log_odds(parameters, table)
        log_p = log_probability(odds)
        p = numpy.minimum(numpy.exp(log_p), 1 - 1e-9)
        value = -(weights * numpy.where(right, log_p, numpy.log1p(-p))).sum()
        value += PRIOR * (((slopes - PRIOR_SLOPE) ** 2).sum() + ((offsets - PRIOR_OFFSET) ** 2).sum() / 4)
        outer = -weights * numpy.where(right, 1, -p / (1 - p))
        inner = 1 / (1 + numpy.exp(odds))
        of_offsets = (outer[:, None] * inner).sum(axis=0) + PRIOR * (offsets - PRIOR_OFFSET) / 2
        of_slopes = (outer[:, None] * inner * steps).sum(axis=0) + 2 * PRIOR * (slopes - PRIOR_SLOPE)
        return value, numpy.concatenate([of_offsets, of_slopes])

    start = numpy.concatenate([numpy.full(n, PRIOR_OFFSET), numpy.full(n, PRIOR_SLOPE)]).astype(float)
    bounds = [(None, None)] * n + [(0, None)] * n  # monotone in each piece of evidence
    return minimize(loss, start, jac=True, method="L-BFGS-B", bounds=bounds).x


def weights_of(pairs):
    counts = {}
    for pair in pairs:
        counts[pair.group] = counts.get(pair.group, 0) + 1
    return numpy.array([min(1, (PAIRS_OF_SET if p.real else PAIRS_OF_SCENE) / counts[p.group]) for p in pairs])


def cross_validated(pairs, table, right):
    groups, predicted = numpy.array([p.group for p in pairs]), numpy.zeros(len(pairs))
    for group in sorted(set(groups)):
        rest = groups != group
        weights = weights_of([p for p, use in zip(pairs, rest) if use])
        predicted[~rest] = predict(fit(table[rest], right[rest], weights), table[~rest])
    return predicted


def report(title, pairs, predicted, right, was_answered):
    for kind in ("real", "drawn or rendered"):
        chosen = numpy.array([p.real == (kind == "real") for p in pairs])
        if not chosen.any():
            continue
        p, ok, before = predicted[chosen], right[chosen], was_answered[chosen]
        order = numpy.argsort(-p, kind="stable")
        risk = numpy.cumsum(~ok[order]) / numpy.arange(1, len(p) + 1)
        print(f"{title}, {kind}: {len(p)} pairs, {ok.sum()} right; area under the risk-coverage curve "
              f"{100 * risk.mean():.2f} %; answered {before.sum()}, {(before & ~ok).sum()} wrong; as many of the most "
              f"probable: {(~ok[order])[:before.sum()].sum()} wrong")
        for low in numpy.arange(0, 1, 0.1):
            inside = (p >= low) & (p < low + 0.1 + (low > 0.85))
            if inside.any():
                print(f"    {low:.1f} to {low + 0.1:.1f}: {inside.sum():5d} pairs, {100 * ok[inside].mean():5.1f} % right")


def table_text(rows, parameters):
    offsets, slopes = numpy.split(parameters, 2)
    lines = []
    for (name, (logarithmic, limit, step, word)), offset, slope in zip(rows.items(), offsets, slopes):
        at = numpy.log(limit) if logarithmic else limit
        enumerator = name.title().replace("_", "")
        lines.append(f'    {{Evidence::k{enumerator}, "{name}", {str(logarithmic).lower()}, '
                     f"{offset - slope * at / step:.3g}, {slope / step:.3g}, DirectionDoubt::{word}}},")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, allow_abbrev=False,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("records", nargs="+")
    parser.add_argument("--write", action="store_true", help="replaces the table in the source")
    arguments = parser.parse_args()
    pairs = read(arguments.records)
    if not pairs:
        sys.exit("fit_probability.py: the records hold no judged pair with truth")
    tables = []
    for title, rows, use, label, answered in (
            ("pose", POSE, lambda p: p.pose_right is not None, lambda p: p.pose_right, "OK"),
            ("rotation", ROTATION, lambda p: p.status != "OK", lambda p: p.rotation_right, "LOW_PARALLAX")):
        chosen = [p for p in pairs if use(p)]
        right = numpy.array([label(p) for p in chosen])
        table = columns(chosen, rows)
        report(title, chosen, cross_validated(chosen, table, right), right,
               numpy.array([p.status == answered for p in chosen]))
        tables.append(table_text(rows, fit(table, right, weights_of(chosen))))
    text = f"constexpr Weight kOfPose[] = {{\n{tables[0]}\n}};\nconstexpr Weight kOfRotation[] = {{\n{tables[1]}\n}};\n"
    print(text)
    if arguments.write:
        source = SOURCE.read_text()
        begin = source.index("\n", source.index("// begin of the weights")) + 1
        SOURCE.write_text(source[:begin] + text + source[source.index("// end of the weights"):])


if __name__ == "__main__":
    main()
