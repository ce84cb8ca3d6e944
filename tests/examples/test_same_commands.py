"""The controllers in C, C++ and Python give the same commands for the same poses."""

from __future__ import annotations

import math
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from typing import NamedTuple

import support

RADIUS = 2.0  # m, radius of the path, a circle around (0, RADIUS)
PERIOD = 0.5  # s: long, so that on a busy machine the daemon does not seem silent


class Row(NamedTuple):
    """One command, as it is printed."""

    tick: int
    state: str
    steering: float
    speed: float
    cross_track: float
    reset_count: int
    instance: str


def programs() -> dict[str, list[str]]:
    """The example in three languages; in Python only if ODOM_LIBRARY names a library that it can load."""
    examples = Path(os.environ["ODOMD_EXAMPLES_BUILT"])
    found = {"C": [str(examples / "stanley_c")], "C++": [str(examples / "stanley_cpp")]}
    if "ODOM_LIBRARY" in os.environ:
        found["Python"] = [sys.executable, "-B", os.environ["ODOMD_EXAMPLES"] + "/stanley.py"]
    return found


class Controller:
    """A running example, its output in a file."""

    def __init__(self, name: str, directory: Path, arguments: list[str]) -> None:
        self.name = name
        self._output = directory / f"{name}.csv"
        self._errors = directory / f"{name}.err"
        with open(self._output, "w") as output, open(self._errors, "w") as errors:
            self._process = subprocess.Popen(
                [*programs()[name], *arguments], stdout=output, stderr=errors
            )

    def lines(self) -> list[str]:
        """Whole lines, without the header."""
        text = self._output.read_text()
        return text[: text.rfind("\n") + 1].splitlines()[1:]

    def rows(self) -> list[Row]:
        fields = [line.split(",") for line in self.lines()]
        return [
            Row(int(f[0]), f[1], float(f[2]), float(f[3]), float(f[4]), int(f[5]), f[6])
            for f in fields
        ]

    def errors(self) -> str:
        return self._errors.read_text()

    def describe(self) -> str:
        return f"{self.name}: {self.lines()[-3:]} {self.errors()[-300:]}"

    def wait(self) -> int:
        return self._process.wait(support.TIMEOUT)

    def kill(self) -> None:
        self._process.kill()
        self._process.wait()


class SameCommands(unittest.TestCase):
    def setUp(self) -> None:
        self.directory = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.shm = self.directory / "pose"
        self.path = self.directory / "path.csv"
        angles = [i * 0.02 for i in range(round(2 * math.pi / 0.02))]
        rows = [f"{RADIUS * math.sin(a)!r},{RADIUS - RADIUS * math.cos(a)!r}" for a in angles]
        self.path.write_text("x,y\n" + "\n".join(rows) + "\n")
        self.controllers: list[Controller] = []
        self.first = 0

    def start(self, *arguments: str) -> None:
        """Starts all; returns once each has answered a pose. The test's ticks count from `first`."""
        self.open_segment()
        for name in programs():
            controller = Controller(
                name,
                self.directory,
                ["--path", str(self.path), "--shm", str(self.shm), *arguments],
            )
            self.addCleanup(controller.kill)
            self.controllers.append(controller)

        def have_begun() -> bool:
            self.first += 1
            self.segment.publish(tick=self.first, mode=0)
            return all(any(row.tick > 0 for row in c.rows()) for c in self.controllers)

        support.await_(have_begun, lambda: "; ".join(c.describe() for c in self.controllers))

    def open_segment(self) -> None:
        self.segment = support.Segment(self.shm, PERIOD)
        self.addCleanup(self.segment.kill)

    def publish(self, tick: int, **fields: float) -> None:
        """Publishes one pose; returns once all have answered it."""
        self.segment.publish(tick=self.first + tick, **fields)
        for controller in self.controllers:
            support.await_(
                lambda: any(row.tick == self.first + tick for row in controller.rows()[-20:]),
                controller.describe,
            )

    def expect(self, poses: list[tuple[str, dict[str, float]]]) -> dict[int, Row]:
        """Publishes the poses, from tick 1 on. All must agree on the state of each; returns the rows."""
        for tick, (_, fields) in enumerate(poses, start=1):
            self.publish(tick, **fields)
        rows = self.agreed()
        self.assertGreater(len(rows), len(poses) // 2)
        for tick, (state, _) in enumerate(poses, start=1):
            if tick in rows:
                self.assertEqual(rows[tick].state, state, rows[tick])
                if state not in ("drive", "degraded", "arrived"):
                    self.assertEqual(rows[tick][2:5], (0.0, 0.0, 0.0))
        return rows

    def on_circle(self, angle: float, left: float = 0.0, turned: float = 0.0) -> dict[str, float]:
        """The front axle `left` of the path at this angle, the car `turned` from the path's direction."""
        yaw = angle + turned
        front = 0.175
        return {
            "x": (RADIUS - left) * math.sin(angle) - front * math.cos(yaw),
            "y": RADIUS - (RADIUS - left) * math.cos(angle) - front * math.sin(yaw),
            "yaw": yaw,
            "vx": 1.0,
        }

    def agreed(self) -> dict[int, Row]:
        """The commands of all, by tick, except where one of them was delayed too long."""
        spoken = [
            {r.tick - self.first: line for r, line in zip(c.rows(), c.lines()) if r.tick > self.first}
            for c in self.controllers
        ]
        silent = {tick for said in spoken for tick, line in said.items() if ",silent," in line}
        first, *others = [{t: l for t, l in said.items() if t not in silent} for said in spoken]
        for other in others:
            self.assertEqual(first, other)
        return {
            r.tick - self.first: r for r in self.controllers[0].rows() if r.tick - self.first in first
        }

    def test_whatever_the_segment_says(self) -> None:
        self.start()
        self.expect(
            [
                ("initialising", {"mode": 0}),
                ("drive", {"mode": 1, **self.on_circle(0.0)}),
                ("drive", self.on_circle(0.1, left=0.3)),
                ("drive", self.on_circle(0.2, turned=-0.2)),
                ("degraded", {"mode": 3, **self.on_circle(0.3)}),
                ("fault", {"mode": 5}),
                ("lost", {"mode": 2, **self.on_circle(0.4, left=1.5)}),
                ("drive", {"reset_count": 1, **self.on_circle(2.5, left=-0.2)}),
            ]
        )
        for tick in range(20, 80):  # almost a whole round, across the end of the closed path
            angle = 2.5 + 0.1 * (tick - 20)
            self.publish(tick, **self.on_circle(angle, 0.3 * math.sin(angle), 0.2 * math.cos(angle)))

        rows = self.agreed()
        self.assertGreater(len(rows), 40)
        self.assertEqual({row.speed for row in rows.values()}, {0.0, 0.5, 1.0})
        # In 20 ms at 1 m/s the tangent leaves a circle of 2 m radius by less than a millimetre.
        for tick, distance in ((2, 0.0), (3, 0.3), (8, -0.2)):
            if tick in rows:
                self.assertAlmostEqual(rows[tick].cross_track, distance, delta=0.02)
        # The examples steer right if they are left of the path, and against a heading error.
        steering = {tick: rows[tick].steering for tick in (2, 3, 4, 8) if tick in rows}
        self.assertLess(steering.get(3, -1.0), steering.get(2, 0.0))
        self.assertGreater(steering.get(4, 1.0), steering.get(2, 0.0))
        self.assertGreater(steering.get(8, 1.0), 0.0)

    def test_a_pose_beyond_the_lane_stops_them_in_every_mode(self) -> None:
        self.start("--max-sigma", "0.5", "--max-sigma-yaw", "0.1")
        sure = {"variance_x": 0.01, "variance_y": 0.01, "variance_yaw": 0.0001, "covariance_xy": 0.0}
        poses: list[tuple[str, dict[str, float]]] = [
            ("drive", {"mode": 1}),
            ("degraded", {"mode": 3}),
            ("uncertain", {"mode": 3, "variance_y": 136.0**2}),  # after dead reckoning without a bus
            ("uncertain", {"mode": 1, "variance_x": 0.26}),
            ("drive", {"mode": 1, "variance_x": 0.24}),
            ("uncertain", {"mode": 2, "variance_yaw": 0.0101}),
            ("uncertain", {"mode": 2, "variance_x": 0.2, "variance_y": 0.2, "covariance_xy": 0.06}),
            ("drive", {"mode": 2, "variance_x": 0.2, "variance_y": 0.2, "covariance_xy": 0.04}),
            ("uncertain", {"mode": 1, "variance_x": math.nan}),
            ("uncertain", {"mode": 1, "variance_yaw": -1.0}),
            ("initialising", {"mode": 0, "variance_x": 1.0}),
            ("fault", {"mode": 5, "variance_x": 1.0}),
            ("drive", {"mode": 4}),
        ]
        self.expect(
            [
                (state, {**sure, **self.on_circle(0.02 * i, left=0.1), **fields})
                for i, (state, fields) in enumerate(poses)
            ]
        )

    def test_they_stop_where_nobody_says_how_wide_the_lane_is(self) -> None:
        self.start()
        here: dict[str, float] = {"mode": 3, **self.on_circle(0.1)}
        self.expect(
            [
                ("degraded", {**here, "variance_x": 0.25**2}),
                ("uncertain", {**here, "variance_x": 0.35**2}),
                ("uncertain", {**here, "variance_x": 0.0, "variance_yaw": 0.25**2}),
            ]
        )

    def test_an_open_path_with_speeds_ends(self) -> None:
        self.path.write_text("speed,x,y\n0.0,0,0\n0.5,0,0\n0.75,1,0\n1.0,2,0\n")
        self.start("--delay", "0.1")
        rows = self.expect(
            [
                ("drive", {"mode": 1, "x": -0.2, "vx": 1.0}),
                ("drive", {"x": 0.7}),
                ("arrived", {"x": 2.0}),
            ]
        )
        for tick, row in rows.items():
            self.assertEqual(row.speed, (0.5, 0.75, 0.0)[tick - 1])

    def test_they_stop_while_the_daemon_is_silent_and_go_on_with_the_next(self) -> None:
        self.start()
        self.publish(1, mode=1, **self.on_circle(0.1))
        self.segment.kill()
        for controller in self.controllers:
            support.await_(lambda: controller.rows()[-1].state == "silent", controller.describe)
            self.assertEqual(controller.rows()[-1][2:4], (0.0, 0.0))
        before = {controller.rows()[-1].instance for controller in self.controllers}
        self.assertEqual(len(before), 1)
        self.open_segment()
        self.publish(2, mode=1, reset_count=4, **self.on_circle(0.1))
        for controller in self.controllers:
            row = next(r for r in controller.rows() if r.tick == self.first + 2)
            self.assertEqual((row.state, row.reset_count, row.instance in before), ("drive", 4, False))

    def test_a_path_that_is_none_is_refused_in_one_line(self) -> None:
        for text in ("", "a,b\n1,2\n", "x,y\n1,2\n", "x,y\n1,2\n3,nonsense\n", "x,y\n1,2\n3\n"):
            self.path.write_text(text)
            for name, program in programs().items():
                result = subprocess.run(
                    [*program, "--path", str(self.path)],
                    capture_output=True,
                    text=True,
                    timeout=support.TIMEOUT,
                )
                self.assertEqual(result.returncode, 2, (name, text, result))
                self.assertEqual(len(result.stderr.splitlines()), 1, (name, text, result))


if __name__ == "__main__":
    unittest.main()
