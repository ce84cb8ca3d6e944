"""The client: poses of a daemon, also after its restarts."""

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
_SLICE_NS = 200_000_000  # of a long wait: between two of them Python handles its signals
_NOTHING_NEWER = (Status.STALE, Status.TIMEOUT, Status.NO_POSE)


def predict(pose: Pose, time_ns: int) -> Pose:
    """`pose` moved on to a time at most 100 ms ahead of it, by its velocities and derivatives.

    Position, yaw and velocities are exact for that motion, the covariance is grown, all else is
    that of `pose`. Needs no client.

    Raises OdomError: TOO_NEW, TOO_OLD (before the pose), NO_POSE (an initialising pose).
    """
    raw = struct_of(pose)
    status = lib.odom_predict(byref(raw), time_ns, byref(raw))
    if status != Status.OK:
        fail(status)
    return pose_of(raw)


class _OneThread:
    """Held during a call. The library does not lock, and would crash if two threads called it."""

    __slots__ = ("_lock",)

    def __init__(self) -> None:
        self._lock = threading.Lock()

    def __enter__(self) -> None:
        if not self._lock.acquire(blocking=False):
            raise RuntimeError("an odom.Client belongs to one thread at a time: open one for each")

    def __exit__(self, *_: object) -> None:
        self._lock.release()


class Client:
    """Attached to a segment, and to that of the next daemon after a restart.

        with odom.Client() as client:
            pose = client.wait()

    `name` is a POSIX shm name ("/odomd") or a path; None: $ODOM_SHM, else the first of "/odomd" and
    "/run/odomd/pose" whose daemon lives.

    Results are fresh, or the call raises: StaleError with the last pose if the daemon
    is silent, and OdomError for all else. A client survives the daemon: go on calling, and it goes
    over to the next one (`info().instance_id` has changed then).

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
        """Detaches from the segment. Every later call answers INVALID."""
        with self._in_use:
            lib.odom_close(self._client)
            self._client = c_void_p()

    def latest(self) -> Pose:
        """The newest pose. Raises StaleError, OdomError: NO_POSE, BUSY."""
        raw = PoseStruct()
        return _answer(self.read_into(raw), raw)

    def read_into(self, raw: PoseStruct) -> Status:
        """The newest pose into memory of the caller, for tight loops: nothing raises.

        With OK and STALE `raw` is whole. This is what Python has of in-place access: of the copy,
        some 20 ns, there is nothing to be saved where the call itself takes twenty times as long.
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

        Never across a jump: there the earlier tick is predicted to the time.

        Raises StaleError (its `pose` is the one asked for), OdomError: TOO_OLD, TOO_NEW, RESET,
        GAP, NO_POSE, BUSY.
        """
        raw = PoseStruct()
        with self._in_use:
            status = lib.odom_at(self._client, time_ns, byref(raw), _POSE_SIZE)
        return _answer(status, raw)

    def predict(self, time_ns: int) -> Pose:
        """The newest pose predicted to a time up to 100 ms ahead of it; a past one is looked up."""
        pose = self.latest()
        return predict(pose, time_ns) if time_ns > pose.time_ns else self.at(time_ns)

    def wait(self, after: Pose | None = None, timeout: float = 1.0) -> Pose:
        """Sleeps until a pose newer than `after` is published, by this daemon or its successor.

        Without `after`: newer than what is there now. `timeout` is in seconds.

        Raises StaleError when the time is up and the daemon silent, OdomError: TIMEOUT when it
        ticks but has published nothing newer, NO_POSE.
        """
        raw = PoseStruct()
        if after is not None:
            raw.tick, raw.time_ns = after.tick, after.time_ns
        return _answer(self.wait_into(raw, timeout), raw)

    def wait_into(self, raw: PoseStruct, timeout: float = 1.0) -> Status:
        """Sleeps until a pose newer than the one in `raw` is there, and puts it there.

        With `raw.tick == 0`: newer than what is there now. With OK and STALE `raw` is complete,
        else it is unchanged. Raises ValueError for an invalid timeout.
        """
        if not math.isfinite(timeout) or timeout < 0.0:
            raise ValueError(f"timeout: {timeout}: give seconds, 0 or more")
        until = time.monotonic_ns() + round(timeout * 1e9)
        newest = PoseStruct(tick=raw.tick, time_ns=raw.time_ns)
        with self._in_use:
            if raw.tick == 0:
                lib.odom_latest(self._client, byref(newest), _POSE_SIZE)
            if newest.tick == 0:  # nothing there yet: whatever comes is newer
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
        """Data that do not change while a daemon runs. Of the last daemon if it is silent."""
        raw = InfoStruct()
        with self._in_use:
            status = lib.odom_get_info(self._client, byref(raw), sizeof(raw))
        if status not in (Status.OK, Status.STALE):
            fail(status)
        return info_of(raw)

    def beat(self) -> Beat:
        """The daemon's timing. Of the last daemon if it is silent."""
        raw = BeatStruct()
        with self._in_use:
            status = lib.odom_get_beat(self._client, byref(raw), sizeof(raw))
        if status not in (Status.OK, Status.STALE):
            fail(status)
        return beat_of(raw)

    def to_clock(self, clock: Clock, monotonic_ns: int) -> int:
        """A CLOCK_MONOTONIC time on another clock, by the offsets of the segment.

        Raises OdomError: INVALID for Clock.LOG when no log is played.
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
