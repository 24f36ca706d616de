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


def compilations(build):
    """{file: (folder of the compile_commands.json that names it, its flags)}. CMake's own names the unity files; what
    these include gets one in BUILD_DIR/clang_tidy, as if it were compiled alone."""
    found, united = {}, []
    for entry in json.loads((build / "compile_commands.json").read_text()):
        found[entry["file"]] = (build, entry["command"])
        if "/Unity/" in entry["file"]:
            for file in UNITY_INCLUDE.findall(Path(entry["file"]).read_text()):
                united.append(dict(entry, file=file, command=entry["command"].replace(entry["file"], file)))
                found[file] = (build / "clang_tidy", united[-1]["command"])
    (build / "clang_tidy").mkdir(exist_ok=True)
    (build / "clang_tidy" / "compile_commands.json").write_text(json.dumps(united, indent=1))
    return found


def command_of(file, database):
    headers = "--header-filter=^%s/(include|src)/" % re.escape(str(ROOT))
    command = ["clang-tidy", "--quiet", "-p", str(database), headers]
    if "core" not in file.relative_to(ROOT / "src").parts[:1]:
        command.append("--checks=" + ",".join("-" + check for check in SLOW_CHECKS))
    return command + [str(file)]


def digest(file, build, database, flags):
    text = hashlib.sha256(repr((command_of(file, database), flags)).encode())
    folders = INCLUDE_FOLDERS + [build / folder for folder in GENERATED_FOLDERS]
    for part in sorted(files_read(file, folders, set())) + [ROOT / ".clang-tidy"]:
        text.update(part.read_bytes())
    return text.hexdigest()


def check(file, build, database, flags):
    """What clang-tidy says of a file that does not pass; None for one that does."""
    stamp = build / "clang_tidy" / str(file.relative_to(ROOT)).replace("/", "_")
    now = digest(file, build, database, flags)
    if stamp.is_file() and stamp.read_text() == now:
        return None
    done = subprocess.run(command_of(file, database), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if done.returncode:
        return done.stdout + done.stderr
    stamp.write_text(now)
    return None


def main(build):
    compiled = compilations(build)
    files = sorted((ROOT / "src").rglob("*.cpp"))
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        said = list(pool.map(lambda file: check(file, build, *compiled.get(str(file), (build, None))), files))
    for complaint in filter(None, said):
        print(complaint)
    return 1 if any(said) else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]).resolve()))
