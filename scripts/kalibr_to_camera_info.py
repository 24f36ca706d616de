#!/usr/bin/env python3
"""kalibr_to_camera_info.py CAMCHAIN.yaml [DIRECTORY]: Kalibr's calibration of two cameras -> left.yaml and right.yaml,
camera_info as drivers read it, with the R and P that rectify the pair (camera_info_url of the driver). Raw images go
with Kalibr's T_cam_imu as it is, rectified ones with R * T_cam_imu."""
import argparse
import os

import cv2
import numpy as np
import yaml

# Kalibr's name -> name in sensor_msgs/CameraInfo, number of coefficients.
MODELS = {"radtan": ("plumb_bob", 5), "equidistant": ("equidistant", 4), "none": ("plumb_bob", 5)}


def camera(chain, name):
    """(K, distortion model, D, size) of a camera of the chain."""
    if name not in chain:
        raise SystemExit("the file has no %s; give the camchain of a stereo calibration" % name)
    values = chain[name]
    if values["camera_model"] != "pinhole" or values["distortion_model"] not in MODELS:
        raise SystemExit("%s is %s-%s; only pinhole with %s can be a camera_info" %
                         (name, values["camera_model"], values["distortion_model"], ", ".join(MODELS)))
    model, count = MODELS[values["distortion_model"]]
    fx, fy, cx, cy = values["intrinsics"]
    D = np.zeros(count)
    D[:len(values["distortion_coeffs"])] = values["distortion_coeffs"]
    return np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]]), model, D, tuple(values["resolution"])


def rectified(chain):
    """[(K, model, D, size, R, P)] of left and right."""
    cameras = [camera(chain, name) for name in ("cam0", "cam1")]
    (K0, model, D0, size), (K1, other, D1, other_size) = cameras
    if (model, size) != (other, other_size):
        raise SystemExit("cam0 and cam1 must have one distortion model and one resolution")
    T = np.array(chain["cam1"]["T_cn_cnm1"])  # points of cam0 in cam1
    if model == "equidistant":
        R0, R1, P0, P1, _ = cv2.fisheye.stereoRectify(K0, D0, K1, D1, size, T[:3, :3], T[:3, 3], cv2.CALIB_ZERO_DISPARITY)
    else:
        R0, R1, P0, P1 = cv2.stereoRectify(K0, D0, K1, D1, size, T[:3, :3], T[:3, 3], alpha=0)[:4]
    if P1[0, 3] >= 0:
        raise SystemExit("cam1 does not stand to the right of cam0: exchange them in the file, or turn the rig")
    return [cameras[0] + (R0, P0), cameras[1] + (R1, P1)]


def camera_info(name, K, model, D, size, R, P):
    """As camera_calibration_parsers reads it."""
    matrix = lambda a: dict(rows=a.shape[0], cols=a.shape[1], data=[float(x) for x in a.ravel()])
    return dict(image_width=size[0], image_height=size[1], camera_name=name, camera_matrix=matrix(K),
                distortion_model=model, distortion_coefficients=matrix(D[None]), rectification_matrix=matrix(R),
                projection_matrix=matrix(P))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
                                     allow_abbrev=False)
    parser.add_argument("camchain")
    parser.add_argument("directory", nargs="?", default=".")
    arguments = parser.parse_args()
    with open(arguments.camchain) as stream:
        chain = yaml.safe_load(stream)
    for name, calibration in zip(("left", "right"), rectified(chain)):
        with open(os.path.join(arguments.directory, name + ".yaml"), "w") as out:
            yaml.safe_dump(camera_info(name, *calibration), out, default_flow_style=None)


if __name__ == "__main__":
    main()
