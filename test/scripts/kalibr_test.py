#!/usr/bin/env python3
"""kalibr_to_camera_info: points that two cameras see lie on one row of the rectified images, as far apart as P says."""
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

try:
    import cv2
    import numpy as np
    import yaml
except ImportError:
    raise SystemExit(77)  # skipped

SCRIPT = next(p for p in Path(__file__).resolve().parents if (p / "scripts/report").is_dir()) / "scripts/kalibr_to_camera_info.py"
BASELINE = 0.11


def chain(model, distortion):
    """Of two cameras that look a little past each other, as Kalibr writes it."""
    T = np.eye(4)
    T[:3, :3] = cv2.Rodrigues(np.array([0.02, -0.03, 0.01]))[0]
    T[:3, 3] = T[:3, :3] @ [-BASELINE, 0.003, 0.002]
    cameras = [dict(camera_model="pinhole", distortion_model=model, distortion_coeffs=distortion, resolution=[752, 480],
                    intrinsics=[458.0 + i, 457.0, 367.0, 248.0 - i]) for i in range(2)]
    cameras[1]["T_cn_cnm1"] = T.tolist()
    return dict(cam0=cameras[0], cam1=cameras[1])


def convert(calibration):
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "camchain.yaml")
        Path(path).write_text(yaml.safe_dump(calibration))
        done = subprocess.run([sys.executable, str(SCRIPT), path, folder], stderr=subprocess.PIPE, universal_newlines=True)
        infos = [] if done.returncode else [yaml.safe_load(Path(folder, side + ".yaml").read_text()) for side in ("left", "right")]
        return done.stderr, infos


def matrix(info, name):
    return np.reshape(info[name]["data"], (info[name]["rows"], info[name]["cols"]))


class Kalibr(unittest.TestCase):
    def check(self, model, distortion, name):
        calibration = chain(model, distortion)
        said, infos = convert(calibration)
        self.assertEqual(len(infos), 2, said)
        T = np.array(calibration["cam1"]["T_cn_cnm1"])
        points = np.random.RandomState(1).uniform((-1, -0.6, 2), (1, 0.6, 6), (100, 3))
        pixels = []
        for info, seen in zip(infos, (points, points @ T[:3, :3].T + T[:3, 3])):
            self.assertEqual((info["distortion_model"], info["image_width"], info["image_height"]), (name, 752, 480))
            self.assertEqual(matrix(info, "distortion_coefficients")[0, :4].tolist(), distortion)
            ideal = seen @ matrix(info, "rectification_matrix").T @ matrix(info, "projection_matrix")[:, :3].T
            pixels.append(ideal[:, :2] / ideal[:, 2:])
            depth = ideal[:, 2]
        left, right = pixels
        P = matrix(infos[1], "projection_matrix")
        length = np.linalg.norm(T[:3, 3])
        self.assertAlmostEqual(-P[0, 3] / P[0, 0], length, places=6)
        self.assertLess(np.abs(left[:, 1] - right[:, 1]).max(), 1e-6)
        self.assertLess(np.abs((left - right)[:, 0] - P[0, 0] * length / depth).max(), 1e-6)

    def test_radtan(self):
        self.check("radtan", [-0.28, 0.07, 0.0002, 0.00002], "plumb_bob")

    def test_equidistant(self):
        self.check("equidistant", [-0.01, 0.02, -0.03, 0.01], "equidistant")

    def test_what_cannot_be_a_camera_info_is_refused(self):
        calibration = chain("radtan", [0.0] * 4)
        calibration["cam0"]["camera_model"] = "omni"
        self.assertIn("only pinhole", convert(calibration)[0])
        self.assertIn("has no cam1", convert({"cam0": chain("radtan", [0.0] * 4)["cam0"]})[0])
        mirrored = chain("radtan", [0.0] * 4)
        mirrored["cam1"]["T_cn_cnm1"][0][3] = BASELINE
        self.assertIn("to the right", convert(mirrored)[0])


if __name__ == "__main__":
    unittest.main()
