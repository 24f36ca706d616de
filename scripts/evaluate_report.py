#!/usr/bin/env python3
"""The reports of `evaluate` and `benchmark`: tables and plots of what they measured. They call it; call it to repeat a report.

  evaluate_report.py run [--plot FILE] <RECORDS          the table of `evaluate run`, from the lines of its --out
  evaluate_report.py sweep [--out FILE.csv] <RECORDS     the table of `evaluate sweep`, and its plot next to it
  evaluate_report.py tables FOLDER [--no-plots]          tables and figures of `evaluate tables`
  evaluate_report.py merge PART... [--out FOLDER] [--no-plots]
                                                         joins what `evaluate tables --shard` wrote, and makes its tables
  evaluate_report.py trust FOLDER [--no-tables] [--before FOLDER] [--into DOCUMENT]...
                                                         tables and plots of `evaluate trust`, or of a file of records of
                                                         `evaluate run`, into the folder of its name
  evaluate_report.py motion FOLDER                       the statuses of recorded motions that scripts/trust renders
  evaluate_report.py odometry [--plot FILE] [--peer FILE]... [--witness FILE]... [--leave-out N] [--align] <RECORDS
                                                         the tables of `evaluate odometry`, from the lines of its --out
  evaluate_report.py insert DOCUMENT NAME FILE           puts what a program printed (scripts/demo: out/demo/summary.txt)
                                                         between the marks of that name in a document
  evaluate_report.py benchmark [--head TEXT] [--out FILE.md] <RECORDS
                                                         the tables of `benchmark`
"""
import argparse
import sys

try:
    import numpy  # noqa: F401
except ImportError:
    sys.exit("evaluate_report.py: numpy is missing; install python3-numpy")

from report import benchmark, odometry, run, sweep, tables, trust
from report.common import insert, printed


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
                                     allow_abbrev=False)
    commands = parser.add_subparsers(dest="command", metavar="COMMAND")
    commands.required = True

    def command(name, call):
        """Adds a command that calls that with its arguments; returns what adds these."""
        added = commands.add_parser(name, allow_abbrev=False)
        added.set_defaults(call=call)
        return added.add_argument

    option = command("run", lambda given: run.report(sys.stdin, given.plot))
    option("--plot", help="file for errors and inliers over time")
    option = command("sweep", lambda given: sweep.report(sys.stdin, given.out, not given.no_plots))
    option("--out", help="file for the table, CSV; standard output without")
    option("--no-plots", action="store_true")
    option = command("tables", lambda given: tables.report(given.folder.rstrip("/"), not given.no_plots))
    option("folder")
    option("--no-plots", action="store_true")
    option = command("merge", lambda given: tables.merge(given.parts, given.out.rstrip("/"), not given.no_plots))
    option("parts", nargs="+", metavar="PART", help="folder that evaluate tables --shard i/n wrote, with the same options")
    option("--out", "-o", default="tables", help="folder to write")
    option("--no-plots", action="store_true")
    option = command("trust", lambda given: trust.report(given.folder.rstrip("/"), not given.no_tables, given.before,
                                                         given.into))
    option("folder", help="of measurements; or a file of records")
    option("--no-tables", action="store_true", help="only pairs.csv")
    option("--before", help="an earlier folder of the same pairs: how many of its right answers are kept")
    option("--into", action="append", default=[], help="document whose marked tables are replaced; may be repeated")
    option = command("motion", lambda given: trust.motions(given.folder.rstrip("/")))
    option("folder", help="of measurements")
    option = command("odometry", lambda given: odometry.report(sys.stdin, given.plot, given.peer, given.witness,
                                                               given.leave_out, given.align, given.witness_noise))
    option("--plot", help="file for the paths, and the errors over the length")
    option("--peer", action="append", default=[], help="poses of another system; once for each set, in their order")
    option("--witness", action="append", default=[], help="poses of a second truth; once for each set, in their order")
    option("--leave-out", type=int, default=0, help="images at the start of each set that are not measured")
    option("--align", action="store_true", help="also with the constant rotation between the two camera frames fitted out")
    option("--witness-noise", type=odometry.two_numbers, default=odometry.WITNESS_NOISE, metavar="METRES,DEGREES",
           help="standard deviations of a pose of the witness")
    option = command("benchmark", lambda given: benchmark.report(sys.stdin, given.head, given.out))
    option("--head", default="benchmark", help="line above the tables")
    option("--out", help="file for the tables, Markdown")
    option = command("insert", lambda given: insert(given.document, {given.name: printed(given.file)}))
    option("document")
    option("name", metavar="NAME", help="as in <!-- begin of the NAME -->")
    option("file", metavar="FILE", help="what the program printed")
    given = parser.parse_args()
    try:
        given.call(given)
    except OSError as error:
        sys.exit(": ".join(filter(None, ("evaluate_report.py", error.filename, error.strerror))))
    except odometry.BadPoses as error:
        parser.error(str(error))
    return 0


if __name__ == "__main__":
    sys.exit(main())
