#!/usr/bin/env python3
"""Kills odomd with SIGKILL after 20 to 70 ms of a drive, again and again, while three readers follow the pose.

Readers must see only whole poses: on the grid of their instance, with ticks that rise, finite, with variances that are
not negative. Each reader must attach to every successor or a later one. Every successor must resume from its
predecessor's pose if that is younger than 2 s.
"""

import math
import multiprocessing
import os
import random
import signal
import subprocess
import sys
import time

import common

os.environ["ODOM_LIBRARY"] = str(common.ROOT / "build/release/lib/libodom.so.0")
sys.path.insert(0, str(common.ROOT / "python"))
import odom  # noqa: E402

READERS = 3
WAIT_S = 10.0
RESUMES_WITHIN_NS = 2_000_000_000  # docs/realtime.md, "Restart": an older pose is not resumed from


def what_is_wrong(pose, before, info):
    """The pose's inconsistency, or nothing. `before`: an earlier pose of the same instance, or None."""
    if pose.time_ns != info.first_tick_ns + pose.tick * info.period_ns:
        return "it is not on the grid of its instance"
    if before is not None and pose.tick < before.tick:
        return "its tick fell"
    numbers = [*pose.covariance, pose.x, pose.y, pose.yaw, pose.vx, pose.vy, pose.yaw_rate]
    if not all(math.isfinite(n) for n in numbers):
        return "a number is not finite"
    if min(pose.covariance[0], pose.covariance[3], pose.covariance[5]) < 0.0:
        return "a variance is below zero"
    return ""


def follow(segment, stop, answers):
    poses, instances, trouble = 0, set(), ""
    with odom.Client(segment) as client:
        pose, before = None, None
        while not stop.is_set() and not trouble:
            try:
                pose = client.wait(pose, timeout=0.05)
                info = client.info()
                pose = client.latest()
                if client.info().instance_id != info.instance_id:
                    continue  # the daemon was replaced
            except odom.OdomError:
                continue  # stale: the daemon is dead
            if info.instance_id not in instances:
                instances.add(info.instance_id)
                before = None
            trouble = what_is_wrong(pose, before, info)
            before = pose
            poses += 1
    answers.put((poses, len(instances), trouble and f"{trouble}: {pose}"))


def start(binaries, directory, frames):
    """odomd, which gets these frames from standard input."""
    with open(directory / "odomd.log", "ab") as errors:
        daemon = subprocess.Popen(
            [binaries / "odomd", "--config", directory / "drive/car.toml", "--can", "-",
             "--runtime-directory", directory],
            stdin=subprocess.PIPE, stderr=errors)
    daemon.stdin.write(frames)
    daemon.stdin.flush()
    return daemon


def first_pose_after(client, instance):
    """The first pose, with its info, of another instance than `instance`."""
    end = time.monotonic() + WAIT_S
    while time.monotonic() < end:
        try:
            before = client.info()
            pose = client.latest()
            info = client.info()
            # If the client re-attached in between, the pose may be the predecessor's.
            if info.instance_id not in (instance, 0) and info.instance_id == before.instance_id:
                return pose, info
        except odom.OdomError:
            pass
        time.sleep(0.001)
    return None, None


def main():
    made = common.parser(__doc__, jobs=False, programs=("odom", "odomd"))
    made.add_argument("--kills", type=int, default=10000, metavar="N", help="default: 10000")
    given = common.parse(made)
    kills = given.kills
    resumed = late = 0
    trouble = ""
    with common.scratch() as directory:
        common.run(given.odom, "sim", "--duration", 5, "--standstill", 0, "--out", directory / "drive")
        frames = (directory / "drive/drive.log").read_bytes()[:60000].rpartition(b"\n")[0] + b"\n"
        daemon = start(given.bin, directory, frames)
        stop, answers = multiprocessing.Event(), multiprocessing.Queue()
        while not os.path.exists(directory / "pose"):
            time.sleep(0.001)
        readers = [multiprocessing.Process(target=follow, args=(directory / "pose", stop, answers))
                   for _ in range(READERS)]
        for reader in readers:
            reader.start()
        with odom.Client(directory / "pose") as client:
            pose, info = first_pose_after(client, 0)
            while pose is not None and pose.mode == odom.Mode.INITIALISING:
                pose, info = first_pose_after(client, 0)
            for _ in range(kills):
                time.sleep(random.uniform(0.02, 0.07))
                last = pose
                try:
                    last = client.latest()
                except odom.OdomError:
                    pass
                daemon.send_signal(signal.SIGKILL)
                daemon.wait()
                daemon.stdin.close()
                daemon = start(given.bin, directory, frames)
                pose, info = first_pose_after(client, info.instance_id)
                if pose is None:
                    trouble = f"no successor publishes: {(directory / 'odomd.log').read_text()[-500:]}"
                    break
                goes_on = pose.conditions & odom.Conditions.RESTARTED
                if not goes_on and pose.time_ns - last.time_ns > RESUMES_WITHIN_NS:
                    late += 1  # on a busy machine the pose may become too old to resume from
                    continue
                if not goes_on or pose.reset_count <= last.reset_count:
                    trouble = f"a successor began anew: {last}, then {pose}"
                    break
                resumed += 1
        stop.set()
        seen = [answers.get(timeout=WAIT_S) for _ in readers]
        for reader in readers:
            reader.join()
        daemon.kill()
        daemon.wait()
    trouble = trouble or next((t for _, _, t in seen if t), "")
    if late > kills // 100:
        trouble = trouble or f"{late} successors were later than 2 s"
    if min(instances for _, instances, _ in seen) < resumed // 2:
        trouble = trouble or f"a reader stayed behind: {seen}"
    return common.last_words(
        f"{'FAILED: ' + trouble + '; ' if trouble else ''}{resumed} of {kills} kills resumed, {late} later than 2 s; "
        f"{sum(p for p, _, _ in seen)} poses read, whole, of {min(i for _, i, _ in seen)} to "
        f"{max(i for _, i, _ in seen)} instances", trouble)


if __name__ == "__main__":
    common.main(main)
