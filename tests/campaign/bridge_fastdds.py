#!/usr/bin/env python3
"""Checks that Fast DDS, the middleware of most ROS 2 installations, receives what odom bridge publishes.

odomd plays a simulated lap, odom bridge publishes every second tick by DDS and as JSON over UDP. A reader on Fast DDS
(libfastrtps-dev; compiled here) subscribes with a ROS 2 node's quality of service. Every message is decoded by the
definitions of nav_msgs/Odometry and tf2_msgs/TFMessage and compared, number by number, with its stamp's datagram.
"""
import json
import math
import os
import pathlib
import socket
import struct
import subprocess
import threading
import time

import common

domain = "97"
Sample = dict[str, dict[str, float]]  # the checked part of a tick's JSON


class Cdr:
    """Reads a little-endian CDR (XCDR1), one member after the other."""

    def __init__(self, payload: bytes) -> None:
        if payload[:2] != b"\0\1":
            raise ValueError(f"encapsulation {payload[:4].hex()}")
        self.data, self.at = payload[4:], 0

    def number(self, form: str) -> float:
        size = struct.calcsize(form)
        self.at += -self.at % size
        self.at += size
        return float(struct.unpack_from("<" + form, self.data, self.at - size)[0])

    def numbers(self, count: int) -> list[float]:
        return [self.number("d") for _ in range(count)]

    def text(self) -> str:
        length = int(self.number("I"))
        self.at += length
        return self.data[self.at - length:self.at - 1].decode()

    def header(self) -> tuple[int, str]:
        second, nanosecond = int(self.number("i")), int(self.number("I"))
        return second * 1_000_000_000 + nanosecond, self.text()

    def end(self) -> None:
        if self.at != len(self.data):
            raise ValueError(f"{len(self.data) - self.at} bytes are left")


def yaw_of(quaternion: list[float]) -> float:
    x, y, z, w = quaternion
    assert x == 0 and y == 0 and abs(z * z + w * w - 1) < 1e-12
    return 2 * math.atan2(z, w)


def same_turn(a: float, b: float) -> bool:
    return abs(math.remainder(a - b, 2 * math.pi)) < 1e-9


def check_odometry(payload: bytes, expected: dict[int, Sample]) -> None:
    cdr = Cdr(payload)
    stamp, frame = cdr.header()
    assert (frame, cdr.text()) == ("odom", "base_link")
    pose, velocity = expected[stamp]["odom"], expected[stamp]["velocity"]
    assert cdr.numbers(3) == [pose["x"], pose["y"], 0]
    assert same_turn(yaw_of(cdr.numbers(4)), pose["yaw"])
    covariance = cdr.numbers(36)
    sigma, off = expected[stamp]["sigma"], expected[stamp]["covariance"]
    turn = pose["yaw"] - expected[stamp]["map"]["yaw"]
    c, s = math.cos(turn), math.sin(turn)
    xx, xy, yy = sigma["x"] ** 2, off["xy"], sigma["y"] ** 2
    wanted = {(0, 0): c * c * xx - 2 * c * s * xy + s * s * yy, (0, 1): c * s * (xx - yy) + (c * c - s * s) * xy,
              (1, 1): s * s * xx + 2 * c * s * xy + c * c * yy, (5, 5): sigma["yaw"] ** 2,
              (0, 5): c * off["xyaw"] - s * off["yyaw"], (1, 5): s * off["xyaw"] + c * off["yyaw"]}
    for (row, column), value in wanted.items():
        for got in (covariance[6 * row + column], covariance[6 * column + row]):
            assert math.isclose(got, value, rel_tol=1e-6, abs_tol=1e-12), (row, column, got, value)
    assert [covariance[7 * i] for i in (2, 3, 4)] == [1e6] * 3
    assert cdr.numbers(6) == [velocity["x"], velocity["y"], 0, 0, 0, velocity["yaw"]]
    twist = cdr.numbers(36)
    for i, name in ((0, "x"), (1, "y"), (5, "yaw")):
        assert math.isclose(twist[7 * i], expected[stamp]["velocity_sigma"][name] ** 2, rel_tol=1e-6, abs_tol=1e-15)
    cdr.end()


def check_transforms(payload: bytes, expected: dict[int, Sample]) -> None:
    cdr = Cdr(payload)
    assert cdr.number("I") == 2
    found = {}
    for _ in range(2):
        stamp, parent = cdr.header()
        child = cdr.text()
        x, y, z = cdr.numbers(3)
        found[parent, child] = (x, y, yaw_of(cdr.numbers(4)))
        assert z == 0
    cdr.end()
    odom, pose = expected[stamp]["odom"], expected[stamp]["map"]
    x, y, yaw = found["odom", "base_link"]
    assert (x, y) == (odom["x"], odom["y"]) and same_turn(yaw, odom["yaw"])
    at_x, at_y, turn = found["map", "odom"]  # their composition is the pose in the map
    assert math.isclose(at_x + math.cos(turn) * x - math.sin(turn) * y, pose["x"], abs_tol=1e-9)
    assert math.isclose(at_y + math.sin(turn) * x + math.cos(turn) * y, pose["y"], abs_tol=1e-9)
    assert same_turn(turn + yaw, pose["yaw"])


def listen(receiver: socket.socket, expected: dict[int, Sample], end: threading.Event) -> None:
    while not end.is_set():
        try:
            datagram = receiver.recv(65536)
        except TimeoutError:
            continue
        stamp = datagram.split(b":", 2)[1].split(b",")[0].decode()  # as text: a double has too few digits
        expected[int(stamp.replace(".", ""))] = json.loads(datagram)["odomd"]


def compile_node(folder: pathlib.Path) -> pathlib.Path:
    source = pathlib.Path(__file__).with_name("fastdds_node.cpp")
    common.run("g++", "-std=c++20", "-O1", source, "-o", folder / "node", "-lfastrtps", "-lfastcdr")
    return folder / "node"


def run(folder: pathlib.Path, programs: pathlib.Path, seconds: int) -> str:
    odom, reader = programs / "odom", compile_node(folder)
    common.run(odom, "sim", "--duration", seconds + 5, "--out", folder / "lap")
    receiver = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    receiver.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
    receiver.bind(("127.0.0.1", 0))
    receiver.settimeout(0.2)
    expected: dict[int, Sample] = {}
    end = threading.Event()
    listener = threading.Thread(target=listen, args=(receiver, expected, end))
    listener.start()
    environment = {name: value for name, value in os.environ.items() if name != "CYCLONEDDS_URI"}
    bridge = subprocess.Popen([odom, "bridge", "--ros", "--domain", domain, "--udp",
                               f"127.0.0.1:{receiver.getsockname()[1]}", "--shm", folder / "pose", "--rate", "100",
                               "--duration", str(seconds + 4), "--json"], stdout=subprocess.PIPE, text=True,
                              env=environment)
    with open(folder / "samples", "w", encoding="ascii") as samples:
        read = subprocess.Popen([reader, domain, str(seconds + 6)], stdout=samples)
    time.sleep(3)  # for discovery: messages sent before are lost
    daemon = subprocess.Popen([programs / "odomd", "--config", folder / "lap/car.toml", "--can",
                               folder / "lap/drive.log", "--runtime-directory", folder, "--log-level", "error"])
    try:
        sent = json.loads(bridge.communicate(timeout=seconds + 30)[0])
        read.wait(timeout=seconds + 30)
    finally:
        daemon.terminate()
        daemon.wait()
        end.set()
        listener.join()
    by_dds = next(sink["sent"] for sink in sent["sinks"] if sink["name"].startswith("dds"))
    received = {"rt/odom": 0, "rt/tf": 0}
    for line in (folder / "samples").read_text(encoding="ascii").splitlines():
        topic, payload = line.split()
        (check_odometry if topic == "rt/odom" else check_transforms)(bytes.fromhex(payload), expected)
        received[topic] += 1
    result = f"{by_dds} sent, {received['rt/odom']} of /odom and {received['rt/tf']} of /tf received and right"
    if by_dds == 0 or set(received.values()) != {by_dds}:
        raise common.Failed(result)
    return result


def main() -> None:
    made = common.parser(__doc__, jobs=False, programs=("odom", "odomd"))
    made.add_argument("--seconds", type=int, default=10, metavar="N", help="of the drive; default: 10")
    given = common.parse(made)
    with common.scratch() as folder:
        print(f"{common.BEGUN:%F} {common.NAME}:", run(folder, given.bin, given.seconds))


if __name__ == "__main__":
    common.main(main)
