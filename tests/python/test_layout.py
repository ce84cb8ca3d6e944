"""The module's structs and enums are those of the headers, which test_layout.cpp pins."""

from __future__ import annotations

import ctypes
import enum
import re
import unittest
from pathlib import Path

import odom
from odom import _library, _records

STRUCTS: dict[str, type[ctypes.Structure]] = {
    "odom_pose": _library.PoseStruct,
    "odom_details": _library.DetailsStruct,
    "odom_info": _library.InfoStruct,
    "odom_beat": _library.BeatStruct,
    "odom_camera_message": _library.CameraMessageStruct,
}

ENUMS: list[tuple[str, type[enum.IntEnum] | type[enum.IntFlag]]] = [
    ("ODOM_SOURCE_", odom.Source),
    ("ODOM_COND_", odom.Conditions),
    ("ODOM_CLOCK_", odom.Clock),
]


PINNED = Path(__file__).parent.parent / "shm_api" / "pinned_layout.h"


def pinned(name: str) -> dict[str, int]:
    """The names in a macro of the pinned layout, with their offsets or values."""
    macro = PINNED.read_text().split(f"#define {name}(X)")[1].split("\n#define")[0].split("/*")[0]
    return {name: int(value) for name, value in re.findall(r"X\((\w+), (\d+)", macro)}


class Layout(unittest.TestCase):
    def test_every_field_lies_where_it_is_pinned(self) -> None:
        sizes = pinned("PINNED_STRUCTS")
        self.assertEqual({name: ctypes.sizeof(s) for name, s in STRUCTS.items()}, sizes)
        for name, struct in STRUCTS.items():
            fields = {f[0]: getattr(struct, f[0]) for f in struct._fields_}
            offsets = pinned(name.replace("odom_", "PINNED_").upper())
            ends = [*offsets.values(), sizes[name]][1:]  # there is no padding
            self.assertEqual(
                {field: (place.offset, place.size) for field, place in fields.items()},
                {f: (start, end - start) for (f, start), end in zip(offsets.items(), ends)},
            )

    def test_the_records_have_the_fields_of_the_structs(self) -> None:
        for struct, record in [
            (_library.PoseStruct, odom.Pose),
            (_library.DetailsStruct, odom.Details),
            (_library.InfoStruct, odom.Info),
            (_library.BeatStruct, odom.Beat),
        ]:
            names = [field[0] for field in struct._fields_]
            self.assertEqual(names, list(record.__annotations__))

    def test_the_enums_have_every_constant(self) -> None:
        constants = {f"ODOM_{name}": value for name, value in pinned("PINNED_CONSTANTS").items()}
        self.assertEqual(constants.pop("ODOM_SOURCE_COUNT"), len(odom.Source))
        for prefix, members in ENUMS:
            found = {n: v for n, v in constants.items() if n.startswith(prefix)}
            self.assertEqual({prefix + m.name: m.value for m in members}, found)
            for name in found:
                del constants[name]
        plain = [*odom.Status, *odom.Mode]
        self.assertEqual({f"ODOM_{m.name}": m.value for m in plain}, constants)

    def test_a_pose_survives_the_way_there_and_back(self) -> None:
        raw = _library.PoseStruct()
        for i, field in enumerate(_library.PoseStruct._fields_):
            if field[0] == "covariance":
                raw.covariance[:] = [0.5, 1.5, 2.5, 3.5, 4.5, 5.5]
            else:
                setattr(raw, field[0], 3 if field[0] == "mode" else i + 1)
        pose = _records.pose_of(raw)
        self.assertEqual(pose.covariance, (0.5, 1.5, 2.5, 3.5, 4.5, 5.5))
        self.assertIs(pose.mode, odom.Mode.DEGRADED)
        in_c = _library.lib.odom_position_sigma
        in_c.restype = ctypes.c_double
        in_c.argtypes = [ctypes.POINTER(_library.PoseStruct)]
        self.assertAlmostEqual(pose.position_sigma, in_c(raw), places=14)
        self.assertEqual(bytes(_records.struct_of(pose)), bytes(raw))

    def test_an_unknown_mode_is_nothing_to_drive_by(self) -> None:
        raw = _library.PoseStruct(mode=77, conditions=1 << 31 | 1)
        pose = _records.pose_of(raw)
        self.assertIs(pose.mode, odom.Mode.FAULT)
        self.assertIn(odom.Conditions.NOT_REALTIME, pose.conditions)
        self.assertEqual(int(pose.conditions), 1 << 31 | 1)


if __name__ == "__main__":
    unittest.main()
