"""Errors as exceptions."""

from __future__ import annotations

import ctypes
import os
from typing import NoReturn

from odom._library import lib
from odom._records import Details, Pose, Status


class OdomError(Exception):
    """A call had no usable result; `status` shows why."""

    def __init__(self, status: Status, what: str = "") -> None:
        text = lib.odom_strstatus(status).decode()
        if status == Status.SYSTEM:
            text += f": {os.strerror(ctypes.get_errno())}"
        super().__init__(f"{what}: {text}" if what else text)
        self.status = status


class StaleError(OdomError):
    """The daemon has been silent for four periods: `pose` is its last pose.

    Call again: the client re-attaches by itself when the next daemon publishes.
    """

    def __init__(self, pose: Pose, details: Details | None = None) -> None:
        super().__init__(Status.STALE)
        self.pose = pose
        self.details = details


def fail(status: int, what: str = "") -> NoReturn:
    raise OdomError(Status(status), what)
