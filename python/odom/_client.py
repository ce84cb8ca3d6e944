"""The client: reads the poses of a daemon, also across restarts."""

from __future__ import annotations

import math
import os
import threading
import time
from ctypes import byref, c_int64, c_void_p, memmove, sizeof
from types import TracebackType

from odom._errors import StaleError, fail
from odom._library import BeatStruct, DetailsStruct, InfoStruct, PoseStruct, lib
from odom._records import (
    Beat,
    Clock,
    Details,
    Info,
    Pose,
    Status,
    beat_of,
    details_of,
    info_of,
    pose_of,
    struct_of,
)

_POSE_SIZE = sizeof(PoseStruct)
_SLICE_NS = 200_000_000  # part of a long wait: Python handles signals between two parts
_NOTHING_NEWER = (Status.STALE, Status.TIMEOUT, Status.NO_POSE)


def predict(pose: Pose, time_ns: int) -> Pose:
    """`pose` predicted to a time at most 100 ms ahead, from its velocities and their derivatives.

    Position, yaw and velocities are exact for that motion, the covariance grows, and all else is
    that of `pose`. No client is needed.

    Raises OdomError: TOO_NEW, TOO_OLD (before the pose), NO_POSE (an initialising pose).
    """
    raw = struct_of(pose)
    status = lib.odom_predict(byref(raw), time_ns, byref(raw))
    if status != Status.OK:
        fail(status)
    return pose_of(raw)


class _OneThread:
    """Held during a call. The library has no lock and would crash if two threads used a client."""

    __slots__ = ("_lock",)

    def __init__(self) -> None:
        self._lock = threading.Lock()

    def __enter__(self) -> None:
        if not self._lock.acquire(blocking=False):
            raise RuntimeError("an odom.Client belongs to one thread at a time: open one for each")

    def __exit__(self, *_: object) -> None:
        self._lock.release()


class Client:
    """Attached to a segment; after a restart, to that of the new daemon.

        with odom.Client() as client:
            pose = client.wait()

    `name` is a POSIX shm name ("/odomd") or a path; None: $ODOM_SHM; if that is not set, the
    segment that odom_open() finds.

    Results are fresh; otherwise the call raises StaleError with the last pose if the daemon is
    silent, or OdomError for all else. A client survives the daemon: keep calling, and it switches
    to the next one (`info().instance_id` then changes).

    A client belongs to one thread at a time: open one for each thread. Two threads at once raise a
    RuntimeError. While a call waits, other Python threads run.

    Raises OdomError: NO_SEGMENT, REFUSED, ABI, INVALID, SYSTEM.
    """

    __slots__ = ("_client", "_in_use", "__weakref__")

    def __init__(self, name: str | os.PathLike[str] | None = None) -> None:
        self._client = c_void_p()
        self._in_use = _OneThread()
        encoded = None if name is None else os.fsencode(name)
        if encoded is not None and b"\0" in encoded:
            fail(Status.INVALID, repr(name))
        status = lib.odom_open(encoded, byref(self._client))
        if status != Status.OK:
            fail(status, "" if name is None else os.fspath(name))

    def __enter__(self) -> Client:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def __del__(self) -> None:
        if getattr(self, "_client", None):
            lib.odom_close(self._client)

    def close(self) -> None:
        """Detaches from the segment. Every later call raises INVALID."""
        with self._in_use:
            lib.odom_close(self._client)
            self._client = c_void_p()

    def latest(self) -> Pose:
        """The newest pose. Raises StaleError, OdomError: NO_POSE, BUSY."""
        raw = PoseStruct()
        return _answer(self.read_into(raw), raw)

    def read_into(self, raw: PoseStruct) -> Status:
        """Reads the newest pose into the caller's memory, for tight loops; raises nothing.

        With OK and STALE `raw` is complete. Python has no access in place: the copy takes about 20 ns,
        and the call itself twenty times as long.
        """
        with self._in_use:
            return Status(lib.odom_latest(self._client, byref(raw), _POSE_SIZE))

    def latest_details(self) -> tuple[Pose, Details]:
        """The newest pose and the details of the same tick. Raises as `latest`."""
        raw = PoseStruct()
        more = DetailsStruct()
        with self._in_use:
            status = lib.odom_latest_details(
                self._client, byref(raw), _POSE_SIZE, byref(more), sizeof(more)
            )
        if status == Status.STALE:
            raise StaleError(pose_of(raw), details_of(more))
        return _answer(status, raw), details_of(more)

    def at(self, time_ns: int) -> Pose:
        """The pose at a past time within the history, interpolated between two ticks.

        It never interpolates across a jump; there, the earlier tick is predicted to that time.

        Raises StaleError (its `pose` is the requested one), OdomError: TOO_OLD, TOO_NEW, RESET,
        GAP, NO_POSE, BUSY.
        """
        raw = PoseStruct()
        with self._in_use:
            status = lib.odom_at(self._client, time_ns, byref(raw), _POSE_SIZE)
        return _answer(status, raw)

    def predict(self, time_ns: int) -> Pose:
        """The newest pose predicted to a time up to 100 ms ahead; a past time is looked up."""
        pose = self.latest()
        return predict(pose, time_ns) if time_ns > pose.time_ns else self.at(time_ns)

    def wait(self, after: Pose | None = None, timeout: float = 1.0) -> Pose:
        """Sleeps until a pose newer than `after` is published, by this daemon or its successor.

        Without `after`: newer than the present one. `timeout` is in seconds.

        Raises StaleError after the timeout if the daemon is silent, OdomError: TIMEOUT if it
        ticks but has published nothing newer, NO_POSE.
        """
        raw = PoseStruct()
        if after is not None:
            raw.tick, raw.time_ns = after.tick, after.time_ns
        return _answer(self.wait_into(raw, timeout), raw)

    def wait_into(self, raw: PoseStruct, timeout: float = 1.0) -> Status:
        """Sleeps until a pose newer than the one in `raw` is published, and writes it to `raw`.

        With `raw.tick == 0`: newer than the present one. With OK and STALE `raw` is complete,
        otherwise it is unchanged. Raises ValueError for an invalid timeout.
        """
        if not math.isfinite(timeout) or timeout < 0.0:
            raise ValueError(f"timeout: {timeout}: give seconds, 0 or more")
        until = time.monotonic_ns() + round(timeout * 1e9)
        newest = PoseStruct(tick=raw.tick, time_ns=raw.time_ns)
        with self._in_use:
            if raw.tick == 0:
                lib.odom_latest(self._client, byref(newest), _POSE_SIZE)
            if newest.tick == 0:  # no pose yet: any pose is newer
                newest.tick, newest.time_ns = 1, -(2**63)
            since_ns = newest.time_ns
            while True:
                left = max(0, until - time.monotonic_ns())
                status = lib.odom_wait(self._client, byref(newest), _POSE_SIZE, min(left, _SLICE_NS))
                is_up = left <= _SLICE_NS or status not in _NOTHING_NEWER
                if is_up or newest.time_ns > since_ns:
                    break
        if status in (Status.OK, Status.STALE):
            memmove(byref(raw), byref(newest), _POSE_SIZE)
        return Status(status)

    @property
    def stale(self) -> bool:
        """Whether the daemon has been silent for four periods."""
        return self.read_into(PoseStruct()) == Status.STALE

    def info(self) -> Info:
        """Data that do not change while a daemon runs; of the last daemon if it is silent."""
        raw = InfoStruct()
        with self._in_use:
            status = lib.odom_get_info(self._client, byref(raw), sizeof(raw))
        if status not in (Status.OK, Status.STALE):
            fail(status)
        return info_of(raw)

    def beat(self) -> Beat:
        """The timing of the daemon; of the last one if it is silent."""
        raw = BeatStruct()
        with self._in_use:
            status = lib.odom_get_beat(self._client, byref(raw), sizeof(raw))
        if status not in (Status.OK, Status.STALE):
            fail(status)
        return beat_of(raw)

    def to_clock(self, clock: Clock, monotonic_ns: int) -> int:
        """Converts a CLOCK_MONOTONIC time to another clock, using the offsets in the segment.

        Raises OdomError: INVALID for Clock.LOG if no log is played.
        """
        time_ns = c_int64()
        with self._in_use:
            status = lib.odom_to_clock(self._client, clock, monotonic_ns, byref(time_ns))
        if status not in (Status.OK, Status.STALE):
            fail(status)
        return time_ns.value


def _answer(status: int, raw: PoseStruct) -> Pose:
    if status == Status.OK:
        return pose_of(raw)
    if status == Status.STALE:
        raise StaleError(pose_of(raw))
    fail(status)
