#!/usr/bin/env python3
"""clang-tidy over every file of src: check_tidy.py BUILD_DIR. A file that passed is looked at again only when it, a header
of the project that it includes, written or generated, its flags or the list of checks changed; BUILD_DIR/clang_tidy
remembers."""
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


def command_of(file, build):
    command = ["clang-tidy", "--quiet", "-p", str(build), "--header-filter=^%s/(include|src)/" % re.escape(str(ROOT))]
    if "core" not in file.relative_to(ROOT / "src").parts[:1]:
        command.append("--checks=" + ",".join("-" + check for check in SLOW_CHECKS))
    return command + [str(file)]


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
    with open(build / "compile_commands.json") as stream:
        flags = {entry["file"]: entry["command"] for entry in json.load(stream)}
    (build / "clang_tidy").mkdir(exist_ok=True)
    files = sorted((ROOT / "src").rglob("*.cpp"))
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        said = list(pool.map(lambda file: check(file, build, flags.get(str(file))), files))
    for complaint in filter(None, said):
        print(complaint)
    return 1 if any(said) else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]).resolve()))
