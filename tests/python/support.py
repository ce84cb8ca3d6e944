"""What the tests of clients share: a segment driven by commands, odomd on a simulated drive, and
timeouts. Timeouts are generous: machines may be slow and busy."""

from __future__ import annotations

import os
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

TIMEOUT = 60.0  # s
BIN = Path(os.environ["ODOMD_BIN"])


def await_(condition: Callable[[], object], what: Callable[[], str] = lambda: "") -> None:
    """Tries until the condition holds."""
    until = time.monotonic() + TIMEOUT
    while not condition():
        if time.monotonic() > until:
            raise AssertionError(f"waited {TIMEOUT:.0f} s in vain: {what()}")
        time.sleep(0.01)


class Segment:
    """tests/python/segment_writer: poses one by one, on the test's command."""

    def __init__(self, path: Path, period: float) -> None:
        self._process = subprocess.Popen(
            [os.environ["ODOMD_SEGMENT_WRITER"], str(path), str(round(period * 1e9))],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            bufsize=1,
        )
        self._await_ok()

    def _await_ok(self) -> None:
        assert self._process.stdout is not None
        answer = self._process.stdout.readline()
        if answer != "ok\n":
            raise AssertionError(f"segment_writer: {answer!r}")

    def send(self, command: str) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(command + "\n")
        self._process.stdin.flush()
        self._await_ok()

    def publish(self, **fields: float) -> None:
        self.send("publish " + " ".join(f"{name}={value!r}" for name, value in fields.items()))

    def silence(self) -> None:
        self.send("silence")

    def kill(self) -> None:
        """kill -9."""
        self._process.kill()
        self._process.communicate()


class Daemon:
    """odomd on a drive, as a process of its own."""

    def __init__(self, directory: Path, drive: Path) -> None:
        self._log = open(directory / "odomd.log", "a", encoding="utf-8")
        # Through standard input, like a bus: opening the log by name would start a separate drive.
        log = open(drive / "drive.log", "rb")
        self._process = subprocess.Popen(
            [
                str(BIN / "odomd"),
                *("--config", str(drive / "car.toml"), "--can", "-"),
                *("--runtime-directory", str(directory), "--log-level", "warn"),
            ],
            stdin=log,
            stderr=self._log,
        )
        log.close()

    def kill(self) -> None:
        """kill -9."""
        self._process.kill()
        self._process.wait()
        self._log.close()
