#!/usr/bin/env python3
"""The floors of src/core, doc/architecture.md: a room includes its own files and rooms below it, a method no other method,
the core neither the ROS layer nor the evaluation, and these two not each other. Prints what does otherwise."""
import re
import sys
from pathlib import Path

# From the ground up; rooms of one line are neighbours and do not see each other.
FLOORS = [
    ["common"],
    ["features"],
    ["matching"],
    ["gms"],
    ["two_view"],
    ["ransac"],
    ["judgement", "scale", "tracks"],
    ["methods"],
    ["match_filter"],
]
LEVEL = {room: level for level, rooms in enumerate(FLOORS) for room in rooms}
# Files beside the rooms.
ROOM_OF_FILE = {name: "match_filter" for name in ("match_filter.cpp", "survivors.cpp", "survivors.h")}
# What a method's own file is made of; every other file of the room is a method.
SHARED_BY_METHODS = {"ransac_method", "registry", "rolling_shutter"}
INCLUDE = re.compile(r'^#include "([^"]+)"', re.MULTILINE)


def room_of(path):
    return path.parts[0] if len(path.parts) > 1 else ROOM_OF_FILE.get(path.name, "common")


def includes(file):
    return [Path(name) for name in INCLUDE.findall(file.read_text()) if not name.startswith("gms_ransac/")]


def sources(folder):
    return sorted(file for pattern in ("*.h", "*.cpp") for file in folder.rglob(pattern))


def complaints(root):
    core = root / "src/core"
    core_headers = {file.relative_to(core) for file in sources(core) if file.suffix == ".h"}
    for file in sources(core):
        path = file.relative_to(core)
        room = room_of(path)
        if room not in LEVEL:
            yield "%s is in no room that doc/architecture.md knows" % path
            continue
        for header in includes(file):
            if header not in core_headers:
                yield "src/core/%s includes %s, which is not of the core" % (path, header)
                continue
            other = room_of(header)
            if other != room and LEVEL[other] >= LEVEL[room]:
                yield "src/core/%s includes %s, which is not below it" % (path, header)
            stems = (path.stem, header.stem)
            if room == other == "methods" and stems[0] != stems[1] and not SHARED_BY_METHODS.intersection(stems):
                yield "src/core/%s includes another method, %s" % (path, header)
    for room, stranger in (("ros", "evaluation"), ("evaluation", "ros")):
        headers = {file.relative_to(root / "src" / stranger) for file in sources(root / "src" / stranger)}
        own = {file.relative_to(root / "src" / room) for file in sources(root / "src" / room)}
        for file in sources(root / "src" / room):
            for header in includes(file):
                if header in headers and header not in own and header not in core_headers:
                    yield "%s includes %s of src/%s" % (file.relative_to(root), header, stranger)


def main():
    found = list(complaints(Path(__file__).resolve().parent.parent))
    for complaint in found:
        print(complaint)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
