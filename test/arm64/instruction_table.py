#!/usr/bin/env python3
"""usage: instruction_table.py STAGES MARKS: the instructions of each stage of frame_instructions, a frame in the mean."""
import collections
import sys


def main(stages_file, marks_file):
    with open(stages_file) as lines:
        stages = dict(line.split(maxsplit=2)[1:] for line in lines if line.startswith("stage "))
    counts = collections.defaultdict(list)
    with open(marks_file) as lines:
        for line in lines:
            words = line.split()
            if words[:1] == ["mark"]:
                counts[stages[words[1]].strip()].append(int(words[2]))
    counts.pop("-", None)
    if not counts:
        sys.exit(f"{marks_file}: no mark was heard of; is the plugin loaded?")
    print(f"{'stage':34} {'frames':>6} {'million instructions':>21}")
    for stage, values in counts.items():
        warm = values[1:]  # the first one sets up what the next ones use
        print(f"{stage:34} {len(warm):6} {sum(warm) / len(warm) / 1e6:21.2f}")


if __name__ == "__main__":
    main(*sys.argv[1:])
