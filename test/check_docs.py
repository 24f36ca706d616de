#!/usr/bin/env python3
"""The documents: no shelf has more words than somebody reads, every link leads to a page and a heading that exist, and so
does every page that a comment names, and what the README says in figures is on the page that it links to. Exit status 1,
and a line for each fault, otherwise."""
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
# Most words of each shelf, tables included; of what is measured only those outside of tables and commands.
SHELVES = (("README.md", ["README.md"], 1600, False),
           ("doc/ (for users)", ["doc/*.md", "doc/consumers/*.md"], 11000, False),
           ("doc/inside/", ["doc/inside/*.md"], 8100, False),
           ("doc/measured/", ["doc/measured/*.md"], 1500, True))
LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")
NUMBER = re.compile(r"(?<![\w.])\d+(?:\.\d+)?")
NAMED = re.compile(r"\bdoc/[\w/]+\.(?:md|png)(?:#[\w-]+)?")
NAMING = ("include", "src", "launch", "cfg", "scripts", "examples", "test", "msg", "rviz", "CONTRIBUTING.md", "CMakeLists.txt",
          "package.xml", "debian", "Doxyfile")


def pages():
    return [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(ROOT.glob("doc/**/*.md"))]


def words(text, prose_alone):
    """As wc counts them."""
    lines = text.splitlines()
    if prose_alone:
        lines = [line for line in lines if not line.startswith(("|", "    ", "<!--"))]
    return sum(len(line.split()) for line in lines)


def anchors(text):
    """The headings of a page as GitHub names them, and its own anchors."""
    found = set(re.findall(r'<a id="([\w-]+)">', text))
    for line in text.splitlines():
        heading = re.match(r"#+ (.*)", line)
        if heading:
            plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading[1]).strip().lower()
            found.add(re.sub(r"[^\w\- ]", "", plain).replace(" ", "-"))
    return found


def problem_of(link, page):
    """Why a link of a page leads nowhere; empty: it leads somewhere, or out of the project."""
    if re.match(r"\w+:", link):
        return ""
    path, _, anchor = link.partition("#")
    target = (page.parent / path).resolve() if path else page
    if not target.exists():
        return "there is no such file"
    if anchor and anchor not in anchors(target.read_text()):
        return "%s has no such heading" % target.relative_to(ROOT)
    return ""


def outside_of_code(text):
    return "\n".join(line for line in text.splitlines() if not line.startswith("    "))


def long_shelves():
    for name, patterns, most, prose_alone in SHELVES:
        count = sum(words(page.read_text(), prose_alone) for pattern in patterns for page in ROOT.glob(pattern))
        print("%-18s %6d words%s, at most %d" % (name, count, " outside of tables" if prose_alone else "", most))
        if count > most:
            yield "%s has %d words%s; at most %d" % (name, count, " outside of tables" if prose_alone else "", most)


def dead_links():
    linked = {ROOT / "README.md", ROOT / "CONTRIBUTING.md"}
    for page in pages():
        for link in LINK.findall(outside_of_code(page.read_text())):
            problem = problem_of(link, page)
            if problem:
                yield "%s: %s: %s" % (page.relative_to(ROOT), link, problem)
            linked.add((page.parent / link.partition("#")[0]).resolve())
    for page in pages():
        if page not in linked:
            yield "%s: no page links to it" % page.relative_to(ROOT)


def dead_names():
    for name in NAMING:
        for file in [ROOT / name] if (ROOT / name).is_file() else sorted((ROOT / name).rglob("*")):
            if not file.is_file() or "inputs" in file.parts or file.name == Path(__file__).name:
                continue
            for named in NAMED.findall(file.read_bytes().decode("utf-8", "replace")):
                problem = problem_of(named, ROOT / "README.md")
                if problem:
                    yield "%s: %s: %s" % (file.relative_to(ROOT), named, problem)


def stale_figures():
    """Rows of the README's table "How good it is": the numbers after the first cell are those of a page that the row links."""
    readme = ROOT / "README.md"
    for row in re.search(r"## How good it is\n(.*?)\n## ", readme.read_text(), re.DOTALL)[1].splitlines():
        linked = "".join((ROOT / link.partition("#")[0]).read_text() for link in LINK.findall(row))
        said = "|".join(LINK.sub("", row).split("|")[2:])
        for number in sorted(set(NUMBER.findall(said)) - set(NUMBER.findall(linked))):
            yield "README.md: %s is not on the page of its row: %s" % (number, row)


def main():
    faults = [fault for check in (long_shelves, dead_links, dead_names, stale_figures) for fault in check()]
    print("\n".join(faults))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
