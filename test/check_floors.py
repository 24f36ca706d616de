#!/usr/bin/env python3
"""The floors of src/core and src/ros, doc/inside/architecture.md: a room includes its own files and rooms below it, a method no
other method, the core neither the ROS layer nor the evaluation, and these two not each other but for one header. Prints
what does otherwise."""
import re
import sys
from pathlib import Path

INCLUDE = re.compile(r'^#include "([^"]+)"', re.MULTILINE)
# Files that the methods share; every other file of the room is a method.
SHARED_BY_METHODS = {"ransac_method", "method", "optima", "rolling_shutter"}


# The stream of the node for offline programs, without a type of ROS.
STREAM_DOOR = "stream/stream_odometry.h"
PUBLIC = "gms_ransac"
# The rooms of the core that the public headers belong to.
PUBLIC_ROOMS = {
    "camera.h": "common", "simd.h": "common", "features.h": "common", "relative_pose.h": "common", "past.h": "past",
    "shutter.h": "common", "stream_constant.h": "common",
    "feature_extractor.h": "features", "hamming_matcher.h": "matching", "motion_statistics.h": "gms",
    "point_pairs.h": "two_view", "learned_mask.h": "two_view", "robust_options.h": "two_view", "robust_result.h": "two_view", "evidence.h": "two_view",
    "match_result.h": "ransac", "match_filter_options.h": "ransac", "match_filter.h": "match_filter", "status_text.h": "match_filter",
    "triangulation.h": "scale", "correspondences_view.h": "common", "keypoints_view.h": "common"}


class House:
    """A folder of rooms. `floors`: from the ground up; rooms of one line are neighbours and do not see each other.
    `beside`: files beside the rooms that are not of the ground floor. `public`: the folder of headers for users."""

    def __init__(self, folder, floors, beside, public=None):
        self.folder = folder
        self.public = public
        self.levels = {room: level for level, rooms in enumerate(floors) for room in rooms}
        self.beside = beside
        self.headers = {file.relative_to(folder) for file in sources(folder) if file.suffix == ".h"}
        if public:
            self.headers |= {Path(PUBLIC) / file.name for file in sources(public)}

    def room_of(self, path):
        if path.parts[0] == PUBLIC:
            return PUBLIC_ROOMS.get(path.name, "nowhere")
        return path.parts[0] if len(path.parts) > 1 else self.beside.get(path.name, "common")

    def files(self):
        """(file, its name in the house)"""
        for file in sources(self.folder):
            yield file, file.relative_to(self.folder)
        for file in sources(self.public) if self.public else ():
            yield file, Path(PUBLIC) / file.name

    def includes(self):
        """(file, header), as the house names them."""
        for file, path in self.files():
            for name in INCLUDE.findall(file.read_text()):
                if not name.startswith(PUBLIC) or Path(name).name in PUBLIC_ROOMS:
                    yield path, Path(name)

    def complaints(self):
        for _, path in self.files():
            if self.room_of(path) not in self.levels:
                yield "%s is in no room that doc/inside/architecture.md knows" % path
        for path, header in self.includes():
            if header in self.headers:
                room, other = self.room_of(path), self.room_of(header)
                if other != room and self.levels.get(other, 0) >= self.levels.get(room, 0):
                    yield "%s/%s includes %s, which is not below it" % (self.folder.name, path, header)

    def strangers(self, known, doors=()):
        """Includes of what is neither of this house nor of the known ones. `doors`: headers of others that are allowed."""
        for path, header in self.includes():
            if str(header) not in doors and not any(header in house.headers for house in [self] + known):
                yield "%s/%s includes %s, which is not its own" % (self.folder.name, path, header)


def sources(folder):
    return sorted(file for pattern in ("*.h", "*.cpp") for file in folder.rglob(pattern))


def methods_that_meet(core):
    for path, header in core.includes():
        stems = (path.stem, header.stem)
        if core.room_of(path) == core.room_of(header) == "methods" and stems[0] != stems[1]:
            if header in core.headers and not SHARED_BY_METHODS.intersection(stems):
                yield "core/%s includes another method, %s" % (path, header)


def complaints(root):
    core = House(
        root / "src/core",
        [["common"], ["support"], ["camera"], ["features"], ["matching"], ["gms"], ["two_view"], ["ransac"],
         ["judgement", "scale", "tracks"], ["methods"], ["past", "parameters"], ["match_filter"]],
        {name: "match_filter" for name in
         ("alignment.cpp", "alignment.h", "match_filter.cpp", "match_filter_hooks.h", "match_result.cpp", "status_text.cpp",
          "survivors.cpp", "survivors.h")},
        root / "include/gms_ransac")
    ros = House(root / "src/ros", [["common"], ["priors"], ["input"], ["stream"], ["output"], ["node"]], {})
    evaluation, python = House(root / "src/evaluation", [], {}), House(root / "src/python", [], {})
    yield from core.complaints()
    yield from core.strangers([])
    yield from methods_that_meet(core)
    yield from ros.complaints()
    yield from ros.strangers([core])
    yield from evaluation.strangers([core], [STREAM_DOOR])
    yield from python.strangers([core])


def main():
    found = list(complaints(Path(__file__).resolve().parent.parent))
    for complaint in found:
        print(complaint)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
