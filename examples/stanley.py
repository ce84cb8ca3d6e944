#!/usr/bin/env python3
"""A path-following controller that uses odomd's pose, in Python: what to check before steering.

  stanley.py --path FILE [--shm NAME] [--cycles N] [--delay S] [--speed V]
             [--max-sigma M] [--max-sigma-yaw RAD]

For each pose it prints one command:
  tick,state,steering,speed,cross_track,reset_count,instance        [rad, m/s, m]
A car would send steering and speed to its actuators instead. The path is a CSV file with the
columns x and y and, optionally, speed or vx, such as truth.csv of `odom sim`.

Stanley's law steers the front axle onto the path. It uses the pose predicted to the time at which
the steering will have moved:  steering = heading error - atan(gain * cross_track / speed).
"""

from __future__ import annotations

import argparse
import csv
import math
import sys
import time
from typing import NamedTuple

import odom

GAIN = 2.0  # 1/s
SOFTENING = 0.5  # m/s, added to the speed: smoother steering when slow
MAX_STEERING = 0.4  # rad
MAX_DISTANCE = 1.0  # m from the path; above it, the car is lost
MIN_SPACING = 0.02  # m between points
CLOSING_GAP = 0.5  # m from end to start; below it, the path is a loop
DEGRADED_PART = 0.5  # fraction of the speed while the pose is degraded
# Stop above these sigmas: the car may have left its lane.
LANE_SIGMA = 0.3  # m, --max-sigma: the lane has 3 sigma on each side
LANE_SIGMA_YAW = 0.2  # rad, --max-sigma-yaw
POINTS_BEHIND = 10  # of the path, searched in every cycle
POINTS_AHEAD = 50


class Point(NamedTuple):
    x: float
    y: float
    yaw: float
    speed: float


class Path(NamedTuple):
    points: list[Point]
    closed: bool


class Command(NamedTuple):
    state: str = "silent"  # by default no fresh pose: zero steering and speed
    steering: float = 0.0
    speed: float = 0.0
    cross_track: float = 0.0


def distance(a: Point, b: Point) -> float:
    return math.sqrt((a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y))


def read_path(name: str, speed: float) -> Path:
    """Leaves out rows of a stationary car, and rows too close to the one before."""
    points: list[Point] = []
    with open(name, newline="", encoding="utf-8") as file:
        rows = csv.DictReader(file)
        columns = rows.fieldnames or []
        if "x" not in columns or "y" not in columns:
            raise ValueError(f"{name}: the first line has no columns x and y")
        v = next((column for column in ("speed", "vx") if column in columns), None)
        for row in rows:
            try:
                p = Point(float(row["x"]), float(row["y"]), 0.0, float(row[v]) if v else speed)
            except (TypeError, ValueError):
                p = Point(math.nan, math.nan, 0.0, speed)
            if not all(map(math.isfinite, p)):
                raise ValueError(f"{name}: a row lacks a number")
            if p.speed >= 0.1 and (not points or distance(p, points[-1]) >= MIN_SPACING):
                points.append(p)
    if len(points) < 2:
        raise ValueError(f"{name}: a path needs two points")
    yaws = [math.atan2(b.y - a.y, b.x - a.x) for a, b in zip(points, points[1:])]
    yaws.append(yaws[-1])
    points = [p._replace(yaw=yaw) for p, yaw in zip(points, yaws)]
    return Path(points, distance(points[0], points[-1]) < CLOSING_GAP)


def nearest(path: Path, at: Point, last: int | None) -> int:
    """The point of the path nearest to `at`: around the last one, or everywhere if there is none."""
    count = len(path.points)
    if last is None or count <= POINTS_BEHIND + POINTS_AHEAD:
        near = range(count)
    elif path.closed:
        near = range(last - POINTS_BEHIND, last + POINTS_AHEAD)
    else:
        near = range(max(0, last - POINTS_BEHIND), min(count, last + POINTS_AHEAD))
    return min(near, key=lambda i: distance(path.points[i % count], at)) % count


def is_known(pose: odom.Pose, sigmas: tuple[float, float]) -> bool:
    """Whether the pose is certain enough to keep the lane."""
    try:
        return pose.position_sigma <= sigmas[0] and math.sqrt(pose.covariance[5]) <= sigmas[1]
    except ValueError:  # a negative variance
        return False


def follow(path: Path, last: int | None, pose: odom.Pose, front_axle: float) -> tuple[int, Command]:
    front = Point(
        pose.x + front_axle * math.cos(pose.yaw),
        pose.y + front_axle * math.sin(pose.yaw),
        pose.yaw,
        pose.vx,
    )
    here = nearest(path, front, last)
    p = path.points[here]
    if not path.closed and here == len(path.points) - 1:
        return here, Command("arrived")
    if not distance(p, front) <= MAX_DISTANCE:
        return here, Command("lost")

    # Positive if the front axle is to the left of the path.
    cross_track = math.cos(p.yaw) * (front.y - p.y) - math.sin(p.yaw) * (front.x - p.x)
    heading_error = math.remainder(p.yaw - front.yaw, 2.0 * math.pi)
    steering = heading_error - math.atan2(GAIN * cross_track, SOFTENING + abs(front.speed))
    steering = max(-MAX_STEERING, min(MAX_STEERING, steering))
    if pose.mode == odom.Mode.DEGRADED:  # a condition bit shows why: drive carefully
        return here, Command("degraded", steering, DEGRADED_PART * p.speed, cross_track)
    return here, Command("drive", steering, p.speed, cross_track)


def open_client(name: str | None) -> odom.Client:
    while True:  # the daemon may start later
        try:
            return odom.Client(name)
        except odom.OdomError as error:
            print(f"stanley: waiting: {error}", file=sys.stderr, flush=True)
            time.sleep(0.2)


def control(
    path: Path, shm: str | None, cycles: int, delay_ns: int, sigmas: tuple[float, float]
) -> None:
    client = open_client(shm)
    info = client.info()
    pose: odom.Pose | None = None
    last: int | None = None  # index on the path
    print("tick,state,steering,speed,cross_track,reset_count,instance", flush=True)
    while cycles != 0:
        cycles -= cycles > 0
        before = (info.instance_id, pose.reset_count if pose else 0)
        command = Command()
        try:
            pose, fresh = client.wait(pose, timeout=10 * info.period_ns * 1e-9), True
        except odom.StaleError as stale:
            pose, fresh = stale.pose, False
        except odom.OdomError:
            fresh = False  # no pose yet, or timed out
        info = client.info()
        # After a restart or a jump of the map pose, the car may be anywhere along the path.
        if (info.instance_id, pose.reset_count if pose else 0) != before:
            last = None

        if pose is None or not fresh:
            last = None  # the client re-attaches by itself
        elif pose.mode in (odom.Mode.INITIALISING, odom.Mode.FAULT):
            command = Command(pose.mode_name)
        else:
            try:
                ahead = odom.predict(pose, pose.time_ns + delay_ns)
            except odom.OdomError:
                command = Command("unpredictable")  # the delay is longer than 100 ms
            else:
                if is_known(ahead, sigmas):
                    last, command = follow(path, last, ahead, info.front_axle)
                else:  # in any mode
                    last, command = None, Command("uncertain")
        print(
            f"{pose.tick if pose else 0},{command.state},{command.steering:.4f},"
            f"{command.speed:.4f},{command.cross_track:.4f},"
            f"{pose.reset_count if pose else 0},{info.instance_id:016x}",
            flush=True,
        )


def main() -> int:
    parser = argparse.ArgumentParser(prog="stanley.py", description="Follows a path by odomd's pose.")
    parser.add_argument("--path", required=True, help="CSV with columns x, y and perhaps speed or vx")
    parser.add_argument("--shm", help="segment, default: as odomd's")
    parser.add_argument("--cycles", type=int, default=-1, help="commands to give, default: no end")
    parser.add_argument("--delay", type=float, default=0.02, help="s, pose to moved steering")
    parser.add_argument("--speed", type=float, default=1.0, help="m/s, where the path has none")
    parser.add_argument(
        "--max-sigma", type=float, default=LANE_SIGMA, help="m, of the position; beyond it: stop"
    )
    parser.add_argument(
        "--max-sigma-yaw", type=float, default=LANE_SIGMA_YAW, help="rad, of the yaw; beyond it: stop"
    )
    options = parser.parse_args()
    try:
        path = read_path(options.path, options.speed)
    except (OSError, ValueError) as error:
        print(f"stanley: {error}", file=sys.stderr)
        return 2
    try:
        sigmas = (options.max_sigma, options.max_sigma_yaw)
        control(path, options.shm, options.cycles, int(options.delay * 1e9), sigmas)
    except (BrokenPipeError, KeyboardInterrupt):
        pass
    return 0


if __name__ == "__main__":
    sys.exit(main())
