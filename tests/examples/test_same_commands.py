"""The controllers in C, C++ and Python give the same commands for the same poses."""

from __future__ import annotations

import math
import subprocess
import unittest

import support
from clients import Controller, Row, programs

RADIUS = 2.0  # m, radius of the path, a circle around (0, RADIUS)
PERIOD = 0.5  # s: long, so that on a busy machine the daemon does not seem silent


class SameCommands(unittest.TestCase):
    def setUp(self) -> None:
        self.directory = support.Directory()
        self.addCleanup(self.directory.remove)
        self.shm = self.directory.path / "pose"
        self.path = self.directory.path / "path.csv"
        angles = [i * 0.02 for i in range(round(2 * math.pi / 0.02))]
        rows = [f"{RADIUS * math.sin(a)!r},{RADIUS - RADIUS * math.cos(a)!r}" for a in angles]
        self.path.write_text("x,y\n" + "\n".join(rows) + "\n")
        self.controllers: list[Controller] = []
        self.first = 0

    def start(self, segment: support.Segment, *arguments: str) -> None:
        """Starts all three; returns once each has answered a pose. The test's ticks count from `first`."""
        for name in programs():
            controller = Controller(
                name,
                self.directory.path,
                ["--path", str(self.path), "--shm", str(self.shm), *arguments],
            )
            self.addCleanup(controller.kill)
            self.controllers.append(controller)

        def have_begun() -> bool:
            self.first += 1
            segment.publish(tick=self.first, mode=0)
            return all(any(row.tick > 0 for row in c.rows()) for c in self.controllers)

        support.await_(have_begun, lambda: "; ".join(c.describe() for c in self.controllers))

    def segment(self) -> support.Segment:
        segment = support.Segment(self.shm, PERIOD)
        self.addCleanup(segment.kill)
        return segment

    def publish(self, segment: support.Segment, tick: int, **fields: float) -> None:
        """Publishes one pose; returns once all have answered it."""
        segment.publish(tick=self.first + tick, **fields)
        for controller in self.controllers:
            support.await_(
                lambda: any(row.tick == self.first + tick for row in controller.rows()[-20:]),
                controller.describe,
            )

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
        segment = self.segment()
        self.start(segment)
        self.publish(segment, 1, mode=0)
        self.publish(segment, 2, mode=1, **self.on_circle(0.0))
        self.publish(segment, 3, **self.on_circle(0.1, left=0.3))
        self.publish(segment, 4, **self.on_circle(0.2, turned=-0.2))
        self.publish(segment, 5, mode=3, **self.on_circle(0.3))
        self.publish(segment, 6, mode=5)
        self.publish(segment, 7, mode=2, **self.on_circle(0.4, left=1.5))
        self.publish(segment, 8, reset_count=1, **self.on_circle(2.5, left=-0.2))
        for tick in range(20, 80):  # almost a whole round, across the end of the closed path
            angle = 2.5 + 0.1 * (tick - 20)
            self.publish(
                segment, tick, **self.on_circle(angle, 0.3 * math.sin(angle), 0.2 * math.cos(angle))
            )

        rows = self.agreed()
        self.assertGreater(len(rows), 40)
        expected = {
            1: "initialising",
            2: "drive",
            3: "drive",
            4: "drive",
            5: "degraded",
            6: "fault",
            7: "lost",
            8: "drive",
        }
        for tick, state in expected.items():
            if tick in rows:
                self.assertEqual(rows[tick].state, state, rows[tick])
                if state not in ("drive", "degraded"):
                    self.assertEqual(rows[tick][2:5], (0.0, 0.0, 0.0))
        self.assertEqual({row.speed for row in rows.values()}, {0.0, 0.5, 1.0})
        # In 20 ms at 1 m/s the tangent leaves a circle of 2 m radius by less than a millimetre.
        for tick, distance in ((2, 0.0), (3, 0.3), (8, -0.2)):
            if tick in rows:
                self.assertAlmostEqual(rows[tick].cross_track, distance, delta=0.02)
        # Left of the path they steer right, and against a heading error.
        steering = {tick: rows[tick].steering for tick in (2, 3, 4, 8) if tick in rows}
        self.assertLess(steering.get(3, -1.0), steering.get(2, 0.0))
        self.assertGreater(steering.get(4, 1.0), steering.get(2, 0.0))
        self.assertGreater(steering.get(8, 1.0), 0.0)

    def test_a_pose_beyond_the_lane_stops_them_in_every_mode(self) -> None:
        segment = self.segment()
        self.start(segment, "--max-sigma", "0.5", "--max-sigma-yaw", "0.1")
        sure = {"variance_x": 0.01, "variance_y": 0.01, "variance_yaw": 0.0001}
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
        for tick, (_, fields) in enumerate(poses, start=1):
            here = self.on_circle(0.02 * tick, left=0.1)
            self.publish(segment, tick, **{"covariance_xy": 0.0, **sure, **here, **fields})

        rows = self.agreed()
        self.assertGreater(len(rows), len(poses) // 2)
        for tick, (state, _) in enumerate(poses, start=1):
            if tick not in rows:
                continue
            self.assertEqual(rows[tick].state, state, rows[tick])
            if state == "uncertain":
                self.assertEqual(rows[tick][2:5], (0.0, 0.0, 0.0))

    def test_they_stop_where_nobody_says_how_wide_the_lane_is(self) -> None:
        segment = self.segment()
        self.start(segment)
        self.publish(segment, 1, mode=3, **self.on_circle(0.1), variance_x=0.25**2)
        self.publish(segment, 2, mode=3, **self.on_circle(0.1), variance_x=0.35**2)
        self.publish(segment, 3, mode=3, **self.on_circle(0.1), variance_x=0.0, variance_yaw=0.25**2)
        expected = {1: "degraded", 2: "uncertain", 3: "uncertain"}
        for tick, row in self.agreed().items():
            self.assertEqual(row.state, expected[tick], row)

    def test_an_open_path_with_speeds_ends(self) -> None:
        self.path.write_text("speed,x,y\n0.0,0,0\n0.5,0,0\n0.75,1,0\n1.0,2,0\n")
        segment = self.segment()
        self.start(segment, "--delay", "0.1")
        self.publish(segment, 1, mode=1, x=-0.2, vx=1.0)
        self.publish(segment, 2, x=0.7)
        self.publish(segment, 3, x=2.0)
        expected = {1: ("drive", 0.5), 2: ("drive", 0.75), 3: ("arrived", 0.0)}
        for tick, row in self.agreed().items():
            self.assertEqual((row.state, row.speed), expected[tick])

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
