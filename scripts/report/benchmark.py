"""`benchmark`: median, 99th percentile and largest of each row's milliseconds, how many times faster than its baseline it
is, and the mean matches kept and correct."""
import json
import os
import re

import numpy as np

from report.common import grouped, markdown, mean, naming

HEAD = ["stage", "what", "ms", "p99", "most", "times faster", "kept", "correct"]


def table(records):
    rows = []
    for stage, of_stage in grouped(records, lambda record: record["stage"]).items():
        contenders = grouped(of_stage, lambda record: record["what"])
        times = {what: [record["ms"] for record in part] for what, part in contenders.items()}
        for what, part in sorted(contenders.items(), key=lambda item: item[1][0]["baseline"] is not None):
            baseline = part[0]["baseline"]
            counts = [[record[key] for record in part if record[key] is not None] for key in ("kept", "correct")]
            figures = [np.median(times[what]), np.percentile(times[what], 99), max(times[what])]
            rows.append([stage, what] + ["%.3f" % figure for figure in figures] +
                        ["%.1f" % (np.median(times[baseline]) / np.median(times[what])) if baseline else ""] +
                        ["%.0f" % mean(values) if values else "" for values in counts])
            stage = ""
    return markdown(HEAD, rows)


def machine():
    with open("/proc/cpuinfo") as lines:
        name = re.search(r"^model name\s*: (.*)", lines.read(), re.MULTILINE)
    return "%s, %d cores" % (name[1] if name else "unknown processor", os.cpu_count())


def report(lines, head, path):
    text = "%s; %s\n" % (head, machine())
    settings = grouped(map(json.loads, lines), lambda record: (record["features"], record["threads"]))
    for (features, threads), records in settings.items():
        text += "\n%d features, %d thread%s\n\n%s" % (features, threads, "s" * (threads > 1), table(records))
    print(text, end="")
    if path:
        with naming(path), open(path, "w") as stream:
            stream.write(text)
