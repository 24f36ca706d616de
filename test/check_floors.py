#!/usr/bin/env python3
"""The floors of src/core and src/ros, doc/architecture.md: a room includes its own files and rooms below it, a method no
other method, the core neither the ROS layer nor the evaluation, and these two not each other. Prints what does
otherwise."""
import re
import sys
from pathlib import Path

INCLUDE = re.compile(r'^#include "([^"]+)"', re.MULTILINE)
# What a method's own file is made of; every other file of the room is a method.
SHARED_BY_METHODS = {"ransac_method", "registry", "rolling_shutter"}


class House:
    """A folder of rooms. `floors`: from the ground up; rooms of one line are neighbours and do not see each other.
    `beside`: files beside the rooms that are not of the ground floor."""

    def __init__(self, folder, floors, beside):
        self.folder = folder
        self.levels = {room: level for level, rooms in enumerate(floors) for room in rooms}
        self.beside = beside
        self.headers = {file.relative_to(folder) for file in sources(folder) if file.suffix == ".h"}

    def room_of(self, path):
        return path.parts[0] if len(path.parts) > 1 else self.beside.get(path.name, "common")

    def includes(self):
        """(file, header), as the house names them."""
        for file in sources(self.folder):
            for name in INCLUDE.findall(file.read_text()):
                if not name.startswith("gms_ransac/"):
                    yield file.relative_to(self.folder), Path(name)

    def complaints(self):
        for file in sources(self.folder):
            path = file.relative_to(self.folder)
            if self.room_of(path) not in self.levels:
                yield "%s is in no room that doc/architecture.md knows" % path
        for path, header in self.includes():
            if header in self.headers:
                room, other = self.room_of(path), self.room_of(header)
                if other != room and self.levels.get(other, 0) >= self.levels.get(room, 0):
                    yield "%s/%s includes %s, which is not below it" % (self.folder.name, path, header)

    def strangers(self, known):
        """Includes of what is neither of this house nor of the known ones."""
        for path, header in self.includes():
            if not any(header in house.headers for house in [self] + known):
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
        [["common"], ["features"], ["matching"], ["gms"], ["two_view"], ["ransac"], ["judgement", "scale", "tracks"],
         ["methods"], ["match_filter"]],
        {name: "match_filter" for name in ("match_filter.cpp", "survivors.cpp", "survivors.h")})
    ros = House(root / "src/ros", [["common"], ["priors"], ["input"], ["stream"], ["output"], ["node"]], {})
    evaluation = House(root / "src/evaluation", [], {})
    yield from core.complaints()
    yield from core.strangers([])
    yield from methods_that_meet(core)
    yield from ros.complaints()
    yield from ros.strangers([core])
    yield from evaluation.strangers([core])


def main():
    found = list(complaints(Path(__file__).resolve().parent.parent))
    for complaint in found:
        print(complaint)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
