"""literals.txt lists every number in estimator/ outside of two tables, and the list only becomes shorter.

Numbers other than 0, 1, 2 and ½ belong in tuning.hpp, with meaning and origin, or, if they describe a sensor, in the
table of source.hpp. Those that are elsewhere are listed with their line of code; a new number fails this test, and so
does a listed one that has gone.

  tests/estimator/literals_test.py            checks the list
  tests/estimator/literals_test.py --update   writes it: only to take lines away
"""

import pathlib
import re
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
LIST = pathlib.Path(__file__).with_name("literals.txt")

NUMBER = re.compile(r"(?<![\w.'])(\d[\d']*(?:\.\d*)?(?:e[+-]?\d+)?)(?!['\w.])")
# Shapes of matrices and arrays, indices, conversions of units, and text that is not code.
NO_QUANTITY = re.compile(r'//.*|"[^"]*"|#include.*|<[^<>;=]*\d[^<>;=]*>\(?(?:\d(?:, \d)*\))?|\[\d+\]|\bP\(\d, \d\)|'
                         r'\b(seconds_per_ns|ns_per_second) = 1e-?9;')
PLAIN = {0.0, 0.5, 1.0, 2.0}


def numbers():
    """Lines "file: number: code" of all numbers."""
    found = []
    for path in sorted((ROOT / "estimator").rglob("*.?pp")):
        if path.name in ("tuning.hpp", "source.hpp"):
            continue
        for line in path.read_text(encoding="utf-8").splitlines():
            for number in NUMBER.findall(NO_QUANTITY.sub(" ", line)):
                if float(number.replace("'", "")) not in PLAIN:
                    found.append(f"{path.relative_to(ROOT / 'estimator')}: {number}: {line.strip()}")
    return found


class Literals(unittest.TestCase):
    def test_every_number_outside_of_tuning_is_listed(self):
        listed = LIST.read_text(encoding="utf-8").splitlines()
        found = numbers()
        new = [line for line in found if found.count(line) > listed.count(line)]
        gone = [line for line in listed if listed.count(line) > found.count(line)]
        self.assertFalse(new, f"write it into tuning.hpp, with its meaning: {new}")
        self.assertFalse(gone, f"take it off {LIST.name}: {gone}")

    def test_every_tuned_number_has_a_meaning(self):
        for line in (ROOT / "estimator/common/tuning.hpp").read_text(encoding="utf-8").splitlines():
            if re.match(r"  (double|int) ", line):
                self.assertRegex(line, r"= [\d.e+-]+; +///< \S", "a number a line, its meaning after it")


if __name__ == "__main__":
    if sys.argv[1:] == ["--update"]:
        LIST.write_text("\n".join(numbers()) + "\n", encoding="utf-8")
    else:
        unittest.main()
