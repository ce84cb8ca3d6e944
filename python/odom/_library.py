"""Finds libodom, and declares its structs and functions as in <odom/odom.h>."""

from __future__ import annotations

import ctypes
import os
from ctypes import POINTER, byref, c_char, c_double, c_int, c_int64, c_size_t, c_uint16, c_uint32, c_uint64
from pathlib import Path
from typing import Any

SOURCE_CAPACITY = 16
TEXT = 32
HISTOGRAM_BUCKETS = 64


class PoseStruct(ctypes.Structure):
    """odom_pose as it is in memory; `Client.read_into` can fill it repeatedly.

    Fields and units are those of `odom.Pose`; `mode` and `conditions` are plain numbers.
    """

    tick: int
    time_ns: int
    x: float
    y: float
    yaw: float
    odom_x: float
    odom_y: float
    odom_yaw: float
    vx: float
    vy: float
    yaw_rate: float
    vx_dot: float
    vy_dot: float
    yaw_accel: float
    accel_x: float
    accel_y: float
    steering: float
    covariance: ctypes.Array[c_double]
    mode: int
    conditions: int
    reset_count: int
    health: int
    jump_x: float
    jump_y: float
    jump_yaw: float

    _fields_ = [
        ("tick", c_uint64),
        ("time_ns", c_int64),
        ("x", c_double),
        ("y", c_double),
        ("yaw", c_double),
        ("odom_x", c_double),
        ("odom_y", c_double),
        ("odom_yaw", c_double),
        ("vx", c_double),
        ("vy", c_double),
        ("yaw_rate", c_double),
        ("vx_dot", c_double),
        ("vy_dot", c_double),
        ("yaw_accel", c_double),
        ("accel_x", c_double),
        ("accel_y", c_double),
        ("steering", c_double),
        ("covariance", c_double * 6),
        ("mode", c_uint32),
        ("conditions", c_uint32),
        ("reset_count", c_uint32),
        ("health", c_uint32),
        ("jump_x", c_double),
        ("jump_y", c_double),
        ("jump_yaw", c_double),
    ]


class DetailsStruct(ctypes.Structure):
    """odom_details."""

    _fields_ = [
        ("velocity_covariance", c_double * 15),
        ("gyro_bias", c_double),
        ("gyro_scale", c_double),
        ("accel_bias_x", c_double),
        ("accel_bias_y", c_double),
        ("wheel_scale", c_double),
        ("steering_offset", c_double),
        ("stiffness_scale", c_double),
        ("calibration_sigma", c_double * 7),
        ("calibration_valid", c_uint64),
        ("correction_x", c_double),
        ("correction_y", c_double),
        ("correction_yaw", c_double),
        ("dead_reckoning_since_ns", c_int64),
        ("source_age_ns", c_int64 * SOURCE_CAPACITY),
        ("frames", c_uint64 * 8),
        ("camera_messages", c_uint64),
        ("wakeup_latency_ns", c_int64),
        ("execution_ns", c_int64),
        ("gyro_latency", c_double),
        ("wheel_latency", c_double),
        ("steering_latency", c_double),
        ("grip", c_double),
        ("further_calibration_sigma", c_double * 4),
    ]


class InfoStruct(ctypes.Structure):
    """odom_info."""

    _fields_ = [
        ("abi_major", c_uint32),
        ("abi_minor", c_uint32),
        ("instance_id", c_uint64),
        ("writer_pid", c_int64),
        ("writer_start_ns", c_int64),
        ("period_ns", c_int64),
        ("first_tick_ns", c_int64),
        ("realtime_offset_ns", c_int64),
        ("log_offset_ns", c_int64),
        ("slots", c_uint64),
        ("mass", c_double),
        ("front_axle", c_double),
        ("rear_axle", c_double),
        ("yaw_inertia", c_double),
        ("cornering_stiffness_front", c_double),
        ("cornering_stiffness_rear", c_double),
        ("track_width", c_double),
        ("model", c_char * TEXT),
        ("version", c_char * TEXT),
    ]


class BeatStruct(ctypes.Structure):
    """odom_beat."""

    _fields_ = [
        ("ticks", c_uint64),
        ("missed", c_uint64),
        ("overruns", c_uint64),
        ("carried_over", c_uint64),
        ("heartbeat_ns", c_int64),
        ("last_overrun_ns", c_int64),
        ("last_overrun_execution_ns", c_int64),
        ("max_wakeup_ns", c_int64),
        ("max_execution_ns", c_int64),
        ("wakeup", c_uint64 * HISTOGRAM_BUCKETS),
        ("execution", c_uint64 * HISTOGRAM_BUCKETS),
    ]


class CameraMessageStruct(ctypes.Structure):
    """odom_camera_message."""

    _fields_ = [
        ("magic", c_uint32),
        ("version", c_uint16),
        ("clock", c_uint16),
        ("sequence", c_uint64),
        ("capture_ns", c_int64),
        ("x", c_double),
        ("y", c_double),
        ("yaw", c_double),
        ("sigma_x", c_double),
        ("sigma_y", c_double),
        ("sigma_yaw", c_double),
        ("reserved", c_uint64),
    ]


def _candidates() -> list[str]:
    """Only $ODOM_LIBRARY, if it is set; otherwise the library installed with this module, then by name."""
    chosen = os.environ.get("ODOM_LIBRARY")
    if chosen:
        return [chosen]
    name = "libodom.so.0"
    # This file is in PREFIX/lib/python3*/dist-packages/odom; finds the library below PREFIX.
    near: list[str] = []
    for directory in Path(__file__).resolve().parents:
        if directory.name in ("lib", "lib64"):
            near = [str(path) for path in (directory / name, *directory.glob(f"*-linux-gnu/{name}"))
                      if path.exists()]
            break
    return [*near, name]


def _load() -> ctypes.CDLL:
    problems = []
    for candidate in _candidates():
        try:
            # use_errno: after ODOM_SYSTEM, errno has the reason.
            return ctypes.CDLL(candidate, use_errno=True)
        except OSError as error:
            problems.append(str(error))
    raise ImportError(
        f"libodom cannot be loaded ({'; '.join(problems)}): install it, run ldconfig, "
        "or name it in $ODOM_LIBRARY"
    )


def _declare(library: ctypes.CDLL) -> ctypes.CDLL:
    pose = POINTER(PoseStruct)
    client = ctypes.c_void_p
    signatures: dict[str, tuple[Any, list[Any]]] = {
        "odom_strstatus": (ctypes.c_char_p, [c_int]),
        "odom_open": (c_int, [ctypes.c_char_p, POINTER(client)]),
        "odom_close": (None, [client]),
        "odom_latest": (c_int, [client, pose, c_size_t]),
        "odom_latest_details": (c_int, [client, pose, c_size_t, POINTER(DetailsStruct), c_size_t]),
        "odom_at": (c_int, [client, c_int64, pose, c_size_t]),
        "odom_predict": (c_int, [pose, c_int64, pose]),
        "odom_wait": (c_int, [client, pose, c_size_t, c_int64]),
        "odom_get_info": (c_int, [client, POINTER(InfoStruct), c_size_t]),
        "odom_get_beat": (c_int, [client, POINTER(BeatStruct), c_size_t]),
        "odom_to_clock": (c_int, [client, c_int, c_int64, POINTER(c_int64)]),
        "odom_camera_open": (c_int, [ctypes.c_char_p, POINTER(client)]),
        "odom_camera_send": (c_int, [client, POINTER(CameraMessageStruct)]),
        "odom_camera_close": (None, [client]),
    }
    for name, (result, arguments) in signatures.items():
        function = getattr(library, name)
        function.restype = result
        function.argtypes = arguments
    return library


lib = _declare(_load())

__all__ = ["lib", "byref"]
