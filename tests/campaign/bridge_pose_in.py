#!/usr/bin/env python3
"""Shows that a lap with camera poses from a ROS 2 topic is as good as the same lap with the camera's socket.

Two daemons play one simulated lap, with poses 30 to 120 ms late and out of order: one gets them by odom camera send, the
other by odom bridge from a publisher on Fast DDS (libfastrtps-dev; compiled here), reliable or best effort. To every
fifth pose the publisher adds a bad copy 5 m away: in another frame, or stamped 0, ahead of now or yesterday. Every bad
copy must be refused, every good pose taken, and the position's rms be within 10 % of the other daemon's, from 2 s on.
"""
import csv
import json
import math
import pathlib
import struct
import subprocess
import time

import bridge_fastdds
import common

domain, second = "98", 1_000_000_000


def message(stamp: int, frame: str, pose: list[float], sigmas: list[float]) -> str:
    """A PoseWithCovarianceStamped as CDR: little-endian, each number aligned to its size."""
    data = struct.pack("<iII", stamp // second, stamp % second, len(frame) + 1) + frame.encode() + b"\0"
    (x, y, yaw), (xx, yy, turn) = pose, (sigma * sigma for sigma in sigmas)
    numbers = struct.pack("<43d", x, y, 0.1, 0, 0, math.sin(yaw / 2), math.cos(yaw / 2), xx, *[0] * 6, yy, *[0] * 27, turn)
    return (b"\0\1\0\0" + data + bytes(-len(data) % 8) + numbers).hex()


def schedule(camera: list[dict[str, str]], offset: int) -> list[str]:
    """Lines for the publisher. `offset`: log clock - CLOCK_MONOTONIC."""
    realtime = time.clock_gettime_ns(time.CLOCK_REALTIME) - time.monotonic_ns()
    lines = []
    for i, row in enumerate(camera):
        due = round(second * float(row["t_arrival"])) - offset
        stamp = round(second * float(row["t_capture"])) - offset + realtime
        x, y, yaw, *sigmas = (float(row[name]) for name in ("x", "y", "yaw", "sigma_x", "sigma_y", "sigma_yaw"))
        lines.append(f"{due} {message(stamp, 'world', [x, y, yaw], sigmas)}")
        if i % 5 == 0:
            bad = [stamp, 0, stamp + second, stamp - 86400 * second][i // 5 % 4]
            lines.append(f"{due} {message(bad, 'map' if bad == stamp else 'world', [x + 5.0, y, yaw], sigmas)}")
    return lines


def drive(folder: pathlib.Path, programs: pathlib.Path, quality: str) -> str:
    odom, lap = programs / "odom", folder / "lap"
    camera = list(csv.DictReader((lap / "camera.csv").read_text(encoding="ascii").splitlines()))
    ways = [folder / f"socket-{quality}", folder / f"dds-{quality}"]
    bridge = subprocess.Popen([odom, "bridge", "--pose-topic", "/mocap/car/pose", "--pose-frame", "world", "--pose-sigma",
                               "0.001,0.001,0.001", "--no-publish", "--socket", ways[1] / "camera.sock", "--domain",
                               domain, "--json"], stdout=subprocess.PIPE, text=True)
    publisher = subprocess.Popen([folder / "node", domain, "rt/mocap/car/pose",
                                  "geometry_msgs::msg::dds_::PoseWithCovarianceStamped_", quality],
                                 stdin=subprocess.PIPE, text=True)
    time.sleep(3)  # for discovery: messages sent before are lost
    started = []
    for way in ways:
        way.mkdir()
        started += [subprocess.Popen([programs / "odomd", "--config", lap / "car.toml", "--can", lap / "drive.log",
                                      "--exit-at-end", "--runtime-directory", way, "--log-level", "error"]),
                    subprocess.Popen([odom, "pose", "--shm", way / "pose", "--wait", "10", "--follow", "--csv", "--clock",
                                      "log", "--until-stale"], stdout=open(way / "pose.csv", "w"), stderr=subprocess.DEVNULL)]
    started.append(subprocess.Popen([odom, "camera", "send", "--log", lap / "camera.csv", "--wait", "10", "--socket",
                                     ways[0] / "camera.sock", "--shm", ways[0] / "pose"], stderr=subprocess.DEVNULL))
    offset = 0
    while offset == 0:  # wait until the daemon plays its log
        status = subprocess.run([odom, "status", "--json", "--socket", ways[1] / "status.sock"], capture_output=True)
        offset = json.loads(status.stdout)["clock"]["log_offset_ns"] if status.returncode == 0 else 0
    lines = schedule(camera, offset)
    try:
        publisher.communicate("\n".join(lines), timeout=120)
        for process in started:
            process.wait(timeout=30)
    finally:
        bridge.terminate()
    received = json.loads(bridge.communicate(timeout=30)[0])["input"]
    refused, bad = sum(count for name, count in received.items() if name.startswith("refused")), len(lines) - len(camera)
    evaluated = common.evaluate(odom, lap, [way / "pose.csv" for way in ways], "--align", "none", "--from", "+2")
    rms = [1e3 * estimate["position"]["rms"] for estimate in evaluated]
    result = (f"{quality}: {received['sent']} of {len(camera)} poses taken, {refused} of {bad} bad ones refused; position "
              f"rms {rms[1]:.2f} mm, by the socket {rms[0]:.2f} mm")
    if (received["sent"], refused) != (len(camera), bad) or abs(rms[1] / rms[0] - 1) > 0.1:
        raise common.Failed(result)
    return result


def main() -> None:
    programs = common.parse(common.parser(__doc__, jobs=False, programs=("odom", "odomd"))).bin
    with common.scratch() as folder:
        bridge_fastdds.compile_node(folder)
        common.run(programs / "odom", "sim", "--scenario", "lap", "--laps", "1", "--camera-latency-max", "0.12",
                   "--out", folder / "lap")
        for quality in ("reliable", "best_effort"):
            print(f"{common.BEGUN:%F} {common.NAME}:", drive(folder, programs, quality), flush=True)


if __name__ == "__main__":
    common.main(main)
