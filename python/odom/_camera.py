"""The camera's side: poses for the daemon."""

from __future__ import annotations

import os
from ctypes import byref, c_void_p
from types import TracebackType

from odom._library import CameraMessageStruct, lib
from odom._records import Clock


class CameraSender:
    """Sends camera poses to the daemon's camera socket; None: that which odom_camera_open() finds.

    Reconnects by itself after a restart of the daemon. Use it from one thread at a time.

    Raises OSError (ConnectionRefusedError, FileNotFoundError, ...) if no daemon is running.
    """

    __slots__ = ("_camera", "__weakref__")

    def __init__(self, path: str | os.PathLike[str] | None = None) -> None:
        self._camera = c_void_p()
        encoded = None if path is None else os.fsencode(path)
        error = lib.odom_camera_open(encoded, byref(self._camera))
        if error != 0:
            raise OSError(-error, os.strerror(-error), path)

    def __enter__(self) -> CameraSender:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def __del__(self) -> None:
        if getattr(self, "_camera", None):
            lib.odom_camera_close(self._camera)

    def close(self) -> None:
        """Closes the connection. Every later pose raises OSError (EINVAL)."""
        lib.odom_camera_close(self._camera)
        self._camera = c_void_p()

    def send(
        self,
        capture_ns: int,
        x: float,
        y: float,
        yaw: float,
        *,
        sigma_x: float,
        sigma_y: float,
        sigma_yaw: float,
        clock: Clock = Clock.MONOTONIC,
    ) -> None:
        """Sends the pose of the reference point at the time the picture was taken.

        Map frame and axes, metres and radians. Never blocks. Raises OSError if the pose was
        dropped: BlockingIOError (the daemon is too slow), ConnectionRefusedError or
        FileNotFoundError (no daemon is running), EINVAL (not finite, or a sigma is not positive).
        """
        message = CameraMessageStruct(
            clock=clock,
            capture_ns=capture_ns,
            x=x,
            y=y,
            yaw=yaw,
            sigma_x=sigma_x,
            sigma_y=sigma_y,
            sigma_yaw=sigma_yaw,
        )
        error = lib.odom_camera_send(self._camera, byref(message))
        if error != 0:
            raise OSError(-error, os.strerror(-error))
