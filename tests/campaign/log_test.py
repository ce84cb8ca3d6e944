#!/usr/bin/env python3
"""The log of looks at the judged drives, with made-up results: a row is appended, the tables are replaced."""

import contextlib
import io
import os
import pathlib
import sys
import tempfile
import unittest
from unittest import mock

import drives
import init
import without_truth
from recorded import log, measure

PAGE = f"# Looks\n\n{log.HEADER}| 2026-01-01 00:00 | abc | all | before: x | good |\n{log.NEWEST}\nold tables\n"


def figures(scale: float) -> measure.Figures:
    return {"heading_rms_deg": scale, "position_rms_m": scale / 10, "error_35ms_mm": 1.0}


def made_up(_odom, parts, models, _jobs):
    """The errors of the first part are 1, of the second 2, ...; inertial's are half of that."""
    return [measure.Row(part, model, figures((i + 1) / (2 if model == "inertial" else 1)), "")
            for i, part in enumerate(parts) for model in models]


def compared(_odom, _folder, part, _recorded):
    yield without_truth.line(part.name, "camera", "full", 1.0, 1.3, True)
    if part == measure.JUDGED[1]:
        raise measure.Failed("broken off")


def cells(row: str) -> list[str]:
    return [cell.strip() for cell in row.strip("|").split("|")]


def table(text: str) -> list[str]:
    return [line for line in text.partition(log.NEWEST)[0].splitlines() if line.startswith("| 20")]


class Log(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.page = pathlib.Path(folder.name) / "judged.md"
        self.page.write_text(PAGE, encoding="utf-8")
        (self.page.parent / "odom").symlink_to("/bin/true")
        for part in measure.JUDGED:
            (self.page.parent / part.drive).mkdir()
            (self.page.parent / part.drive / "camera.csv").touch()

    def run_campaign(self, campaign, *options: str) -> int:
        words = [campaign.__name__, *options, "--log", str(self.page), "--bin", str(self.page.parent)]
        with mock.patch.object(sys, "argv", words), mock.patch.dict(os.environ, ODOMD_DRIVES=str(self.page.parent)), \
                contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            return campaign.main()

    def newest_row(self) -> list[str]:
        return cells(table(self.page.read_text(encoding="utf-8"))[-1])

    def test_a_look_appends_a_row_and_replaces_the_tables(self):
        with mock.patch.object(measure, "measure", made_up):
            self.assertEqual(self.run_campaign(drives, "--judge"), 0)
        text = self.page.read_text(encoding="utf-8")
        self.assertTrue(text.startswith(PAGE.partition(log.NEWEST)[0]))
        self.assertEqual(len(table(text)), 2)
        self.assertEqual(self.newest_row()[2:4], ["`drives.py --judge`", log.UNSAID])
        # Parts 10 to 17 are judged; in made_up() even the last, revs_250lm, has a heading.
        self.assertTrue(self.newest_row()[4].startswith(
            "heading 13.5° median, 17.0° worst (revs_250lm, second half); position 1.35 m median, 1.70 m worst "
            "(revs_250lm, second half); at most 1.05: 8 of 24 cells, 33 %; above 1.3: dart_circles1 heading 2.00, "))
        self.assertNotIn("old tables", text)
        self.assertIn("| dart_circles1 | full | 10.0 | 1.00 | 1.00 |", text.partition(log.NEWEST)[2])
        self.assertNotIn("Training drives\n", text)

    def test_a_look_at_some_drives_says_so(self):
        with mock.patch.object(measure, "measure", made_up):
            self.run_campaign(drives, "--judge", "--only", "rav4", "--model", "paper")
        self.assertEqual(self.newest_row()[2], "`drives.py --judge` --only rav4 --model paper")

    def test_training_logs_nothing(self):
        with mock.patch.object(measure, "measure", made_up):
            self.run_campaign(drives, "--training")
        self.assertEqual(self.page.read_text(encoding="utf-8"), PAGE)

    def test_a_look_that_is_broken_off_is_logged(self):
        with mock.patch.object(without_truth, "compare", compared), self.assertRaises(measure.Failed):
            self.run_campaign(without_truth, "--judged")
        self.assertEqual(self.newest_row()[2], "`without_truth.py --judged`, dart_circles1, dart_free2")
        self.assertIn("camera 1.30 to 1.30; off by more than 25 %: dart_circles1 camera full 1.30, ",
                      self.newest_row()[4])
        self.assertTrue(self.page.read_text(encoding="utf-8").endswith(f"{log.NEWEST}\nold tables\n"))

    def test_init_logs_its_look(self):
        def compare(_odom, _folder, part, _recorded):
            worse = 1.2 if part == measure.JUDGED[0] else 0.9
            yield from init.compare_errors(part.name, {"position [m]": 1.0}, {"position [m]": worse})
            other = {"yaw_rate": {"message": "M", "signals": ["A"], "sure": False}}
            yield from init.compare_roles(part.name, {"yaw_rate": {"message": "M", "signal": "B"}}, other)
        with mock.patch.object(init, "compare", compare):
            self.assertEqual(self.run_campaign(init, "--judged"), 1)
        self.assertTrue(self.newest_row()[4].startswith(
            "init / by hand: position [m] 0.90 to 1.20; above 1.1: dart_circles1 position [m] 1.20; other roles: "
            "dart_circles1 yaw_rate (unsure), "))

    def test_the_page_says_what_each_look_changed(self):
        rows = [cells(row) for row in table(measure.LOG.read_text(encoding="utf-8"))]
        self.assertGreaterEqual(len(rows), 30)
        for row in rows:
            self.assertEqual(len(row), 5, row)
            self.assertNotIn("", row)
            self.assertNotEqual(row[3], log.UNSAID, row)
        days = [row[0][:10] for row in rows]
        self.assertEqual(days, sorted(days))


if __name__ == "__main__":
    unittest.main()
