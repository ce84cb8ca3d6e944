"""The example controllers as processes: what they command, line by line."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import support


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
