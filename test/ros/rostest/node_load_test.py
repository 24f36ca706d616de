#!/usr/bin/env python3
"""node_load counts right: every image sent is answered, in one process and in two; bad options are refused."""
import subprocess
import unittest

from graph import PATIENCE, TIMEOUT, run


def node_load(*options):
    """Runs the program to its end; returns (exit status, rows of its table as lists of cells, stderr)."""
    done = subprocess.run(["rosrun", "gms_ransac_rostest", "node_load"] + list(options), stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True, timeout=3 * TIMEOUT)
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in done.stdout.splitlines() if line.startswith("|")]
    return done.returncode, rows[2:], done.stderr


class NodeLoad(unittest.TestCase):
    def check(self, process, *options):
        # A rate that the node cannot keep makes it drop images.
        status, rows, said = node_load("--seconds", str(PATIENCE), "--rate", str(20 / PATIENCE), "0", "--extractor",
                                       "simd_orb", "--features", "500", *options)
        self.assertEqual((status, len(rows)), (0, 2), said)
        for row in rows:
            self.assertEqual(row[:3], [process, "simd_orb", "2" if "--threads" in options else "1"])
            answered, received = (int(n) for n in row[5].split(" of "))
            self.assertEqual((answered, row[6]), (received, "0"), "every image is answered")
            self.assertGreater(answered, 5)
            # With more than two different latencies the median is below the 99th percentile; nan, without any, is not.
            self.assertLess(float(row[7]), float(row[8]), "p50 and p99")
        return rows

    def test_in_one_process(self):
        self.check("manager", "--threads", "2")

    def test_in_two_processes(self):
        for row in self.check("node", "--separate"):
            self.assertGreater(float(row[10]), 10, "megabytes of a process with OpenCV in it")

    def test_bad_options(self):
        for options in (["--rate", "-1"], ["--seconds", "0"], ["--features", "many"]):
            status, _, said = node_load(*options)
            self.assertEqual(status, 2, options)
            self.assertIn("node_load: ", said)


if __name__ == "__main__":
    run("node_load", NodeLoad)
