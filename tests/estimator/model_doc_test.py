"""docs/model.md and estimator/ekf name each other, and links into the page have targets. Python's own unittest."""

import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
DOCUMENT = ROOT / "docs/model.md"


def headings() -> list[str]:
    return re.findall(r"^#+ (.+)$", DOCUMENT.read_text(encoding="utf-8"), re.MULTILINE)


def sections() -> list[str]:
    """Each heading and the text below it, up to the next heading."""
    return re.split(r"^#+ ", DOCUMENT.read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]


def anchor(heading: str) -> str:
    """The heading's anchor, as GitHub makes it."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


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
