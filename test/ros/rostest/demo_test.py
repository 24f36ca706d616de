#!/usr/bin/env python3
"""The demo's launch file on a bag shorter than its start-up: it ends by itself, with every image in the table."""
import os
import shutil
import subprocess
import tempfile
import unittest

from graph import PATIENCE, linger, run

TIMEOUT = 100.0 * PATIENCE  # seconds of wall time for the whole launch
IMAGES = 9  # 0.3 s
# Read by Python at its start: the summary comes up when the player has long begun, as on a slow computer.
SLOW_START = """
import time
with open("/proc/self/cmdline") as command:
    if "demo_summary" in command.read():
        time.sleep(5)
"""


class Demo(unittest.TestCase):
    def test_a_bag_shorter_than_its_start_up(self):
        folder = tempfile.mkdtemp(prefix="gms_ransac_demo_")
        self.addCleanup(shutil.rmtree, folder)
        bag = os.path.join(folder, "short.bag")
        subprocess.check_call(["rosrun", "gms_ransac", "render_scene", bag, "--frames", str(IMAGES)])
        linger(bag)
        with open(os.path.join(folder, "sitecustomize.py"), "w") as out:
            out.write(SLOW_START)
        environment = dict(os.environ, PYTHONPATH=folder + ":" + os.environ.get("PYTHONPATH", ""))
        launch = subprocess.Popen(["roslaunch", "gms_ransac", "demo.launch", "bag:=" + bag, "rviz:=false",
                                   "output_dir:=" + folder], env=environment)
        try:
            launch.wait(TIMEOUT)
        finally:
            launch.terminate()
            launch.wait()
        with open(os.path.join(folder, "summary.txt")) as summary:
            self.assertIn("%d / %d / 0" % (IMAGES, IMAGES), summary.read())


if __name__ == "__main__":
    run("demo", Demo)
