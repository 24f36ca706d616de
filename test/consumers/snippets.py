#!/usr/bin/env python3
"""snippets.py FOLDER: makes programs of the snippets of README.md and doc/use_it.md as they stand, with
what they take for granted (an image, a message) around them: FOLDER/catkin and FOLDER/cmake with the CMake lines of
use_it.md, and FOLDER/snippets.py."""
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGES = ("README.md", "doc/use_it.md")

CPP = """#include <iostream>
#include <gms_ransac/match_filter.h>
#include <gms_ransac/triangulation.h>
#include <opencv2/features2d.hpp>
#include "numbers.h"
%(includes)s
const cv::Mat image0 = drawSquares(0), image1 = drawSquares(1);
gms_ransac::MatchFilter filter;
std::vector<cv::KeyPoint> keypoints;
cv::Mat descriptors;
int used = 0;
void use(const cv::Point2f&) { ++used; }
%(given)s
%(functions)s
int main() {
  cv::ORB::create()->detectAndCompute(image0, cv::Mat(), keypoints, descriptors);
%(calls)s
  std::cout << (used > 20 ? "%(count)d snippets ran\\n" : "no match was used\\n");
}
"""
# A node that has received both.
MESSAGES = """#include <boost/make_shared.hpp>
#include <gms_ransac/Correspondences.h>
#include <sensor_msgs/CameraInfo.h>
boost::shared_ptr<gms_ransac::Correspondences> received() {
  auto message = boost::make_shared<gms_ransac::Correspondences>();
  message->K = {500, 0, 320, 0, 500, 240, 0, 0, 1};
  message->current_in_reference.pose.orientation.w = 1;
  return message;
}
const gms_ransac::CorrespondencesConstPtr message = received();
sensor_msgs::CameraInfoConstPtr lens() {
  auto info = boost::make_shared<sensor_msgs::CameraInfo>();
  info->distortion_model = "plumb_bob";
  info->D.resize(5);
  return info;
}
const sensor_msgs::CameraInfoConstPtr camera_info = lens();
"""
PYTHON = """import types
import cv2
import numpy as np
random = np.random.RandomState(1)
wide = cv2.resize(random.randint(0, 256, (60, 84)).astype(np.uint8), None, fx=8, fy=8, interpolation=cv2.INTER_NEAREST)
cv2.imwrite("0.png", wide[:, :640])
cv2.imwrite("1.png", wide[:, 12:652])
points0 = random.uniform(20, 460, (200, 2))
points1 = points0 + 5
descriptors0 = descriptors1 = random.randint(0, 256, (200, 64)).astype(np.uint8)
columns = dict.fromkeys(("reference_points", "current_points"), [1, 2, 3, 4])
message = types.SimpleNamespace(probability=[0.95, 0.1], **columns)
"""
PACKAGE = """<package format="2"><name>my_package</name><version>0.0.1</version><description>A stranger's.</description>
<maintainer email="me@example.org">me</maintainer><license>BSD-3-Clause</license><buildtool_depend>catkin</buildtool_depend>
<depend>gms_ransac</depend></package>
"""


def paragraphs():
    """Paragraphs of the indented blocks of code of all pages, without the indentation."""
    for page in PAGES:
        for block in re.findall(r"(?:^    .*\n|^\n(?=    ))+", (ROOT / page).read_text(encoding="utf-8"), re.MULTILINE):
            for paragraph in re.split(r"\n\s*\n", block):
                yield "\n".join(line[4:] for line in paragraph.splitlines()).strip("\n") + "\n"


def program(snippets, given):
    split = [[line for line in snippet.splitlines() if line.startswith("#include") == wanted] for snippet in snippets
             for wanted in (True, False)]
    functions = ["void snippet%d() {\n%s\n}\n" % (i, "\n".join(lines)) for i, lines in enumerate(split[1::2])]
    return CPP % {"includes": "\n".join(sum(split[::2], [])), "given": given, "functions": "\n".join(functions),
                  "calls": "\n".join("  snippet%d();" % i for i in range(len(snippets))), "count": len(snippets)}


def main():
    folder, found = Path(sys.argv[1]), list(paragraphs())
    cpp = [snippet for snippet in found if "gms_ransac::" in snippet and "find_package" not in snippet
           and "target_link_libraries" not in snippet]
    python = [snippet for snippet in found if re.search(r"import .*gms_ransac|= gms_ransac\.|np\.asarray", snippet)]
    catkin, = [snippet for snippet in found if "find_package(catkin" in snippet]
    cmake, = [snippet for snippet in found if "find_package(gms_ransac" in snippet]
    with_message = [snippet for snippet in cpp if "message" in snippet]
    head = "cmake_minimum_required(VERSION 3.10)\nproject(my_package)\ninclude_directories(%s)\n" % Path(__file__).parent
    for name, text in (("catkin/CMakeLists.txt", head + catkin), ("catkin/package.xml", PACKAGE),
                       ("catkin/my_node.cpp", program(cpp, MESSAGES)), ("cmake/CMakeLists.txt", head + cmake),
                       ("cmake/my_program.cpp", program([each for each in cpp if each not in with_message], "")),
                       ("snippets.py", PYTHON + "\n".join(python) + "print(%d, 'snippets ran')\n" % len(python))):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    if len(cpp) < 3 or not with_message or len(python) < 3:
        sys.exit("found %d snippets of C++, %d with a message, and %d of Python: the pages had more"
                 % (len(cpp), len(with_message), len(python)))


if __name__ == "__main__":
    main()
