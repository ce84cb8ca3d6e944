"""The records that odomd publishes, as immutable values that can be compared, stored and pickled.

Frames and units: ISO 8855 (x forward, y left, yaw counter-clockwise), centre of gravity, SI units,
times in nanoseconds of CLOCK_MONOTONIC (`time.monotonic_ns()`). Yaw is continuous (unwrapped).
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from operator import attrgetter
from typing import NamedTuple

from odom._library import BeatStruct, DetailsStruct, InfoStruct, PoseStruct


class Status(enum.IntEnum):
    """The result of a call; see `odom.OdomError`."""

    OK = 0
    STALE = 1
    NO_SEGMENT = 2
    REFUSED = 3
    ABI = 4
    NO_POSE = 5
    TOO_OLD = 6
    TOO_NEW = 7
    RESET = 8
    TIMEOUT = 9
    BUSY = 10
    INVALID = 11
    GAP = 12
    SYSTEM = 13


class Mode(enum.IntEnum):
    """The quality of a pose."""

    INITIALISING = 0  #: no initial pose or no wheel speed yet: pose fields are not valid
    TRACKING = 1  #: camera poses arrive
    DEAD_RECKONING = 2  #: only odometry
    DEGRADED = 3  #: works, but a condition shows a problem
    STANDSTILL = 4  #: the car is stationary
    FAULT = 5  #: the pose is frozen or invalid: do not use it

    @classmethod
    def _missing_(cls, value: object) -> Mode:
        # A mode of a newer daemon: clients must not use a pose whose mode they do not know.
        return cls.FAULT


class Conditions(enum.IntFlag):
    """Conditions, independent of the mode."""

    NOT_REALTIME = 1 << 0  #: the machine refused real-time scheduling or locking
    RESTARTED = 1 << 1  #: resumed from the last pose
    BUS_DOWN = 1 << 2  #: a bus is down or gone
    SIGNAL_TIMEOUT = 1 << 3  #: a mapped signal is overdue (see health)
    PROTECTION = 1 << 4  #: a message fails its end-to-end protection
    FRAMES_LOST = 1 << 5  #: the kernel dropped frames within the last second
    CARRIED_OVER = 1 << 6  #: this tick left frames behind for the next
    CLOCK_STEPPED = 1 << 7  #: the wall clock stepped within the last second
    SUSPENDED = 1 << 8  #: the machine slept within the last second
    CAMERA_REJECTED = 1 << 9  #: the last camera pose was implausible, too old or in the future
    MODEL_FAULT = 1 << 10  #: the model left its valid range and stopped
    NON_FINITE = 1 << 11  #: a non-finite state was reset; it was not published
    INPUT_ENDED = 1 << 12  #: the log or the pipe has ended
    SENSOR_FAULT = 1 << 13  #: a sensor's values cannot be true; see `Pose.health`
    WHEEL_SLIP = 1 << 14  #: a wheel's speed disagrees with the car's motion
    MISWIRED = 1 << 15  #: a sensor is wired or described wrongly; see `Pose.health`
    INCONSISTENT = 1 << 16  #: a source has been inconsistent with the filter for seconds
    BIAS_UNLEARNT = 1 << 17  #: the gyro bias is not known: stop the car for 2 s
    SCALE_IMPLAUSIBLE = 1 << 18  #: a learnt scale is far from its configured value: check it
    CAMERA_REFUSED = 1 << 19  #: a camera connection was refused within the last ten seconds


class Source(enum.IntEnum):
    """Index of a source in `Pose.health` and `Details.source_age_ns`."""

    YAW_RATE = 0
    ACCEL_X = 1
    ACCEL_Y = 2
    WHEEL_FRONT_LEFT = 3
    WHEEL_FRONT_RIGHT = 4
    WHEEL_REAR_LEFT = 5
    WHEEL_REAR_RIGHT = 6
    WHEEL_REAR = 7
    MOTOR = 8
    STEERING = 9
    DIRECTION = 10
    CAMERA = 11


class Clock(enum.IntEnum):
    """The clock that a time refers to."""

    MONOTONIC = 0
    REALTIME = 1
    LOG = 2  #: the stamps of the log that the daemon plays


class Pose(NamedTuple):
    """The data of a tick for a controller."""

    tick: int  #: number of the tick; strictly increasing while one daemon runs
    time_ns: int  #: when the pose is valid
    x: float  #: map frame [m]; jumps when `reset_count` rises
    y: float
    yaw: float  #: [rad]
    odom_x: float  #: odometry frame, which never jumps [m]
    odom_y: float
    odom_yaw: float  #: [rad]
    vx: float  #: body frame [m/s]
    vy: float
    yaw_rate: float  #: [rad/s]
    vx_dot: float  #: [m/s2]
    vy_dot: float
    yaw_accel: float  #: [rad/s2]
    accel_x: float  #: measured specific force [m/s2]
    accel_y: float
    steering: float  #: at the front wheels [rad], left positive
    covariance: tuple[float, ...]  #: of (x, y, yaw): xx, xy, xyaw, yy, yyaw, yawyaw
    mode: Mode
    conditions: Conditions
    reset_count: int  #: number of jumps of the map pose
    health: int  #: bit s: the `Source` s is configured and healthy; see `is_healthy`
    jump_x: float  #: the last jump of the map pose, map axes [m]
    jump_y: float
    jump_yaw: float  #: [rad]

    @property
    def sigma_x(self) -> float:
        """Standard deviation of x [m]."""
        return math.sqrt(self.covariance[0])

    @property
    def sigma_y(self) -> float:
        """Standard deviation of y [m]."""
        return math.sqrt(self.covariance[3])

    @property
    def sigma_yaw(self) -> float:
        """Standard deviation of yaw [rad]."""
        return math.sqrt(self.covariance[5])

    @property
    def position_sigma(self) -> float:
        """Standard deviation of the position in the direction in which it is largest [m].

        NaN if the covariance is invalid, so test `sigma <= limit`, which is then false.
        """
        xx, xy, _, yy, _, _ = self.covariance
        largest = 0.5 * (xx + yy) + math.hypot(0.5 * (xx - yy), xy)
        return math.sqrt(largest) if largest >= 0.0 else math.nan

    @property
    def mode_name(self) -> str:
        """The name of the mode, as in the status: "dead_reckoning"."""
        return self.mode.name.lower()

    def is_healthy(self, source: Source) -> bool:
        """Whether the source is configured and healthy."""
        return bool(self.health >> source & 1)


@dataclass(frozen=True, slots=True)
class Details:
    """All other data of a tick, for diagnosis, recording and users of the full state."""

    #: The rest of the upper triangle, by rows, of the 6x6 covariance of
    #: (x, y, yaw, vx, vy, yaw_rate): x-vx, x-vy, x-yaw_rate, y-vx, ..., vx-vx, ...
    velocity_covariance: tuple[float, ...]
    gyro_bias: float  #: [rad/s]
    gyro_scale: float  #: 1: exact
    accel_bias_x: float  #: [m/s2]
    accel_bias_y: float
    wheel_scale: float  #: 1: exact
    steering_offset: float  #: [rad]
    stiffness_scale: float  #: 1: as configured
    calibration_sigma: tuple[float, ...]  #: standard deviations of the seven above; 0: not estimated
    calibration_valid: int  #: bit i: the i-th has been learnt; bits 7 to 10: the four at the end
    correction_x: float  #: map from odometry frame [m]
    correction_y: float
    correction_yaw: float  #: [rad]
    dead_reckoning_since_ns: int  #: last fused camera pose; 0: none yet
    source_age_ns: tuple[int, ...]  #: by `Source`, at `Pose.time_ns`; -1: never seen
    frames: tuple[int, ...]  #: taken in since start, per bus
    camera_messages: int  #: taken in since start
    wakeup_latency_ns: int  #: wake-up latency of the beat for this tick
    execution_ns: int  #: execution time of the tick before this one
    gyro_latency: float  #: [s] beyond the configured one; positive: the sensor is later
    wheel_latency: float  #: likewise
    steering_latency: float
    grip: float  #: largest lateral acceleration on these tyres [m/s2]
    further_calibration_sigma: tuple[float, ...]  #: standard deviations of the four above; 0: not estimated


@dataclass(frozen=True, slots=True)
class Info:
    """Data that do not change while a daemon runs, and its clock offsets."""

    abi_major: int
    abi_minor: int
    instance_id: int  #: differs for every start of a daemon
    writer_pid: int
    writer_start_ns: int
    period_ns: int
    first_tick_ns: int  #: tick k is valid at first_tick_ns + k * period_ns
    realtime_offset_ns: int  #: CLOCK_REALTIME - CLOCK_MONOTONIC, as last measured
    log_offset_ns: int  #: log clock - CLOCK_MONOTONIC; 0 where no log is played
    slots: int  #: length of the history, in ticks
    mass: float  #: [kg]
    front_axle: float  #: centre of gravity to the front axle [m]
    rear_axle: float
    yaw_inertia: float  #: [kg m2]
    cornering_stiffness_front: float  #: [N/rad], whole axle
    cornering_stiffness_rear: float
    track_width: float  #: [m]
    model: str  #: "kinematic", "paper", ...
    version: str  #: of the daemon


@dataclass(frozen=True, slots=True)
class Beat:
    """The timing of the beat since the start.

    Histograms: bucket 0 counts [0, 1) us, bucket i >= 1 counts [2**((i-1)/4), 2**(i/4)) us, and the
    last one everything above.
    """

    ticks: int  #: published
    missed: int  #: cycles of the grid that were skipped completely
    overruns: int  #: ticks that had not ended when the next was due
    carried_over: int  #: drains that left frames behind
    heartbeat_ns: int  #: time of the last tick
    last_overrun_ns: int  #: time of the last overrun; 0: never
    last_overrun_execution_ns: int  #: execution time of that tick: was it slow, or woken late?
    max_wakeup_ns: int
    max_execution_ns: int
    wakeup: tuple[int, ...]  #: wake-up latency
    execution: tuple[int, ...]  #: execution time of a tick


_pose_fields = attrgetter(*Pose._fields)


def pose_of(raw: PoseStruct) -> Pose:
    v = _pose_fields(raw)
    return Pose._make((*v[:17], tuple(v[17]), Mode(v[18]), Conditions(v[19]), *v[20:]))


def struct_of(pose: Pose) -> PoseStruct:
    raw = PoseStruct(*pose[:17])
    raw.covariance = type(raw.covariance)(*pose.covariance)
    raw.mode, raw.conditions, raw.reset_count, raw.health = pose[18:22]
    raw.jump_x, raw.jump_y, raw.jump_yaw = pose[22:]
    return raw


def _values(raw: DetailsStruct | InfoStruct | BeatStruct) -> dict[str, object]:
    values = {}
    for field in raw._fields_:
        value = getattr(raw, field[0])
        if isinstance(value, bytes):
            value = value.decode("utf-8", "replace")
        elif not isinstance(value, (int, float)):
            value = tuple(value)
        values[field[0]] = value
    return values


def details_of(raw: DetailsStruct) -> Details:
    return Details(**_values(raw))  # type: ignore[arg-type]


def info_of(raw: InfoStruct) -> Info:
    return Info(**_values(raw))  # type: ignore[arg-type]


def beat_of(raw: BeatStruct) -> Beat:
    return Beat(**_values(raw))  # type: ignore[arg-type]
