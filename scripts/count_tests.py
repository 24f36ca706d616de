#!/usr/bin/python3
"""Adds up what a test run did: count_tests.py RESULTS, a folder with ctest.log and the JUnit files of the programs.

A program with a JUnit file NAME.xml counts case by case, one without counts as one test. Prints the skipped and the
failed, then "N passed, N failed, N skipped". Exit status 1 if anything failed or nothing ran.
"""
import re
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

CTEST_LINE = re.compile(r"^\s*\d+/\d+ Test\s+#\d+: (\S+) \.*\s*(?:\*\*\*)?\s*(Passed|Skipped|Not Run|.*?)\s+[\d.]+ sec")


def cases(path):
    """Yields (name, outcome) for each case of a JUnit file."""
    for case in ElementTree.parse(path).getroot().iter("testcase"):
        name = "{}.{}".format(case.get("classname", ""), case.get("name"))
        if case.find("failure") is not None or case.find("error") is not None:
            yield name, "failed"
        elif case.find("skipped") is not None or case.get("result") == "skipped":
            yield name, "skipped"
        elif case.get("status") != "notrun":
            yield name, "passed"


def outcomes(program, verdict, results):
    """All (name, outcome) pairs of one program that ctest ran."""
    path = results / (program + ".xml")
    found = []
    if path.exists():
        try:
            found = [("{}: {}".format(program, name), outcome) for name, outcome in cases(path)]
        except ElementTree.ParseError:
            pass
    own = {"Passed": "passed", "Skipped": "skipped"}.get(verdict, "failed")
    # A program may die after (or without) writing its cases.
    if not found or (own == "failed" and all(outcome != "failed" for _, outcome in found)):
        found.append((program, own))
    return found


def main(folder):
    results = Path(folder)
    ran = []
    for line in (results / "ctest.log").read_text(errors="replace").splitlines():
        match = CTEST_LINE.match(line)
        if match:
            ran += outcomes(match.group(1), match.group(2), results)
    count = {outcome: sum(1 for _, o in ran if o == outcome) for outcome in ("passed", "failed", "skipped")}
    print()
    for outcome in ("skipped", "failed"):
        for name, o in ran:
            if o == outcome:
                print("{}: {}".format(outcome, name))
    print("{passed} passed, {failed} failed, {skipped} skipped".format(**count))
    return 0 if count["passed"] and not count["failed"] else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
