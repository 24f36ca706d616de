#!/usr/bin/env python3
"""The statistics of scripts/trust_report.py against values worked out by hand."""
import math
import unittest
from types import SimpleNamespace

try:
    import numpy as np
except ImportError:
    raise SystemExit(77)  # skipped

import script_module

report = script_module.load("trust_report")


class Statistics(unittest.TestCase):
    def test_wilson(self):
        # Without events the upper end is z^2 / (n + z^2); of five in ten the interval is that of the textbooks.
        low, high = report.wilson(0, 100)
        self.assertAlmostEqual(low, 0)
        self.assertAlmostEqual(high, 100 * 3.841459 / 103.841459, places=4)
        low, high = report.wilson(5, 10)
        self.assertAlmostEqual(low, 23.659, places=2)
        self.assertAlmostEqual(high, 76.341, places=2)
        self.assertEqual(report.wilson(0, 0), (0, 100))

    def test_calibration_error(self):
        # Ten matches of probability 0.9, eight right; thirty of 0.5, fifteen right: a quarter is off by a tenth.
        bins = np.array([[10, 9.0, 8], [30, 15.0, 15], [0, 0, 0]])
        self.assertAlmostEqual(report.calibration_error(bins), 0.25 * 0.1)
        self.assertTrue(math.isnan(report.calibration_error(np.zeros((10, 3)))))

    def test_bias(self):
        mean, z = report.bias([1, 2, 3, math.nan])
        self.assertAlmostEqual(mean, 2)
        self.assertAlmostEqual(z, 2 / (1 / math.sqrt(3)))

    def test_spread(self):
        median, mean, p90 = report.spread([math.nan, 0, 1, 2, 3, 14])
        self.assertEqual((median, mean), (2, 4))
        self.assertAlmostEqual(p90, 3 + 0.6 * 11)

    def test_risk_coverage(self):
        answers = [SimpleNamespace(ok=True, wrong=True, uncertainty=3), SimpleNamespace(ok=True, wrong=False, uncertainty=1),
                   SimpleNamespace(ok=False, wrong=False, uncertainty=2)]
        coverage, risk = report.risk_coverage(answers)
        np.testing.assert_allclose(coverage, [1 / 3, 2 / 3])
        np.testing.assert_allclose(risk, [0, 1 / 2])

    def test_halves_are_apart(self):
        def answer(half, wrong):
            return SimpleNamespace(kind="drawn", method="m", half=half, has_truth=True, moved=True, ok=True, low=False,
                                   right=not wrong, wrong=wrong, nees_rotation=1., nees_direction=1., rotation=[0.] * 3,
                                   bins=np.zeros((10, 3)))

        even, odd = report.halves_table([answer(0, False), answer(0, False), answer(1, True)]).splitlines()[2:4]
        self.assertIn("| drawn | m | even | 2 | 2 | 0 (0.0 %", even)
        self.assertIn("| drawn | m | odd | 1 | 1 | 1 (100.0 %", odd)

    def test_what_was_right_before(self):
        def answer(pair, ok, wrong=False):
            return SimpleNamespace(key=pair, kind="drawn", method="m", set="s", gap=0, has_truth=True, ok=ok, wrong=wrong)

        before = [answer(1, True), answer(2, True), answer(3, True, wrong=True), answer(4, False)]
        now = [answer(1, True), answer(2, False), answer(3, False), answer(4, True)]
        table = report.kept_table(now, before)
        self.assertIn("| drawn | m | 1 of 2 (50.0 %) | s: 1 |", table)


if __name__ == "__main__":
    unittest.main()
