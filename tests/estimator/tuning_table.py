#!/usr/bin/env python3
"""The table of tuned numbers in docs/model.md, written from estimator/common/tuning.hpp.

  tests/estimator/tuning_table.py            writes the table
  tests/estimator/tuning_table.py --check    exit status 1 where the table in the document is not current

The header is the source: one number a line, `double name = value;  ///< meaning [unit]`, where lines that hold
nothing but `///< ...` go on with the meaning, and `// --- heading ---` begins a group. A number without a unit is a ratio;
one without a meaning is an error. The table has a row for each group, with names, values and units. Exit status 2:
header or document are not as described here.
"""

import argparse
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
BEGIN = "<!-- tuning.hpp: begin -->\n"
END = "<!-- tuning.hpp: end -->\n"

GROUP = re.compile(r"\s*// --- (.+) ---$")
NUMBER = re.compile(r"\s*(?:double|int) (\w+) = ([^;]+);\s*(?:///<?\s?(.*))?$")
MORE = re.compile(r"\s*///<\s?(.*)$")
UNIT = re.compile(r"\s*\[([^\]]+)\]")


def rows(header: str) -> list[list[str]]:
    """Group headings as [heading], numbers as [name, value, meaning with unit]."""
    found: list[list[str]] = []
    body = header.partition("struct Tuning {\n")[2].partition("\n};")[0]
    for line in body.splitlines():
        if group := GROUP.match(line):
            found.append([group[1]])
        elif number := NUMBER.match(line):
            found.append([number[1], number[2], number[3] or ""])
        elif (more := MORE.match(line)) and found and len(found[-1]) == 3:
            found[-1][2] += " " + more[1]
        elif line.strip() and not line.strip().startswith("// "):
            raise ValueError(f"neither a number nor a comment: {line.strip()}")
    return found


def table(header: str) -> str:
    groups: dict[str, list[str]] = {}
    group = ""
    for row in rows(header):
        if len(row) == 1:
            group = row[0]
            continue
        name, value, comment = row
        if not UNIT.sub("", comment, count=1).strip(". "):
            raise ValueError(f"{name} has no meaning: add one after ///<")
        unit = UNIT.search(comment)
        groups.setdefault(group, []).append(f"`{name}` {value} {unit[1]}" if unit else f"`{name}` {value}")
    if not groups:
        raise ValueError("no number in struct Tuning")
    lines = [f"| {name} | {', '.join(numbers)} |" for name, numbers in groups.items()]
    return "\n".join(["| group | numbers |", "|---|---|", *lines]) + "\n"


def with_table(document: str, new: str) -> str:
    before, begin, rest = document.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise ValueError(f"the document has no {BEGIN.strip()} ... {END.strip()}")
    return before + begin + new + end + after


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--check", action="store_true", help="write nothing, compare")
    parser.add_argument("--header", type=pathlib.Path, default=ROOT / "estimator/common/tuning.hpp", metavar="FILE")
    parser.add_argument("--document", type=pathlib.Path, default=ROOT / "docs/model.md", metavar="FILE")
    given = parser.parse_args()
    try:
        document = given.document.read_text(encoding="utf-8")
        current = with_table(document, table(given.header.read_text(encoding="utf-8")))
    except (OSError, ValueError) as error:
        print(f"tuning_table: {given.header}, {given.document}: {error}", file=sys.stderr)
        return 2
    if given.check:
        if current != document:
            print(f"tuning_table: the table in {given.document} is not current; run {pathlib.Path(__file__).name}",
                  file=sys.stderr)
            return 1
        return 0
    given.document.write_text(current, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
