#!/usr/bin/env python3
"""The statistics of scripts/report against values worked out by hand and against the arithmetic of the paper."""
import ast
import contextlib
import io
import json
import math
import sys
import tempfile
import unittest
from pathlib import Path
from types import SimpleNamespace

try:
    import numpy as np
except ImportError:
    raise SystemExit(77)  # skipped

PROJECT = next(p for p in Path(__file__).resolve().parents if (p / "scripts/report").is_dir())
sys.path.insert(0, str(PROJECT / "scripts"))
from report import benchmark, calibration, odometry, plots, run, sweep, tables, trust  # noqa: E402
from report.common import area, insert, printed, pyplot, replaced, stretches, wilson  # noqa: E402


def record(**fields):
    """A record of a pair, with the fields that reports read."""
    result = dict(method="lan", model="essential", set="s", reference="p", current="q", gap=1, stamp=0.0, features=2000,
                  ratio=0.5, status="OK", stationary=False, matches_gms=1000, inliers=0, hypotheses=0, models_scored=0, point_evaluations=0,
                  truth=None, times_ms=dict(detect=4.0, match=2.0, gms=1.0, ransac=0.5, total=7.5))
    result.update(fields)
    return result


def counts(known, correct, points, raw_points=16):
    return dict(kept_known=known, kept_correct=correct, kept_points=points, raw_points=raw_points)


def truth(pose_error=None, epipolar=None, has_pose=True):
    error = pose_error and dict(rotation_deg=pose_error[0], direction_deg=pose_error[1])
    return dict(has_pose=has_pose, pose_error=error, epipolar=epipolar, transfer=None)


class Run(unittest.TestCase):
    def test_area_under_the_recall_curve(self):
        # Errors 1 and 3 of two pairs, up to 4: a triangle to (1, 1/2), a trapezoid to (3, 1), a rectangle to 4.
        self.assertAlmostEqual(area([3, 1], 4), 100 * (0.25 + 1.5 + 1) / 4)
        # Beyond the limit the recall stays where the last error left it.
        self.assertAlmostEqual(area([1, 180], 5), 100 * (0.25 + 0.5 * 4) / 5)
        self.assertEqual((area([180, 180], 20), area([0, 0], 5)), (0, 100))
        self.assertTrue(math.isnan(area([], 5)))

    def test_a_missing_pose_counts_as_180_degrees_and_its_matches_not_at_all(self):
        row = run.summarize([record(inliers=10, truth=truth((1, 2), counts(10, 9, 8))),
                             record(inliers=4, status="RANSAC_FAILED", truth=truth(None, counts(4, 0, 0)))])
        self.assertEqual((row["pairs"], row["ok"], row["failed"], row["kept"], row["correct"]), (2, 1, 1, 10, 9))
        self.assertEqual((row["rotation"], row["precision"], row["recall"]), (1, 90, 50))
        self.assertAlmostEqual(row["auc5"], area([2, 180], 5))
        self.assertAlmostEqual(row["rauc2"], area([1, 180], 2))

    def test_a_set_without_poses_has_matches_to_judge(self):
        row = run.summarize([record(inliers=10, status="UNCALIBRATED", truth=truth(None, counts(10, 5, 4), has_pose=False))])
        self.assertEqual((row["precision"], row["recall"]), (50, 25))
        self.assertIn("      -", run.table({"lan": [record()]}))

    def test_the_table_counts_statuses(self):
        statuses = ["OK", "OK", "LOW_PARALLAX", "RANSAC_FAILED"]
        row = run.table({"lan": [record(status=status) for status in statuses]}).splitlines()[1]
        self.assertEqual(row.split()[:5], ["lan", "4", "2", "1", "1"])

    def test_each_set_and_gap_has_a_table_of_its_own(self):
        def printed_of(*records):
            with contextlib.redirect_stdout(io.StringIO()) as printed_text:
                run.report(map(json.dumps, records), None)
            return printed_text.getvalue().splitlines()
        lines = printed_of(record(), record(gap=5, correspondences=[[1, 2, 3, 4, 1, 1]]), record(set="t", gap=None))
        heads = [k for k, line in enumerate(lines) if line.startswith("method")]
        self.assertEqual([lines[k - 1] for k in heads], ["s, gap 1", "s, gap 5", "t"])
        self.assertEqual(printed_of(record(), record())[0].split()[0], "method", "one set needs no name")

    def test_a_plot_is_drawn_with_and_without_truth(self):
        if not pyplot():
            self.skipTest("needs matplotlib")
        for known in (None, truth((0.1, 2)), truth(None)):
            with tempfile.TemporaryDirectory() as folder:
                run.plot({"lan": [record(truth=known), record(stamp=1.0, status="RANSAC_FAILED")]}, folder + "/plot.png")
                self.assertGreater(Path(folder, "plot.png").stat().st_size, 10000)

    def test_a_running_median_follows_what_is_there(self):
        np.testing.assert_allclose(run.running_median(np.array([1, 9, 2, math.nan, 4, 100]), 3), [5, 2, 5.5, 3, 52, 52])

    def test_a_sweep_holds_medians_and_the_share_of_successes(self):
        trials = [record(order="uniform", outlier_ratio=0.1, inliers=inliers,
                         truth=truth(error, dict(kept_correct=6, raw_correct=12)))
                  for inliers, error in ((8, (0.9, 4.9)), (12, (0.9, 5)))]
        (row,) = sweep.table(trials)
        self.assertEqual((row["trials"], row["success_rate"], row["milliseconds"]), ("2", "0.5", "0.5"))
        self.assertEqual((row["precision"], row["recall"]), ("0.625", "0.5"))

    def test_a_benchmark_has_medians_and_the_ratio_to_the_baseline(self):
        row = dict(stage="s", kept=None, correct=None)
        table = benchmark.table([dict(row, what="ours", baseline="base", ms=ms, kept=kept, correct=correct)
                                 for ms, kept, correct in ((2, 10, 9), (2, 20, None), (3, None, None))] +
                                [dict(row, what="base", baseline=None, ms=ms) for ms in (4, 6, 20)])
        self.assertIn("| s | base | 6.000 | 19.720 | 20.000 |  |  |  |\n"
                      "|  | ours | 2.000 | 2.980 | 3.000 | 3.0 | 15 | 9 |\n", table)


def tables_run(method, pair="p0", preset=2000, raw_points=None, **columns):
    """A run of the tables. Columns: inliers, counts, hypotheses, errors."""
    length = max(map(len, columns.values()), default=1)
    column = lambda key, default: columns.get(key, [default] * length)  # noqa: E731
    records = [record(method=method, reference=pair, features=preset, inliers=i, hypotheses=h,
                      truth=truth(e, c) if c or e else None, **({"matches_gms": 0} if i == 0 else {}))
               for i, h, e, c in zip(column("inliers", 1), column("hypotheses", 0), column("errors", None),
                                     column("counts", None))]
    return tables.Run(records, raw_points)


class Documents(unittest.TestCase):
    def test_the_rows_of_the_demo_are_quoted(self):
        (table,) = [node for node in ast.walk(ast.parse((PROJECT / "scripts/demo_summary.py").read_text()))
                    if isinstance(node, ast.FunctionDef) and node.name == "table"]
        text = lambda node: node.value if isinstance(node, ast.Constant) else None  # noqa: E731
        tuples = [node.elts for node in ast.walk(table) if isinstance(node, ast.Tuple)]
        rows = {text(elements[0]) for elements in tuples if len(elements) == 2} - {None, "pose error"}
        (stages,) = [elements for elements in tuples if text(elements[0]) == "convert"]
        rows |= {"ms, " + stage.value for stage in stages}
        quoted = (PROJECT / "doc/measured/benchmark.md").read_text().split("<!-- begin of the demo -->")[1].split("<!-- end of the demo -->")[0]
        self.assertEqual({line.split("  ")[0] for line in map(str.strip, quoted.splitlines()) if line}, rows)

    def test_what_a_program_printed_is_quoted(self):
        with tempfile.TemporaryDirectory() as folder:
            document, file = Path(folder, "a.md"), Path(folder, "b.txt")
            document.write_text("a\n<!-- begin of the demo -->\nold\n<!-- end of the demo -->\nb\n")
            file.write_text("row  1\nline 2\n")
            insert(str(document), {"demo": printed(str(file))})
            self.assertEqual(document.read_text(), "a\n<!-- begin of the demo -->\n\n    row  1\n    line 2\n\n"
                             "<!-- end of the demo -->\nb\n")
            self.assertRaises(SystemExit, insert, str(document), {"tables": ""})


class Tables(unittest.TestCase):
    def test_the_papers_ratios_reproduce_its_table_4(self):
        # Survivors of RANSAC and of GMS whose quotients are the table's digits.
        for kept, survivors, percent in ((897, 1188, 75.5051), (913, 1188, 76.8519), (548, 835, 65.6287),
                                         (514, 835, 61.5569), (1044, 1274, 81.9466)):
            columns = tables.Run([record(inliers=kept, matches_gms=survivors)], None).columns
            self.assertAlmostEqual(columns["paper_precision"][0], percent, places=4)
            self.assertAlmostEqual(columns["paper_recall"][0], kept / 20)
        self.assertEqual(len(tables.Run([record(matches_gms=0)], None).columns["paper_precision"]), 0)

    def test_reductions_of_table_5_average_to_the_claims(self):
        for printed in tables.PAPER_REDUCTIONS.values():
            sets, mean = printed.split("; ")
            self.assertAlmostEqual(np.mean([float(figure) for figure in sets.split(" / ")]), float(mean), delta=5e-3)

    def test_precision_and_recall_where_the_truth_says_something(self):
        columns = tables_run("lan", raw_points=16, counts=[counts(10, 9, 8), counts(0, 0, 4)]).columns
        np.testing.assert_allclose(columns["precision"], [90])
        np.testing.assert_allclose(columns["recall"], [50, 25])
        np.testing.assert_allclose((columns["filter_ms"][0], columns["total_ms"][0]), (1.5, 7.5))

    def test_recall_is_of_the_raw_matches_of_the_first_run(self):
        unit = [record(method="cp_ransac", truth=truth(None, counts(1, 1, 5, raw_points=10))),
                record(method="lan", truth=truth(None, counts(1, 1, 5, raw_points=5)))]
        self.assertEqual([part.columns["recall"][0] for part in tables.runs_of(unit)], [50, 50])

    def test_names_of_ratios(self):
        self.assertEqual([tables.ratio_name(x) for x in (0.2, 1 / 3, 2 / 3, 0.8, 1, 0.37)],
                         ["1/5", "1/3", "2/3", "4/5", "1/1", "0.37"])

    def test_each_two_are_compared_once_and_ours_is_no_baseline(self):
        runs = [tables_run(method) for method in ("cp_ransac", "gms_ransac", "lan", "lo_prosac")]
        self.assertEqual(tables.comparisons(runs),
                         [("cp_ransac", "gms_ransac"), ("cp_ransac", "lan"), ("gms_ransac", "lan"),
                          ("lo_prosac", "gms_ransac"), ("lo_prosac", "lan")])

    def test_reductions_are_of_the_same_pairs(self):
        # Pairs differ widely, but ours always draws a quarter less; a preset that one lacks does not count.
        base = [tables_run("lan", "p%d" % k, preset, hypotheses=[10 ** k]) for k in range(3) for preset in (1000, 2000)]
        ours = [tables_run("cp_ransac", "p%d" % k, 1000, hypotheses=[0.75 * 10 ** k]) for k in range(3)]
        self.assertEqual(tables.reduction(ours, base, "hypotheses"), "25.00 [25.00, 25.00]")
        self.assertEqual(tables.reduction([], base, "hypotheses"), "-")

    def test_differences_have_an_interval_over_the_pairs(self):
        def of(method, errors):
            return [tables_run(method, "p%d" % k, errors=[(e, e) for e in errors(k)]) for k in range(8)]
        base, ours = of("lan", lambda k: (k, k)), of("cp_ransac", lambda k: (k + 1, k - 1))
        self.assertEqual(tables.difference(ours, base, "pose_error", np.mean), "0.00 [0.00, 0.00]")
        crossed = of("cp_ransac", lambda k: [k + 8 * (k % 2)])
        low, high = tables.difference(crossed, base, "pose_error", np.mean).split("[")[1].rstrip("]").split(", ")
        self.assertTrue(0 < float(low) < 4 < float(high))
        self.assertEqual(tables.difference(ours, base, "recall", np.mean), "-")


DEGREE = math.pi / 180


def answer(rotation=(0, 0, 0), direction=0.0, status="OK", metres=1.0, kind="drawn", noise=None, moved=True):
    """A camera that moves forward: errors in degrees, the direction about x; sigmas of 0.1 and 1 degree."""
    covariance = np.diag([DEGREE ** 2] * 3 + [(0.1 * DEGREE) ** 2] * 3)
    known = dict(has_pose=True, translation_m=[0, 0, metres], moved=moved, noise=noise,
                 pose_error=dict(rotation_vector_deg=list(rotation)))
    return record(kind=kind, status=status, covariance=covariance.ravel().tolist(), median_parallax_px=9.0, sigma_px=0.3,
                  t=[0, -math.sin(direction * DEGREE), math.cos(direction * DEGREE)], reliability=[0] * 30, truth=known)


def judged(*arguments, **fields):
    return trust.judge([answer(*arguments, **fields)])[0]


def noise_of(rotation_deg=0.0, translation_m=0.0):
    return dict(rotation=((rotation_deg * DEGREE) ** 2 * np.eye(3)).ravel().tolist(),
                translation=(translation_m ** 2 * np.eye(3)).ravel().tolist(), translation_sigma=translation_m)


class Judged(unittest.TestCase):
    def test_normalized_squares(self):
        error = np.array([[2.0, 6], [2, 6]])
        squares = trust.normalized_squares(error, np.array([[[4.0, 0], [0, 9]], [[0, 0], [0, 0]]]))
        self.assertAlmostEqual(squares[0], (1 + 4) / 2)
        self.assertTrue(math.isnan(squares[1]))

    def test_tangent_errors(self):
        estimate = np.array([[0.0, 0, 1], [0, 0, 1]])
        true = np.array([[math.sin(0.2), 0, math.cos(0.2)], [0, 0, -1]])
        error, covariance = trust.tangent_errors(estimate, true, np.array([np.diag((0.04, 0.04, 9))] * 2))
        np.testing.assert_allclose(np.linalg.norm(error, axis=1), (0.2, math.pi))
        np.testing.assert_allclose(covariance[0], 0.04 * np.eye(2), atol=1e-12)  # nothing of what lies along it

    def test_errors_and_what_the_answer_says_of_them(self):
        row = judged((0, 0.3, 0), 2)
        expected = dict(ry_deg=0.3, rotation_error_deg=0.3, direction_error_deg=2, nees_rotation=9 / 3, nees_direction=4 / 2,
                        uncertainty_deg=0.1 + 1, baseline_m=1)
        for key, value in expected.items():
            self.assertAlmostEqual(row[key], value, places=9, msg=key)
        self.assertTrue(row["right"] and not row["wrong"])

    def test_noise_of_the_truth_is_added_to_the_covariance(self):
        noise = noise_of(0.2, math.sqrt(3) * DEGREE)  # over a metre: that much of the direction
        row = judged((0, 0.3, 0), 2, noise=noise)
        self.assertAlmostEqual(row["nees_rotation"], 0.09 / (0.01 + 0.04) / 3)
        self.assertAlmostEqual(row["nees_direction"], 4 / (1 + 3) / 2)

    def test_wrong_is_an_ok_beyond_the_limits(self):
        self.assertTrue(judged((0, 0, 1.2))["wrong"])
        self.assertFalse(judged((0, 0, 1.2), kind="real")["wrong"])
        self.assertTrue(judged(direction=90)["wrong"])
        low = judged(direction=90, status="LOW_PARALLAX")
        self.assertFalse(low["wrong"] or low["right"])
        self.assertTrue(math.isnan(low["nees_direction"]))
        self.assertTrue(judged(status="LOW_PARALLAX")["right"], "refused though right")
        # A static camera has no direction; one that may have been static is judged by its rotation.
        self.assertTrue(judged(metres=0, moved=False)["wrong"])
        self.assertFalse(judged(metres=0, moved=False, status="LOW_PARALLAX")["wrong"])
        self.assertFalse(judged(direction=90, metres=0.01, moved=False, noise=noise_of(0, 0.005))["wrong"])

    def test_what_was_not_answered_has_no_figures(self):
        failed = dict(answer(), status="RANSAC_FAILED", covariance=None)
        unknown = dict(answer(), truth=None)
        rows = trust.judge([failed, unknown])
        self.assertEqual([trust.cell(rows[0][key]) for key in ("rotation_error_deg", "covariance", "wrong")], ["", "", "0"])
        self.assertEqual(trust.cell(rows[1]["nees_rotation"]), "")
        self.assertGreater(rows[1]["rotation_sigma_deg"], 0)
        self.assertEqual(trust.judge([failed])[0]["right"], False)


def pose_at(z, yaw=0.0):
    return [math.cos(yaw), 0, math.sin(yaw), 0, 0, 1, 0, 0, -math.sin(yaw), 0, math.cos(yaw), z]


def image(k, pose, truth, pair=None):
    return dict(number=0, set="s", scale="stereo", stamp=0.1 * k, text="", known=k != 3, pose=pose, truth=truth, pair=pair,
                ms=10.0)


class Odometry(unittest.TestCase):
    """Twelve images a metre apart; every step is taken for 2 cm longer, and the last image is rotated by 10 mrad."""
    records = [image(k, pose_at(1.02 * k, 0.01 * (k == 11)), pose_at(k)) for k in range(12)]

    def path(self):
        ((_, [row]),) = odometry.read(map(json.dumps, self.records))
        self.assertEqual((row.against, row.images, row.lost, row.ms, row.nees), ("truth", 12, 1, 10.0, {}))
        return row.path

    def test_kitti_errors_by_hand(self):
        # The first part longer than 10 m is the only one: 11 m. 22 cm and 10 mrad over 10 m.
        path = self.path()
        self.assertEqual(path.parts(10), [(0, 11)])
        np.testing.assert_allclose(path.drift([10]), (2.2, math.degrees(0.01) * 10))
        self.assertAlmostEqual(path.lengthening(), 2)
        self.assertTrue(math.isnan(path.drift([20])[0]), "too short")

    def test_errors_over_a_second_and_of_the_aligned_path(self):
        # Ten steps a second from image 0 and from image 1, and only the latter ends with the rotation.
        metres, degrees = self.path().rpe()
        self.assertAlmostEqual(metres, 0.2)
        self.assertAlmostEqual(degrees, math.degrees(0.01) / math.sqrt(2))
        self.assertAlmostEqual(self.path().ate(), 0.02 * math.sqrt(np.mean((np.arange(12) - 5.5) ** 2)))
        self.assertAlmostEqual(odometry.Path("", self.path().stamps, self.path().poses, self.path().truth, True).ate(), 0)

    def test_nees_of_errors_of_one_deviation(self):
        # Half of the variance is the noise of the truth.
        sigma = np.array([1e-2] * 3 + [1e-3] * 3)
        turned = pose_at(1, 0.001 * math.sqrt(3))
        true = [turned[i] + (0.01 if i % 4 == 3 else 0) for i in range(12)]
        half = (0.5 * np.diag(sigma ** 2)).ravel().tolist()
        noise = dict(translation=(0.5e-4 * np.eye(3)).ravel().tolist(), rotation=(0.5e-6 * np.eye(3)).ravel().tolist())
        motion = dict(motion=pose_at(1), covariance=half, noise=noise)
        rate = (np.diag(sigma ** 2) / 0.1 ** 2 - 0.5 * np.diag(sigma ** 2) / 0.1 ** 2).ravel().tolist()
        last = dict(image(1, pose_at(1), true, dict(motion, reference_stamp=0.0, metric=True)),
                    twist=dict(velocity=[0, 0, 10, 0, 0, 0], covariance=rate),
                    parts=[dict(motion, **{"from": 0.0, "length": 10, "unit": "m"})])
        ((_, [row]),) = odometry.read(map(json.dumps, [image(0, pose_at(0), pose_at(0)), last]))
        self.assertEqual(list(row.nees), ["pair", "twist", ("m", 10)])
        for values in row.nees.values():
            np.testing.assert_allclose(values, [1], rtol=0.06)  # the rotation moves the velocity, too
        np.testing.assert_allclose(row.noise, [(0.01 / math.sqrt(2), 0.001 / math.sqrt(2))])
        table = odometry.nees_table([("s", [row])])
        self.assertEqual(table.splitlines()[1].split(), "NEES of against pair twist 10 m noise".split())
        self.assertIn("1.00 1.00 1", table.splitlines()[2])

    def test_nees_is_of_what_is_known(self):
        unknown = np.diag([1e3] * 3 + [4.0] * 3)
        noise = np.zeros((6, 6))
        self.assertAlmostEqual(odometry.squared(np.array([9, 9, 9, 2.0, 2, 2]), unknown, noise, True), 1)
        self.assertAlmostEqual(odometry.squared(np.array([9, 9, 9, 2.0, 2, 2]), np.eye(6), noise, False), 4)
        self.assertTrue(math.isnan(odometry.squared(np.ones(6), 1e3 * np.eye(6), noise, True)))

    def test_a_witness_in_other_axes_is_fitted(self):
        # A curve of the camera, and the same of a sensor that is rotated by 10 degrees on it.
        def walk(k):
            return pose_at(0.5 * k, 0.05 * k)
        about_x = np.eye(4)
        about_x[1:3, 1:3] = [[math.cos(math.radians(10)), -math.sin(math.radians(10))],
                             [math.sin(math.radians(10)), math.cos(math.radians(10))]]
        with tempfile.TemporaryDirectory() as folder:
            witness = Path(folder, "witness")
            moved = [np.linalg.inv(about_x) @ odometry.matrix(walk(k)) @ about_x for k in range(40)]
            np.savetxt(witness, [pose[:3].ravel() for pose in moved])
            records = [image(k, walk(k), None) for k in range(40)]
            ((_, (plain, fitted)),) = odometry.read(map(json.dumps, records), [], [str(witness)], 5, True)
            self.assertEqual((plain.against, fitted.against), ("witness", "witness 10.00"))
            self.assertEqual((plain.images, fitted.images), (35, 35), "five are left out")
            self.assertGreater(plain.path.drift([10])[0], 5)
            self.assertLess(fitted.path.drift([10])[0], 1e-3)
            row = odometry.table([("s", [fitted])]).splitlines()[1]
            self.assertEqual(row.split()[:6], ["s", "stereo", "witness", "10.00", "35", "1"])

    def test_peers_in_both_forms(self):
        with tempfile.TemporaryDirectory() as folder:
            kitti, tum, other = (Path(folder, name) for name in ("kitti", "tum", "other"))
            kitti.write_text("".join(" ".join(map(str, pose_at(k, 0.2))) + "\n" for k in range(3)))
            tum.write_text("# stamp ...\n" + "".join("%g 0 0 %d 0 %.9f 0 %.9f\n" % (0.1 * k + 0.01, k, math.sin(0.1), math.cos(0.1))
                                                     for k in range(3)))
            other.write_text("1 2 3\n")
            with contextlib.redirect_stderr(io.StringIO()) as said:
                a, b = (odometry.read_poses(str(file), [0.0, 0.1, 0.2, 0.3]) for file in (kitti, tum))
            self.assertEqual(said.getvalue(), "evaluate_report.py: %s: has 3 poses for 4 images; line i belongs to the i-th "
                             "image\n" % kitti)
            np.testing.assert_allclose(a[:3], b[:3], atol=1e-8)
            self.assertEqual((a[3], b[3]), (None, None))
            with self.assertRaises(odometry.BadPoses):
                odometry.read_poses(str(other), [0.0])
            table = odometry.table(odometry.read(map(json.dumps, self.records), [str(kitti)]))
            self.assertEqual([line.split()[1:5] for line in table.splitlines()[1:3]],
                             [["stereo", "truth", "12", "1"], ["peer", "truth", "3", "-"]])

    def test_a_plot_is_drawn(self):
        if not pyplot():
            self.skipTest("needs matplotlib")
        with tempfile.TemporaryDirectory() as folder:
            odometry.plot(odometry.read(map(json.dumps, self.records), []), folder + "/plot.png")
            self.assertGreater(Path(folder, "plot.png").stat().st_size, 10000)


    def test_a_set_without_truth_says_so(self):
        records = [dict(record, truth=None) for record in self.records]
        out = io.StringIO()
        with contextlib.redirect_stdout(out), tempfile.TemporaryDirectory() as folder:
            odometry.report(map(json.dumps, records), folder + "/plot.png", [])
            self.assertFalse(Path(folder, "plot.png").exists())
        self.assertIn("s: has no truth (poses.txt, groundtruth.txt, or tf", out.getvalue())
        self.assertEqual(out.getvalue().splitlines()[1].split()[2:5], ["-", "12", "1"], "images that were worked")


class Plots(unittest.TestCase):
    def setUp(self):
        self.plt = pyplot()
        if not self.plt:
            self.skipTest("needs matplotlib")
        self.addCleanup(self.plt.close, "all")

    def test_one_panel_has_room_for_its_legend(self):
        figure, axes = plots.grid_of(self.plt, 1, 1)
        for k in range(12):
            axes[0][0].plot([0, 1], [0, k], label="gms_dist_ransac")
        with tempfile.TemporaryDirectory() as folder:
            plots.save(figure, folder, "one", legend_of=axes[0][0])
        size = figure.get_size_inches() * figure.dpi
        self.assertGreaterEqual(size[0], 600)
        legend, = figure.legends
        box = legend.get_window_extent(figure.canvas.get_renderer())
        self.assertTrue(0 <= box.x0 and box.x1 <= size[0] and 0 <= box.y0, box)
        self.assertLess(box.y1, axes[0][0].get_window_extent().y0, "below the panel")

    def test_nothing_wrong_is_a_line_at_zero(self):
        figure, axes = plots.grid_of(self.plt, 1, 1)
        trust.draw_risk(axes[0][0], (np.array([0.5, 1.0]), np.array([0.0, 0.0])), {})
        self.assertEqual(axes[0][0].get_ylim(), (0, 1))

    def test_a_short_path_says_why_its_panels_are_empty(self):
        records = Odometry.records[:3]
        with tempfile.TemporaryDirectory() as folder:
            odometry.plot(odometry.read(map(json.dumps, records), []), folder + "/plot.png")
        texts = [text.get_text() for axis in self.plt.gcf().axes for text in axis.texts]
        self.assertEqual(texts, ["the path is shorter than 10 m"] * 2)


class Trust(unittest.TestCase):
    def test_wilson(self):
        # Without events the upper end is z^2 / (n + z^2); of five in ten the interval is that of the textbooks.
        np.testing.assert_allclose(wilson(0, 100), (0, 100 * 3.841459 / 103.841459), atol=1e-4)
        np.testing.assert_allclose(wilson(5, 10), (23.659, 76.341), atol=5e-3)
        self.assertEqual(wilson(0, 0), (0, 100))

    def test_stretches_have_nothing_in_common(self):
        def pairs(gap, count, name="a", start=0.0, kind="real"):
            return [SimpleNamespace(kind=kind, set=name, from_s=start + k, to_s=start + k + gap) for k in range(count)]
        self.assertEqual(stretches(pairs(1, 10)), 10)
        self.assertEqual(stretches(pairs(5, 10)), 2)
        self.assertEqual(stretches(pairs(1, 10) + pairs(5, 10)), 10, "of each part of the recording once")
        self.assertEqual(stretches(pairs(5, 10) + pairs(5, 10, "b")), 4, "two recordings")
        self.assertEqual(stretches(pairs(5, 10) + pairs(5, 10, "a/image_1")), 2, "two cameras of one")
        self.assertEqual(stretches(pairs(5, 10, start=1e9) + pairs(5, 10, "b", start=1e9 + 2)), 3, "excerpts of one")
        self.assertEqual(stretches(pairs(math.nan, 7, kind="drawn")), 7)

    def test_the_upper_bound_counts_stretches_and_not_pairs(self):
        rows = trust.judge([dict(answer((0, 0, 4) if k == 0 else (0, 0, 0), kind="real"), reference_stamp=k, stamp=k + 5.0)
                            for k in range(50)] + [dict(answer(kind="real", moved=False, noise=noise_of(0, 0.005)), reference_stamp=0, stamp=1.0)])
        row = trust.figures([SimpleNamespace(**row, ok=True, low=False, bins=np.zeros((10, 3))) for row in rows])
        self.assertEqual((row["ok"], row["wrong"], row["directions"], row["stretches"]), (51, 1, 50, 11))
        self.assertAlmostEqual(row["wrong_at_most"], wilson(11 / 51, 11)[1])
        self.assertEqual(trust.cells(row, trust.TRUSTED), ["51", "51", "28.7 %", "1 (2.0 %)", "11", "50"])

    def test_a_document_keeps_all_but_what_is_between_its_marks(self):
        document = "a\n<!-- begin of the tables -->\nold\n<!-- end of the tables -->\nb\n"
        made = {"recordings": "other\n", "tables": "new\n"}
        self.assertEqual(replaced(document, made),
                         "a\n<!-- begin of the tables -->\n\nnew\n\n<!-- end of the tables -->\nb\n")
        self.assertIsNone(replaced("a\n", made))

    def test_calibration_error(self):
        # Ten matches of probability 0.9, eight right; thirty of 0.5, fifteen right: a quarter has an error of a tenth.
        self.assertAlmostEqual(trust.calibration_error(np.array([[10, 9.0, 8], [30, 15.0, 15], [0, 0, 0]])), 0.25 * 0.1)
        self.assertTrue(math.isnan(trust.calibration_error(np.zeros((10, 3)))))

    def test_bias_and_spread(self):
        np.testing.assert_allclose(trust.bias([1, 2, 3, math.nan]), (2, 2 / (1 / math.sqrt(3))))
        np.testing.assert_allclose(trust.spread([math.nan, 0, 1, 2, 3, 14]), (2, 4, 3 + 0.6 * 11))

    def test_what_each_status_promises(self):
        def of(**fields):
            row = judged(kind="real", **fields)
            return SimpleNamespace(**row, ok=row["status"] == "OK", low=row["status"] == "LOW_PARALLAX")
        unknown = SimpleNamespace(**trust.row_of(dict(answer(kind="real", status="MOTION_UNKNOWN"), stationary=True)), ok=False,
                                  low=False)
        lines = trust.statuses_table(
            [of(), of(rotation=(0, 0, 4)), of(direction=40), of(status="LOW_PARALLAX", direction=90),
             of(status="LOW_PARALLAX", rotation=(4, 0, 0)), of(status="LOW_PARALLAX", rotation=(4, 0, 0), noise=noise_of(1)),
             unknown]).splitlines()[2:]
        self.assertEqual(lines[0].split("|")[1:5], [" OK ", " 3 ", " 2 (66.7 %) ", " 1 "])
        self.assertEqual(lines[1].split("|")[1:5], [" LOW_PARALLAX ", " 3 ", " 1 (33.3 %) ", " 1 "], "within the truth's noise")
        self.assertEqual(lines[2].split("|")[1:4], [" MOTION_UNKNOWN ", " 1 ", " no pose "])
        self.assertEqual(lines[3].split("|")[1:4], [" stationary ", " 1 ", " 1 (100.0 %) "], "the camera has moved")

    def test_motions_tell_fast_rotations_apart(self):
        def of(degrees, **fields):
            made = dict(answer(kind="rendered", **fields), reference_stamp=1.0, stamp=1.05)
            c, s = math.cos(degrees * DEGREE), math.sin(degrees * DEGREE)
            made["truth"]["R"] = [c, -s, 0, s, c, 0, 0, 0, 1]
            row, = trust.judge([made])
            return SimpleNamespace(**row, ok=row["status"] == "OK", low=row["status"] == "LOW_PARALLAX", bins=np.zeros((10, 3)))
        self.assertAlmostEqual(of(4).rate_deg_s, 80)
        line = trust.motions_table([of(4), of(4, rotation=(0, 0, 2)), of(5), of(5, direction=30), of(5, status="LOW_PARALLAX"),
                                    of(4, status="MOTION_UNKNOWN")]).splitlines()[2]
        cells = [cell.strip() for cell in line.split("|")[1:-1]]
        self.assertEqual(cells[:7], ["s, gap 1", "lan", "6", "4", "1", "1", "2 (50.0 %)"])
        self.assertEqual(cells[9:], ["2 of 3", "1 (50.0 %)"])

    def test_risk_coverage(self):
        answers = [SimpleNamespace(ok=ok, wrong=wrong, uncertainty_deg=uncertainty)
                   for ok, wrong, uncertainty in ((True, True, 3), (True, False, 1), (False, False, 2))]
        coverage, risk = trust.risk_coverage(answers)
        np.testing.assert_allclose(coverage, [1 / 3, 2 / 3])
        np.testing.assert_allclose(risk, [0, 1 / 2])

    def test_halves_are_apart(self):
        def of_half(half, wrong):
            return SimpleNamespace(kind="drawn", method="m", half=half, has_truth=True, moved=True, ok=True, low=False,
                                   right=not wrong, wrong=wrong, nees_rotation=1., nees_direction=1., rx_deg=0., ry_deg=0., rz_deg=0.,
                                   direction_error_deg=1., to_s=math.nan, bins=np.zeros((10, 3)))
        even, odd = trust.halves_table([of_half(0, False), of_half(0, False), of_half(1, True)]).splitlines()[2:4]
        self.assertIn("| drawn | m | even | 2 | 2 | 65.8 % | 0 (0.0 %) | 2 | 2 |", even)
        self.assertIn("| drawn | m | odd | 1 | 1 | 100.0 % | 1 (100.0 %) | 1 | 1 |", odd)

    def test_what_was_right_before(self):
        def of_pair(pair, ok, wrong=False):
            return SimpleNamespace(key=pair, kind="drawn", method="m", set="s", gap=0, has_truth=True, ok=ok, wrong=wrong)
        before = [of_pair(1, True), of_pair(2, True), of_pair(3, True, wrong=True), of_pair(4, False)]
        now = [of_pair(1, True), of_pair(2, False), of_pair(3, False), of_pair(4, True)]
        self.assertIn("| drawn | m | 1 of 2 (50.0 %) | s: 1 |", trust.kept_table(now, before))


def found(motion=(0, 0), rotation=0, probabilities=(0.95, 0.95), **fields):
    """A judged pair: errors of its motion (rotation, direction) and of the rotation without a translation, degrees; the
    probabilities of both."""
    def about_z(degrees):
        c, s = math.cos(degrees * DEGREE), math.sin(degrees * DEGREE)
        return [c, -s, 0, s, c, 0, 0, 0, 1]
    made = dict(answer(direction=motion[1], **fields), stamp=None, pose_probability=probabilities[0],
                rotation_probability=probabilities[1])
    made["truth"]["R"] = about_z(0)
    made["judgement"] = dict(evidence={}, motion_R=about_z(motion[0]), motion_t=made["t"], rotation_R=about_z(rotation))
    return made


def answers_of(*records):
    return [SimpleNamespace(**row) for row in trust.judge(records)]


class Calibration(unittest.TestCase):
    def test_what_is_right(self):
        def real(*errors, **fields):
            return calibration.rights_of(found(errors, kind="real", **fields))
        self.assertEqual(real(2.9, 19.9), (True, True, True))
        self.assertEqual(real(3.1, 0), (False, False, True))
        self.assertEqual(real(0, 20.1, rotation=3.1), (False, True, False))
        # Two deviations of the truth more: 0.5 degrees of rotation, and of a metre what 2.5 degrees of direction are.
        self.assertEqual(real(3.9, 24.9, noise=noise_of(0.5, math.sin(5 * DEGREE) / 2)), (True, True, True))
        self.assertEqual(real(4.1, 25.1, rotation=4.1, noise=noise_of(0.5, math.sin(5 * DEGREE) / 2)), (False,) * 3)
        # Without a true direction a motion can only be wrong; a drawn camera that rotates has none.
        self.assertEqual(real(2, 90, moved=False), (None, True, True))
        self.assertEqual(real(4, 90, moved=False), (False, False, True))
        self.assertEqual(calibration.rights_of(found((0.9, 19.9))), (True, True, True))
        self.assertEqual(calibration.rights_of(found((1.1, 0), rotation=1.1)), (False,) * 3)
        self.assertEqual(calibration.rights_of(found(moved=False)), (False, True, True))

    def test_the_weights_are_fitted_to_the_same(self):
        try:
            import fit_probability
        except ImportError:
            self.skipTest("needs scipy")
        pair = fit_probability.Pair(found((0, 21), rotation=2))
        self.assertEqual((pair.pose_right, pair.rotation_right), (False, False))
        self.assertTrue(fit_probability.Pair(found((0, 19))).pose_right)

    def test_a_rotation_is_that_of_the_motion_where_the_motion_is_as_probable(self):
        for probabilities, right in (((0.5, 0.5), True), ((0.5, 0.6), False)):
            row, = answers_of(found((0, 0), 90, probabilities))
            self.assertEqual(row.rotation_right, right)

    def test_a_bin_has_the_share_right_with_its_interval_and_the_mean_probability(self):
        answers = answers_of(found(probabilities=(0.91, 1)), found(probabilities=(0.93, 1)), found(probabilities=(0.95, 1)),
                             found((0, 90), probabilities=(1, 1)), found((0, 90), probabilities=(0.3, 1)),
                             dict(answer(), truth=None), found(kind="real", moved=False))
        below, above = calibration.rows_of(answers, "pose")
        np.testing.assert_allclose(below, (0.3, 1, 0, 0, *wilson(0, 1), 0.3))
        np.testing.assert_allclose(above, (0.9, 4, 3, 75, *wilson(3, 4), (0.91 + 0.93 + 0.95 + 1) / 4))
        self.assertEqual(calibration.table({("drawn", "lan"): answers}).splitlines()[2:], [
            "| drawn | lan | 0.3 to 0.4 | 1 | 0.0 % | 0.0 to 79.3 % | 0.300 | – | – | – | – |",
            "| drawn | lan | 0.9 to 1.0 | 4 | 75.0 % | 30.1 to 95.4 % | 0.948 | 6 | 100.0 % | 61.0 to 100.0 % | 0.992 |"])

    def test_pairs_that_overlap_count_once_for_the_interval(self):
        answers = answers_of(*(dict(found(kind="real"), reference_stamp=k, stamp=k + 5.0) for k in range(10)))
        (row,) = calibration.rows_of(answers, "pose")
        np.testing.assert_allclose(row[1:6], (10, 10, 100, *wilson(2, 2)))

    def test_the_figure_shows_the_bins_and_how_many_there_are(self):
        plt = pyplot()
        if not plt:
            self.skipTest("needs matplotlib")
        self.addCleanup(plt.close, "all")
        answers = answers_of(*[found(probabilities=(0.95, 0.95))] * 3, found((2, 0), 2, probabilities=(0.15, 0.25)))
        _, (reliability, histogram) = plt.subplots(2)
        calibration.draw(reliability, histogram, answers)
        pose, rotation = (container for container in reliability.containers)
        np.testing.assert_allclose(pose.lines[0].get_xydata(), [(0.15, 0), (0.95, 100)])
        np.testing.assert_allclose(rotation.lines[0].get_xydata(), [(0.25, 0), (0.95, 100)])
        ends = pose.lines[2][0].get_segments()[1][:, 1]
        np.testing.assert_allclose(ends, wilson(3, 3))
        self.assertEqual([[bar.get_height() for bar in bars] for bars in histogram.containers], [[1, 3], [1, 3]])

    def test_a_report_has_tables_and_the_figure(self):
        with tempfile.TemporaryDirectory() as folder:
            records, document = Path(folder, "run.jsonl"), Path(folder, "a.md")
            records.write_text("\n".join(map(json.dumps, [found(kind=kind) for kind in ("real", "drawn")])))
            document.write_text("<!-- begin of the calibration -->\n<!-- end of the calibration -->\n")
            with contextlib.redirect_stdout(io.StringIO()):
                trust.report(str(records), into=[str(document)])
            self.assertEqual(Path(folder, "run/calibration.csv").read_text().splitlines()[1],
                             "real,lan,pose,0.9,1,1,100.0000,20.6549,100.0000,0.9500")
            for kind in ("real", "drawn"):
                line = "| %s | lan | 0.9 to 1.0 | 1 | 100.0 %% |" % kind
                self.assertTrue(line in document.read_text() and line in Path(folder, "run/trust.md").read_text())
            self.assertTrue(not pyplot() or Path(folder, "run/calibration.png").stat().st_size > 10000)


if __name__ == "__main__":
    unittest.main()
