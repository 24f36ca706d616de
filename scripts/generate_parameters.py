#!/usr/bin/env python3
"""From the table in cfg/parameters.py:
  generate_parameters.py core FILE    C++ with the rows of the core's options and their fields; for parameter.cpp
  generate_parameters.py node FILE    the same for the options of the node; for src/ros/node/read_parameters.cpp
  generate_parameters.py --write      cfg/match_filter.yaml and the tables in README.md and doc/parameters.md
  generate_parameters.py --check      exit status 1 if --write would change one of these
A table stands below a line `<!-- parameters: WORDS -->`: the names of groups, or of parameters, in the order wanted."""
import itertools
import json
import re
import sys
import textwrap
from pathlib import Path

sys.dont_write_bytecode = True
ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "cfg"))
from parameters import GROUPS, STRUCTS

WIDTH, INDENT = 120, 27  # of match_filter.yaml: of a line, and of most comments


def in_yaml(value):
    """As YAML and C++ write it, too."""
    return json.dumps(value)


# C++

def braced(items):
    return "{" + ", ".join(items) + "}"


def cpp_row(row):
    low, high = row.range or (0, 0)
    default = row.example if row.default is None else row.default
    default = "std::string(%s)" % in_yaml(default) if isinstance(default, str) else in_yaml(default)
    return braced((in_yaml(row.name), default, str(low), str(high), in_yaml(row.unit), in_yaml(row.sentence),
                   braced(map(in_yaml, row.choices))))


def cpp_visit(number, path, row):
    """The row with its field; `words` is compiled for enumerations alone, and has no word for "not set"."""
    words = (word for word in row.choices if not (row.open and word == row.default))
    pairs = ["{%s, Enum::k%s}" % (in_yaml(word), word.title().replace("_", "")) for word in words]
    words = "[](auto any) { using Enum = decltype(any); return Words<Enum>%s; }" % braced(pairs) if pairs else "kNoWords"
    return "visit(rows[%d], options.%s, %s);" % (number, path, words)


def rows_of(struct):
    """The rows that set a field of the struct, each with the path of its field."""
    for group, row in ((group, row) for group in GROUPS for row in group.parameters):
        path = row.field or "%s.%s" % (group.at, row.name)
        root, below = path.split(".", 1)
        if STRUCTS[root] == struct:
            yield row, path if struct == "RuntimeOptions" else below


def cpp(header, **structs):
    """Specializations of ParameterFields for structs that the header declares. A name with a slash has no field."""
    lines = ["// Generated from cfg/parameters.py; for one source file.", '#include "%s"' % header,
             '#include "parameters/parameter_binding.h"', "namespace gms_ransac {"]
    for struct, rows in structs.items():
        rows = list(rows)
        lines += ["template <>", "struct ParameterFields<%s> {" % struct, "static const ParameterTable& table() {",
                  "  static const ParameterTable rows = {"]
        lines += [cpp_row(row) + "," for row, _ in rows]
        lines += ["  };", "  return rows;", "}", "template <class Some, class Visit>",
                  "static void each(Some& options, const Visit& visit) {", "  const ParameterTable& rows = table();"]
        lines += [cpp_visit(i, path, row) for i, (row, path) in enumerate(rows) if "/" not in row.name]
        lines += ["}", "};"]
    return "\n".join(lines + ["}  // namespace gms_ransac", ""])


def core():
    return cpp("gms_ransac/match_filter_options.h", MatchFilterOptions=rows_of("MatchFilterOptions"))


def node():
    of_core = [(row, "processor.core." + path) for row, path in rows_of("MatchFilterOptions")]
    return cpp("node/read_parameters.h", Parameters=rows_of("Parameters"),
               RuntimeOptions=of_core + list(rows_of("RuntimeOptions")))


# Documents

def range_text(row):
    if row.choices:
        return ", ".join(map(plain, row.choices))
    if not row.range:
        return ""
    bounds = " .. ".join("%d" % bound if bound == int(bound) else "%r" % bound for bound in row.range)
    return "%d, %s" % (row.default, bounds) if row.open else bounds


def plain(value):
    """As a reader of YAML or Markdown expects it: words without quotes."""
    return value if isinstance(value, str) and value else in_yaml(value)


def alike_in(row):
    """Neighbours with the same of these differ in nothing but the name, and are explained once."""
    return row.sentence, row.range


def setting_in_yaml(row):
    return "# %s: %s" % (row.name, row.example) if row.default is None else "%s: %s" % (row.name, plain(row.default))


def yaml_row(row):
    setting = setting_in_yaml(row)
    allowed = "" if row.name == "method" else range_text(row)
    comment = row.sentence + ("; " + allowed if allowed else "")
    indent = max(INDENT, len(setting) + 1)
    lines = textwrap.wrap(comment, WIDTH - indent - 2)
    return [setting.ljust(indent) + "# " + lines[0]] + [" " * indent + "# " + line for line in lines[1:]]


def match_filter_yaml():
    lines = [
        "# Parameters of gms_ransac/MatchFilter, all at their defaults; made from parameters.py.",
        "#   roslaunch gms_ransac match_filter.launch parameters:=/path/to/a/copy.yaml",
        "# Those under \"can change\" also change while running (rosrun rqt_reconfigure rqt_reconfigure), the others at start only.",
        "# A wrong type, a number out of its range or an unknown word is refused with a sentence: at start the node ends, while",
        "# running all parameters keep their values."]
    for group in GROUPS:
        lines += ["", "# --- %s (%s)" % (group.title, "can change" if group.live else "fixed at start")]
        for _, alike in itertools.groupby(group.parameters, alike_in):
            rows = list(alike)
            lines += yaml_row(rows[0]) + [setting_in_yaml(row) for row in rows[1:]]
    return "\n".join(lines) + "\n"


def table_row(rows):
    row = rows[0]
    allowed = "see `match_filter_node --methods`" if row.name == "method" else range_text(row)
    cells = (", ".join("`~%s`" % each.name for each in rows), "" if row.default is None else plain(row.default), allowed,
             row.sentence)
    return "| %s |" % " | ".join(cells)


def rows_named(words):
    groups = {group.name: group.parameters for group in GROUPS}
    parameters = {row.name: row for group in GROUPS for row in group.parameters}
    return [row for word in words for row in ([parameters[word]] if word in parameters else groups[word])]


def table(words):
    lines = [table_row(list(alike)) for _, alike in itertools.groupby(rows_named(words), alike_in)]
    return "\n".join(["| parameter | default | range | meaning |", "|---|---|---|---|"] + lines)


def with_tables(text):
    return re.sub(r"(<!-- parameters: (.*?) -->\n)(?:\|.*\n)*", lambda found: found[1] + table(found[2].split()) + "\n", text)


def documents():
    texts = {path: with_tables(path.read_text()) for path in (ROOT / "README.md", ROOT / "doc/parameters.md")}
    return {ROOT / "cfg/match_filter.yaml": match_filter_yaml(), **texts}


def ambiguous_groups():
    """Names of a group and of a parameter: rqt_reconfigure crashes, and a table cannot tell which is meant."""
    return sorted({group.name for group in GROUPS} & {row.name for group in GROUPS for row in group.parameters})


def main(arguments):
    if arguments == ["--write"]:
        for path, text in documents().items():
            path.write_text(text)
    elif arguments == ["--check"]:
        stale = [path.name for path, text in documents().items() if path.read_text() != text]
        if stale:
            print("%s: not what cfg/parameters.py says; run scripts/generate_parameters.py --write" % ", ".join(stale))
        for name in ambiguous_groups():
            print("cfg/parameters.py: a group and a parameter are both called %s" % name)
        return 1 if stale or ambiguous_groups() else 0
    elif len(arguments) == 2 and arguments[0] in ("core", "node"):
        Path(arguments[1]).write_text({"core": core, "node": node}[arguments[0]]())
    else:
        print(__doc__, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
