"""literals.txt lists every number in estimator/ outside of two tables, and the list only becomes shorter.

Numbers other than 0, 1, 2 and ½ belong in tuning.hpp, with meaning and origin, or, if they describe a sensor, in the
table of source.hpp. Those that are elsewhere are listed after their file; a new number fails this test, and so does a
listed one that has gone.

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


def numbers(path):
    """The numbers of a source file that are not plain, sorted as text."""
    code = [NO_QUANTITY.sub(" ", line) for line in path.read_text(encoding="utf-8").splitlines()]
    found = [number for line in code for number in NUMBER.findall(line)]
    return sorted(number for number in found if float(number.replace("'", "")) not in PLAIN)


def lines():
    """A line "file: number number ..." for every file that has any."""
    files = {str(path.relative_to(ROOT / "estimator")): numbers(path)
             for path in sorted((ROOT / "estimator").rglob("*.?pp")) if path.name not in ("tuning.hpp", "source.hpp")}
    return [f"{name}: {' '.join(found)}" for name, found in files.items() if found]


class Literals(unittest.TestCase):
    def test_every_number_outside_of_tuning_is_listed(self):
        self.assertEqual(LIST.read_text(encoding="utf-8").splitlines(), lines(),
                         f"write a new number into tuning.hpp, with its meaning; take a gone one off {LIST.name}")

    def test_every_tuned_number_has_a_meaning(self):
        for line in (ROOT / "estimator/common/tuning.hpp").read_text(encoding="utf-8").splitlines():
            if re.match(r"  (double|int) ", line):
                self.assertRegex(line, r"= [\d.e+-]+; +///< \S", "a number a line, its meaning after it")


if __name__ == "__main__":
    if sys.argv[1:] == ["--update"]:
        LIST.write_text("\n".join(lines()) + "\n", encoding="utf-8")
    else:
        unittest.main()
