"""Plain English: words that the project leaves, in names, comments, messages and pages. Python's own unittest; needs
no build.

LEFT is the one place where they are written down, each with what to write instead. Names are read word by word:
`unit_doubt` and `UnitDoubt` have the word doubt in them. Who means a word literally adds its file to MEANT.
"""

import pathlib
import re
import subprocess
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]

LEFT = {
    "tell": "report, warn, say", "tells": "reports, warns, says", "told": "reported, warned, said",
    "doubt": "warning, finding, check; uncertainty", "doubts": "warnings, findings, checks",
    "surer": "more precise",
    "beside": "compared with, than, next to",
    "mend": "fix", "mends": "fixes", "mended": "fixed",
    "vouch": "a consecutive consistent sample", "vouchers": "consecutive consistent samples",
    "testimony": "observations", "blame": "fault isolation", "blamed": "isolated",
    "insist": "rejection timeout", "insists": "rejection timeout", "patience": "rejection timeout",
    "contender": "run of rejected poses",
    "stranger": "untrusted user, unmapped id", "strangers": "unmapped ids", "aside": "nuisance parameter",
    "felt": "measured acceleration",
    "odd": "unusual",
}

# path -> the words that are meant there as they stand.
MEANT: dict[str, set[str]] = {
    "can_protocol/decode/e2e.cpp": {"odd"},
    "can_protocol/decode/e2e.hpp": {"odd"},
    "docs/can.md": {"odd"},
    "docs/identify.md": {"odd"},
    "docs/shm.md": {"odd"},
    "shm_api/layout/slot.h": {"odd"},
    "tests/fuzz/segment.cpp": {"odd"},
    "tests/shm_api/preemption.cpp": {"odd"},
    "tests/shm_api/test_ordering.cpp": {"odd"},
}

# Other people's words, and data.
NOT_READ = ("LICENSE", "tests/words/", "tests/data/", "tests/fuzz/seeds/")
READ = {".hpp", ".cpp", ".h", ".c", ".in", ".py", ".sh", ".md", ".txt", ".cmake", ".toml", ".1", ".3", ".5", ".8", ".dbc"}

WORD = re.compile(r"[A-Z]?[a-z]+")


def read_tree() -> dict[str, str]:
    """Path -> text of what is written by hand."""
    names = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True)
    return {name: (ROOT / name).read_text(encoding="utf-8") for name in names.stdout.split("\0")
            if pathlib.PurePath(name).suffix in READ and not name.startswith(NOT_READ)}


def found_in(tree: dict[str, str]) -> list[str]:
    """A line for each word that is left, and for each exception that is none."""
    found = []
    unused = {(path, word) for path, words in MEANT.items() for word in words}
    for path, text in tree.items():
        for number, line in enumerate(text.splitlines(), start=1):
            for word in WORD.findall(line):
                left = word.lower()
                if left in LEFT and left in MEANT.get(path, ()):
                    unused.discard((path, left))
                elif left in LEFT:
                    found.append(f"{path}:{number}: {left}: write {LEFT[left]}")
    return found + [f"{path} does not say {word} any more: take it out of MEANT" for path, word in sorted(unused)]


class Words(unittest.TestCase):
    def test_the_tree_is_in_plain_english(self):
        tree = read_tree()
        self.assertGreater(len(tree), 800)
        self.assertEqual(found_in(tree), [])

    def test_a_word_is_found_in_prose_and_in_names(self):
        for line in ("It tells why.", "int unit_doubt();", "struct UnitDoubt {};", "Tell me why"):
            self.assertEqual(len([f for f in found_in({"new.cpp": line}) if f.startswith("new.cpp:1: ")]), 1, line)

    def test_an_exception_that_is_none_is_found(self):
        self.assertEqual(len(found_in({})), sum(len(words) for words in MEANT.values()))
        self.assertIn("docs/shm.md does not say odd any more: take it out of MEANT", found_in({}))

    def test_a_word_inside_a_word_is_not(self):
        self.assertEqual([f for f in found_in({"new.cpp": "intelligence tellurium odometry asides"})
                          if f.startswith("new.cpp")], [])


if __name__ == "__main__":
    unittest.main()
