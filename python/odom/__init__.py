"""The car's pose from odomd's shared memory, every few milliseconds.

    import odom

    with odom.Client() as client:
        pose = None
        while True:
            try:
                pose = client.wait(pose, timeout=0.1)
            except odom.OdomError:  # no daemon: stop the car; the client re-attaches by itself
                continue
            ahead = odom.predict(pose, pose.time_ns + 20_000_000)  # when the steering will have moved
            if pose.mode != odom.Mode.FAULT and ahead.position_sigma <= 0.3:  # m
                ...

This module wraps the C library libodom with ctypes and uses its names; for the details see
`<odom/odom.h>` and libodom(3). A read takes a few microseconds, nearly all of them in Python.
"""

from odom._camera import CameraSender
from odom._client import Client, predict
from odom._errors import OdomError, StaleError
from odom._library import PoseStruct
from odom._records import Beat, Clock, Conditions, Details, Info, Mode, Pose, Source, Status

__all__ = [
    "Beat",
    "CameraSender",
    "Client",
    "Clock",
    "Conditions",
    "Details",
    "Info",
    "Mode",
    "OdomError",
    "Pose",
    "PoseStruct",
    "Source",
    "StaleError",
    "Status",
    "predict",
]

__version__ = "0.1.0"
