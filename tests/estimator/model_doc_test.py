"""docs/model.md: its table of tuned numbers follows the header, it and estimator/ekf name each other, and what links
into it arrives. Python's own unittest."""

import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
DOCUMENT = ROOT / "docs/model.md"
HEADER = ROOT / "estimator/common/tuning.hpp"
SCRIPT = pathlib.Path(__file__).with_name("tuning_table.py")


def headings() -> list[str]:
    return re.findall(r"^#+ (.+)$", DOCUMENT.read_text(encoding="utf-8"), re.MULTILINE)


def sections() -> list[str]:
    """Each heading and the text below it, up to the next heading."""
    return re.split(r"^#+ ", DOCUMENT.read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]


def anchor(heading: str) -> str:
    """As GitHub makes it."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def run(*arguments: object) -> subprocess.CompletedProcess:
    return subprocess.run([sys.executable, "-B", SCRIPT, *map(str, arguments)], capture_output=True, text=True)


class TuningTable(unittest.TestCase):
    def check(self, change) -> subprocess.CompletedProcess:
        """--check of the document against a header that was changed."""
        with tempfile.TemporaryDirectory() as folder:
            header = pathlib.Path(folder) / "tuning.hpp"
            header.write_text(change(HEADER.read_text(encoding="utf-8")), encoding="utf-8")
            return run("--check", "--header", header)

    def test_another_value_is_found(self):
        result = self.check(lambda text: re.sub(r"(double drive_accel = )[^;]+;", r"\g<1>0.75;", text))
        self.assertEqual(result.returncode, 1)
        self.assertIn("is not current", result.stderr)

    def test_another_unit_is_found(self):
        self.assertEqual(self.check(lambda text: text.replace("[rad/√m]", "[rad]")).returncode, 1)

    def test_a_number_more_or_less_is_found(self):
        more = "struct Tuning {\n  double more = 1.0;  ///< one more\n"
        self.assertEqual(self.check(lambda text: text.replace("struct Tuning {\n", more)).returncode, 1)
        self.assertEqual(self.check(lambda text: re.sub(r"  double turn_in .*\n", "", text)).returncode, 1)

    def test_a_number_without_a_meaning_is_an_error(self):
        result = self.check(lambda text: text.replace("};", "  double bare = 1.0;  ///\n};"))
        self.assertEqual(result.returncode, 2)
        self.assertIn("bare has no meaning", result.stderr)

    def test_what_is_no_number_is_an_error(self):
        self.assertEqual(self.check(lambda text: text.replace("};", "  bool flag = true;\n};")).returncode, 2)

    def test_it_writes_what_it_checks(self):
        with tempfile.TemporaryDirectory() as folder:
            document = pathlib.Path(folder) / "model.md"
            document.write_text(re.sub(r", `turn_in` [^|]*", "", DOCUMENT.read_text(encoding="utf-8")),
                                encoding="utf-8")
            self.assertEqual(run("--check", "--document", document).returncode, 1)
            self.assertEqual(run("--document", document).returncode, 0)
            self.assertEqual(document.read_text(encoding="utf-8"), DOCUMENT.read_text(encoding="utf-8"))

    def test_a_document_without_markers_is_an_error(self):
        self.assertEqual(run("--check", "--document", ROOT / "README.md").returncode, 2)


class Names(unittest.TestCase):
    def test_each_file_of_the_filter_names_a_section_that_names_it(self):
        for path in sorted((ROOT / "estimator/ekf").iterdir()):
            with self.subTest(path.name):
                named = re.search(r'^// docs/model\.md, "(.+)"\.$', path.read_text(encoding="utf-8"), re.MULTILINE)
                self.assertIsNotNone(named, "no line like: // docs/model.md, \"Process\".")
                found = [text for text in sections() if text.startswith(named[1] + " (")]
                self.assertEqual(len(found), 1, f"no section, or several, {named[1]}")
                self.assertRegex(found[0], rf"`ekf/{path.stem}\.[ch]pp`")

    def test_each_file_that_a_heading_names_exists(self):
        for heading in headings():
            for name in re.findall(r"`([\w/]+[/.][\w/.]*)`", heading):
                with self.subTest(name):
                    self.assertTrue(any(any((ROOT / part).rglob(pathlib.Path(name).name))
                                        for part in ("estimator", "daemon")) if "." in name
                                    else (ROOT / "estimator" / name).is_dir())

    def test_links_into_it_arrive(self):
        there = {anchor(heading) for heading in headings()}
        for page in [ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").glob("*.md"))]:
            target = r"\]\((?:docs/)?(?:model\.md)?#([^)]+)\)" if page == DOCUMENT else r"model\.md#([^)\s]+)\)"
            for link in re.findall(target, page.read_text(encoding="utf-8")):
                with self.subTest(page=page.name, link=link):
                    self.assertIn(link, there)


if __name__ == "__main__":
    unittest.main()
