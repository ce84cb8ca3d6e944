"""shown_commands.py: a page that is as shown passes; one that is not, or that shows nothing, fails."""

import os
import pathlib
import subprocess
import sys
import tempfile
import textwrap
import unittest

RUNNER = pathlib.Path(__file__).with_name("shown_commands.py")


def outcome(blocks, mark="here"):
    """(exit status, lines) of a page with these blocks."""
    text = f"<!-- shown: here -->\n```console\n{textwrap.dedent(blocks).strip()}\n```\n"
    with tempfile.TemporaryDirectory() as directory:
        page = pathlib.Path(directory) / "page.md"
        page.write_text(text)
        done = subprocess.run([sys.executable, "-B", RUNNER, page, mark], capture_output=True,
                              text=True, check=False)
    return done.returncode, done.stdout.splitlines()


class ShownCommands(unittest.TestCase):
    def test_what_is_as_shown_passes(self):
        self.assertEqual(outcome("$ echo one; echo two >&2\none\ntwo"),
                         (0, ["ok page: $ echo one; echo two >&2"]))

    def test_other_words_fail_and_are_repeated(self):
        status, lines = outcome("$ echo one\ntwo\n$ true")
        self.assertEqual(status, 1)
        self.assertEqual(lines, ["not ok page: $ echo one: printed 'one\n".rstrip(), "'",
                                 "ok page: $ true"])

    def test_every_line_counts_and_dots_stand_for_what_differs(self):
        for blocks, status in (
                ("$ echo one; echo two\none", 1),
                ("$ echo one\none\ntwo", 1),
                ("$ echo one", 1),
                ("$ echo pid 17 lives; seq 5\npid ... lives\n1\n...\n5", 0),
                ("$ echo pid 17 died\npid ... lives", 1),
                ("$ echo 1+1 is 2\n1.1 is 2", 1),
                ("$ echo one \\\n  two\none two", 0),  # the command goes on behind a backslash
                # Commands share a directory, and a command in the background delays no other.
                ("$ echo kept >file; sleep 1000 &\n$ cat file\nkept", 0)):
            with self.subTest(blocks):
                self.assertEqual(outcome(blocks)[0], status)

    def test_a_page_that_shows_nothing_fails(self):
        self.assertEqual(outcome("$ true", mark="elsewhere"),
                         (1, ["not ok page: nothing is shown: elsewhere"]))

    def test_what_no_help_has_fails(self):
        with tempfile.TemporaryDirectory() as folder:
            page, odom = pathlib.Path(folder) / "page.md", pathlib.Path(folder) / "odom"
            odom.write_text("#!/bin/sh\ncase $* in --help) printf 'Subcommands:\\n  plot  Draw\\n' ;; "
                            "'plot --help') echo '  --out A' ;; *) false ;; esac")
            odom.chmod(0o755)
            for text, unknown in (("    odom plot --out=a # --in\n`--rate`\n", ""), ("`odom plto`\n", "odom plto"),
                                  ("    : | odom plot \\\n  --rate 1\n", "odom plot --rate"), ("`--in`\n", "--in"),
                                  ('```xml\n<a cmd="odom plot --in"/>\n```\n', "odom plot --in")):
                page.write_text(text)
                done = subprocess.run([sys.executable, "-B", RUNNER, "--options", page], capture_output=True, text=True,
                                      env={**os.environ, "PATH": folder}, check=False)
                self.assertEqual(done.stderr, unknown and f"not ok {page}: {unknown}: no help has it\n\n")


if __name__ == "__main__":
    unittest.main()
