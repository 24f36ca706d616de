#!/usr/bin/env python3
"""clang-tidy over every file of src: check_tidy.py BUILD_DIR. Files that are compiled as one (CMake's unity build) are looked
at as one, a third of the time of each by itself. What passed is looked at again only when it, a header of the project that
it includes, written or generated, its flags or the list of checks changed; BUILD_DIR/clang_tidy remembers."""
import concurrent.futures
import hashlib
import json
import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.MULTILINE)
UNITY_INCLUDE = re.compile(r'^#include "(/[^"]+\.cpp)"', re.MULTILINE)
INCLUDE_FOLDERS = [ROOT / folder for folder in ("include", "src/core", "src/ros", "src/evaluation")]
GENERATED_FOLDERS = ["generated", "devel/include"]  # of the build
# The headers of ROS are long, and these look at every node of them: two thirds of the time for what the core shows alone.
SLOW_CHECKS = ["performance-unnecessary-value-param", "bugprone-reserved-identifier", "bugprone-stringview-nullptr",
               "misc-unused-using-decls", "bugprone-assert-side-effect", "modernize-use-nullptr"]


def files_read(file, folders, seen):
    """The file and the headers in the folders behind its includes, in one set."""
    seen.add(file)
    for name in INCLUDE.findall(file.read_text()):
        for folder in [file.parent] + folders:
            header = (folder / name).resolve()
            if header.is_file():
                if header not in seen:
                    files_read(header, folders, seen)
                break
    return seen


def translation_units(build):
    """{what to compile: its flags}, for everything of src: a file, or the unity file that includes it."""
    commands = {Path(entry["file"]): entry["command"] for entry in json.loads((build / "compile_commands.json").read_text())}
    units, alone = {}, set((ROOT / "src").rglob("*.cpp"))
    for file, command in commands.items():
        if file.parent.name == "Unity":
            parts = {Path(name) for name in UNITY_INCLUDE.findall(file.read_text())} & alone
            if parts:
                units[file] = command
                alone -= parts
    units.update((file, commands.get(file, "")) for file in alone)
    return units


def command_of(file, build):
    headers = "--header-filter=^%s/(include|src)/" % re.escape(str(ROOT))
    command, off = ["clang-tidy", "--quiet", "-p", str(build), headers], []
    if ROOT / "src" / "core" not in file.parents:
        off += SLOW_CHECKS
    if file.parent.name == "Unity":
        off.append("bugprone-suspicious-include")
    return command + ["--checks=" + ",".join("-" + check for check in off)] * bool(off) + [str(file)]


def digest(file, build, flags):
    text = hashlib.sha256(repr((command_of(file, build), flags)).encode())
    folders = INCLUDE_FOLDERS + [build / folder for folder in GENERATED_FOLDERS]
    for part in sorted(files_read(file, folders, set())) + [ROOT / ".clang-tidy"]:
        text.update(part.read_bytes())
    return text.hexdigest()


def check(file, build, flags):
    """What clang-tidy says of a file that does not pass; None for one that does."""
    stamp = build / "clang_tidy" / str(file.relative_to(ROOT)).replace("/", "_")
    now = digest(file, build, flags)
    if stamp.is_file() and stamp.read_text() == now:
        return None
    done = subprocess.run(command_of(file, build), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if done.returncode:
        return done.stdout + done.stderr
    stamp.write_text(now)
    return None


def main(build):
    (build / "clang_tidy").mkdir(exist_ok=True)
    units = translation_units(build)
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        said = list(pool.map(lambda file: check(file, build, units[file]), sorted(units)))
    for complaint in filter(None, said):
        print(complaint)
    return 1 if any(said) else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]).resolve()))
