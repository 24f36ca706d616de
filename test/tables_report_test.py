#!/usr/bin/env python3
"""The statistics of scripts/tables_report.py against values worked out by hand and against the arithmetic of the paper."""
import math
import unittest

try:
    import numpy as np
except ImportError:
    raise SystemExit(77)  # skipped

import script_module

report = script_module.load("tables_report")


def run(method, pair="p0", preset=2000, ratio=0.5, survivors=1000, **columns):
    measured = dict(sequence="s", pair=pair, preset=preset, method=method, model="essential", ratio=ratio,
                    matches_gms=survivors, raw_points=-1, detect_ms=4.0, match_ms=2.0, gms_ms=1.0)
    for key in ("inliers", "known", "correct", "points", "hypotheses", "models_scored", "point_evaluations", "ransac_ms",
                "rotation_error", "pose_error"):
        measured[key] = columns.get(key, [])
    measured["raw_points"] = columns.get("raw_points", -1)
    return report.Run(measured)


class Figures(unittest.TestCase):
    def test_the_papers_ratios_reproduce_its_table_4(self):
        # Survivors of RANSAC and of GMS whose quotients are the table's digits.
        for kept, survivors, percent in ((897, 1188, 75.5051), (913, 1188, 76.8519), (548, 835, 65.6287),
                                         (514, 835, 61.5569), (1044, 1274, 81.9466)):
            columns = run("lan", survivors=survivors, inliers=[kept]).columns
            self.assertAlmostEqual(columns["paper_precision"][0], percent, places=4)
            self.assertAlmostEqual(columns["paper_recall"][0], kept / 20)
        self.assertEqual(len(run("lan", survivors=0, inliers=[0]).columns["paper_precision"]), 0)

    def test_reductions_of_table_5_average_to_the_claims(self):
        for printed in report.PAPER_REDUCTIONS.values():
            sets, mean = printed.split("; ")
            self.assertAlmostEqual(np.mean([float(figure) for figure in sets.split(" / ")]), float(mean), delta=5e-3)

    def test_precision_and_recall_where_the_truth_says_something(self):
        columns = run("lan", known=[10, 0], correct=[9, 0], points=[8, 4], raw_points=16).columns
        np.testing.assert_allclose(columns["precision"], [90])
        np.testing.assert_allclose(columns["recall"], [50, 25])

    def test_times_add_up(self):
        columns = run("lan", ransac_ms=[0.5]).columns
        np.testing.assert_allclose(columns["filter_ms"], [1.5])
        np.testing.assert_allclose(columns["total_ms"], [7.5])

    def test_area_under_the_recall_curve(self):
        # Errors 1 and 3 of two pairs, up to 4: a triangle to (1, 1/2), a trapezoid to (3, 1), a rectangle to 4.
        self.assertAlmostEqual(report.area(np.array([3.0, 1]), 4), 100 * (0.25 + 1.5 + 1) / 4)
        # Beyond the limit the recall stays where the last error left it.
        self.assertAlmostEqual(report.area(np.array([1.0, 180]), 5), 100 * (0.25 + 0.5 * 4) / 5)
        self.assertEqual(report.area(np.array([180.0, 180]), 20), 0)
        self.assertEqual(report.area(np.array([0.0, 0]), 5), 100)
        self.assertTrue(math.isnan(report.area(np.array([]), 5)))

    def test_names_of_ratios(self):
        self.assertEqual([report.ratio_name(x) for x in (0.2, 1 / 3, 2 / 3, 0.8, 1, 0.37)],
                         ["1/5", "1/3", "2/3", "4/5", "1/1", "0.37"])


class Comparisons(unittest.TestCase):
    def test_each_two_once_and_ours_no_baseline(self):
        runs = [run(method) for method in ("cp_ransac", "gms_ransac", "lan", "lo_prosac")]
        self.assertEqual(report.comparisons(runs),
                         [("cp_ransac", "gms_ransac"), ("cp_ransac", "lan"), ("gms_ransac", "lan"),
                          ("lo_prosac", "gms_ransac"), ("lo_prosac", "lan")])

    def test_reductions_are_of_the_same_pairs(self):
        # Pairs differ widely, but ours always draws a quarter less; a preset that one lacks does not count.
        base = [run("lan", "p%d" % k, preset, hypotheses=[10 ** k]) for k in range(3) for preset in (1000, 2000)]
        ours = [run("cp_ransac", "p%d" % k, 1000, hypotheses=[0.75 * 10 ** k]) for k in range(3)]
        self.assertEqual(report.reduction(ours, base, "hypotheses"), "25.00 [25.00, 25.00]")
        self.assertEqual(report.reduction([], base, "hypotheses"), "-")

    def test_differences_have_an_interval_over_the_pairs(self):
        base = [run("lan", "p%d" % k, pose_error=[k, k]) for k in range(8)]
        ours = [run("cp_ransac", "p%d" % k, pose_error=[k + 1, k - 1]) for k in range(8)]
        same = report.difference(ours, base, "pose_error", np.mean)
        self.assertEqual(same, "0.00 [0.00, 0.00]")
        crossed = [run("cp_ransac", "p%d" % k, pose_error=[k + 8 * (k % 2)]) for k in range(8)]
        low, high = report.difference(crossed, base, "pose_error", np.mean).split("[")[1].rstrip("]").split(", ")
        self.assertLess(0, float(low))
        self.assertLess(float(low), 4)
        self.assertLess(4, float(high))
        self.assertEqual(report.difference(ours, base, "rotation_error", np.mean), "-")


if __name__ == "__main__":
    unittest.main()
