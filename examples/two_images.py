#!/usr/bin/env python3
"""two_images.py REFERENCE CURRENT FX FY CX CY: prints the motion between two undistorted images, without ROS, and draws
the matches into two_images.png: green are likely right, red are not; a dot marks the current image."""
import sys

import cv2

import gms_ransac

if len(sys.argv) != 7:
    sys.exit(__doc__)
reference, current = (cv2.imread(name) for name in sys.argv[1:3])
for name, image in zip(sys.argv[1:], (reference, current)):
    if image is None:
        sys.exit("cannot read the image " + name)
fx, fy, cx, cy = map(float, sys.argv[3:7])
height, width = current.shape[:2]
camera = gms_ransac.Camera(width, height, K=[[fx, 0, cx], [0, fy, cy], [0, 0, 1]])
pair = gms_ransac.match(reference, current, camera)
print("%s: %s" % (pair.status, pair.status_text))
print("X_reference = T X_current, T =\n%s" % pair.current_in_reference)
for point, end, probability in zip(pair.reference_points, pair.current_points, pair.probability):
    if probability > 0:
        green, end = 255 * float(probability), tuple(map(int, end))
        colour = (0, green, 255 - green)  # OpenCV 4.10 takes no scalars of numpy
        cv2.line(current, tuple(map(int, point)), end, colour, 1, cv2.LINE_AA)
        cv2.circle(current, end, 2, colour, -1)
cv2.imwrite("two_images.png", current)
