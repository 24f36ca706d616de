#!/usr/bin/env python3
"""clang-tidy over the files of src: check_tidy.py BUILD_DIR [FILE...]; without files over all. A file that passed is looked at
again only when it, a header of the project that it includes, its flags or the list of checks changed;
BUILD_DIR/clang_tidy remembers. Where most files of a CMake unity build are due they are looked at as one, in a third of the
time; else each by itself."""
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
COMPILED_HEADERS = re.compile(r" -include \S+/cmake_pch\.hxx")  # by the compiler; clang-tidy cannot read them
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


def write_database(build):
    """The compilation database that clang-tidy reads."""
    database = COMPILED_HEADERS.sub("", (build / "compile_commands.json").read_text())
    (build / "clang_tidy" / "compile_commands.json").write_text(database)


def sources(build):
    """{file of src: (its flags, the unity file that includes it or None)}"""
    database = json.loads((build / "clang_tidy" / "compile_commands.json").read_text())
    commands = {Path(entry["file"]): entry["command"] for entry in database}
    found = {file: (commands.get(file, ""), None) for file in (ROOT / "src").rglob("*.cpp")}
    for unity, command in commands.items():
        if unity.parent.name == "Unity":
            for file in map(Path, UNITY_INCLUDE.findall(unity.read_text())):
                if file in found:
                    found[file] = (command.replace(str(unity), ""), unity)
    return found


def command_of(file, build):
    headers = "--header-filter=^%s/(include|src)/" % re.escape(str(ROOT))
    command, off = ["clang-tidy", "--quiet", "-p", str(build / "clang_tidy"), headers], []
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


def due_files(found, build):
    """{file: the digest that it has when it passes}, of those that have not passed as they are."""
    due = {}
    for file, (flags, _) in found.items():
        now = digest(file, build, flags)
        if not stamp(file, build).is_file() or stamp(file, build).read_text() != now:
            due[file] = now
    return due


def stamp(file, build):
    return build / "clang_tidy" / str(file.relative_to(ROOT)).replace("/", "_")


def jobs(found, due):
    """[(what clang-tidy reads, files that this looks at)]"""
    together = {}
    for file, (_, unity) in found.items():
        if unity:
            together.setdefault(unity, []).append(file)
    listed = []
    for unity, files in together.items():
        if 2 * sum(file in due for file in files) > len(files):
            listed.append((unity, [file for file in files if file in due]))
    alone = set(due).difference(*(files for _, files in listed))
    return listed + [(file, [file]) for file in sorted(alone)]


def check(job, due, build):
    """What clang-tidy says of files that do not pass; None for those that do."""
    file, looked_at = job
    done = subprocess.run(command_of(file, build), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if done.returncode:
        return done.stdout + done.stderr
    for each in looked_at:
        stamp(each, build).write_text(due[each])
    return None


def main(build, files):
    (build / "clang_tidy").mkdir(exist_ok=True)
    write_database(build)
    found = sources(build)
    due = due_files({file: found[file] for file in found if not files or file in files}, build)
    print("clang-tidy: %d of %d files to look at" % (len(due), len(found)))
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        said = list(pool.map(lambda job: check(job, due, build), jobs(found, due)))
    for complaint in filter(None, said):
        print(complaint)
    return 1 if any(said) else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]).resolve(), {Path(name).resolve() for name in sys.argv[2:]}))
