"""The controllers survive the daemon: they stop after kill -9, and continue with the next daemon."""

from __future__ import annotations

import time
import unittest
from collections.abc import Callable

import support
from clients import Controller, Row, programs

COMMANDING = ("drive", "degraded")


class Restart(unittest.TestCase):
    def setUp(self) -> None:
        self.directory = support.Directory()
        self.addCleanup(self.directory.remove)

    def daemon(self) -> support.Daemon:
        daemon = support.Daemon(self.directory.path, self.drive)
        self.addCleanup(daemon.kill)
        return daemon

    def await_row(self, begin: dict[str, int], fits: Callable[[Row], bool], what: str) -> dict[str, Row]:
        """Each controller's first row that fits, from row `begin` on."""
        found = {}
        for controller in self.controllers:
            rows: list[Row] = []

            def is_there() -> bool:
                self.assertTrue(controller.is_running(), controller.describe())
                rows[:] = [row for row in controller.rows()[begin[controller.name] :] if fits(row)]
                return bool(rows)

            support.await_(is_there, lambda: f"{what}: {controller.describe()}")
            found[controller.name] = rows[0]
        return found

    def count(self) -> dict[str, int]:
        return {controller.name: len(controller.rows()) for controller in self.controllers}

    def test_all_go_on_by_themselves(self) -> None:
        self.drive = support.simulate(self.directory.path)
        # The controllers start first: they wait for the daemon.
        arguments = [
            *("--path", str(self.drive / "truth.csv")),
            *("--shm", str(self.directory.path / "pose")),
            # The sigmas do not matter here: without a camera they grow, also during the gap.
            *("--max-sigma", "100", "--max-sigma-yaw", "100"),
        ]
        self.controllers = [Controller(n, self.directory.path, arguments) for n in programs()]
        for controller in self.controllers:
            self.addCleanup(controller.kill)
            support.await_(lambda: "waiting" in controller.errors(), controller.describe)

        daemon = self.daemon()
        before = self.await_row(
            dict.fromkeys(programs(), 0),
            lambda row: row.state in COMMANDING and row.speed > 0.0,
            "a command",
        )
        instances = {row.instance for row in before.values()}
        self.assertEqual(len(instances), 1)

        for life in range(2):
            begin = self.count()
            killed = time.monotonic()
            daemon.kill()
            silent = self.await_row(begin, lambda row: row.state == "silent", "to stop")
            for row in silent.values():
                self.assertEqual((row.steering, row.speed), (0.0, 0.0))
            resets = {name: row.reset_count for name, row in silent.items()}

            begin = self.count()
            daemon = self.daemon()
            after = self.await_row(
                begin,
                lambda row: row.state in COMMANDING and row.instance not in instances,
                "to go on",
            )
            took = time.monotonic() - killed
            for name, row in after.items():
                # A daemon resumes from a pose younger than two seconds and increments its reset
                # count; on a slower machine the count begins again.
                allowed = [resets[name] + 1] if took < 1.0 else [resets[name] + 1, 1]
                self.assertIn(row.reset_count, allowed, name)
            instances |= {row.instance for row in after.values()}
            self.assertEqual(len(instances), life + 2)


if __name__ == "__main__":
    unittest.main()
