"""odom export: the MCAP file read back by a reader that shares nothing with its writer, and the CSV."""

from __future__ import annotations

import csv
import json
import math
import re
import subprocess
import tempfile
import unittest
from pathlib import Path
from typing import Any

import mcap_reader
import support

NUMBER = (int, float)


def odom(*arguments: object, status: int = 0) -> str:
    result = subprocess.run(
        [str(support.BIN / "odom"), *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=10 * support.TIMEOUT,
    )
    if result.returncode != status:
        raise AssertionError(f"{arguments}: {result}")
    return result.stderr


def conforms(value: Any, schema: dict[str, Any], place: str) -> None:
    """Checks a value by the part of JSON schema that Foxglove reads; no property may be missing or additional."""
    kind = schema["type"]
    if kind == "object":
        assert set(schema["required"]) == set(schema["properties"]), place
        assert set(value) == set(schema["properties"]), (place, value)
        for name, part in schema["properties"].items():
            conforms(value[name], part, f"{place}/{name}")
    elif kind == "array":
        for item in value:
            conforms(item, schema["items"], place)
    elif kind == "number":
        assert isinstance(value, NUMBER) and math.isfinite(value), (place, value)
    elif kind == "integer":
        assert isinstance(value, int), (place, value)
        assert schema.get("minimum", value) <= value <= schema.get("maximum", value), (place, value)
    else:
        assert kind == "string" and isinstance(value, str), (place, value)


def nanoseconds(time: dict[str, int]) -> int:
    return time["sec"] * 10**9 + time["nsec"]


def rows_of(file: Path) -> list[dict[str, str]]:
    with open(file, encoding="ascii", newline="") as text:
        return list(csv.DictReader(text))


def stamp(seconds: str) -> int:
    whole, fraction = seconds.split(".")
    return int(whole) * 10**9 + int(fraction.ljust(9, "0"))


class Export(unittest.TestCase):
    directory: Path
    drive: Path
    pose: Path

    @classmethod
    def setUpClass(cls) -> None:
        cls.directory = Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        cls.drive = cls.directory / "drive"
        odom("sim", "--duration", "2.5", "--standstill", "0.5", "--out", cls.drive)
        cls.pose = cls.directory / "pose.csv"
        files = ["--can", cls.drive / "drive.log", "--camera", cls.drive / "camera.csv"]
        odom("replay", "--config", cls.drive / "car.toml", *files, "--out", cls.pose)

    def read(self, file: Path) -> mcap_reader.File:
        """A file that is sound in itself, whose messages are in order and are what their schemas say."""
        mcap = mcap_reader.File(file.read_bytes())
        self.assertTrue(mcap.library.startswith("odom "))
        times = [message.log_time for message in mcap.messages]
        self.assertEqual(times, sorted(times))
        for (_, before), (_, after) in zip(mcap.chunks, mcap.chunks[1:]):
            self.assertLessEqual(before.end, after.start)
        schemas = {}
        for schema in mcap.schemas.values():
            self.assertEqual(schema.encoding, "jsonschema")
            schemas[schema.id] = json.loads(schema.data)
            self.assertEqual(schemas[schema.id]["title"], schema.name)
        sequences = dict.fromkeys(mcap.channels, 0)
        for message in mcap.messages:
            channel = mcap.channels[message.channel_id]
            self.assertEqual(channel.message_encoding, "json")
            self.assertEqual(message.publish_time, message.log_time)
            self.assertEqual(message.sequence, sequences[channel.id])
            sequences[channel.id] += 1
            conforms(json.loads(message.data), schemas[channel.schema_id], channel.topic)
        return mcap

    def export(self, *arguments: object) -> mcap_reader.File:
        file = self.directory / "out.mcap"
        odom("export", *arguments, "--mcap", file)
        return self.read(file)

    def test_a_drive_has_all_of_its_topics(self) -> None:
        mcap = self.export(self.drive, "--pose", self.pose)
        self.assertGreater(len(mcap.chunks), 1)
        schemas = {topic: mcap.schemas[channel.schema_id].name for topic, channel in mcap.topics().items()}
        self.assertEqual(schemas["/tf"], "foxglove.FrameTransforms")
        self.assertEqual({schemas[of + "/pose"] for of in ("", "/camera", "/truth")}, {"foxglove.PoseInFrame"})
        signals = {topic for topic in mcap.topics() if topic.startswith("/can/")}
        self.assertLessEqual({"/can/yaw_rate", "/can/steering", "/can/accel_x"}, signals)
        frames = (self.drive / "drive.log").read_text(encoding="ascii").splitlines()
        times = {message.log_time for message in mcap.on("/can/yaw_rate")}
        self.assertLessEqual(times, {stamp(line[1 : line.index(")")]) for line in frames})

        rows = rows_of(self.pose)
        for topic in ("/pose", "/tf", "/odomd/pose"):
            messages = mcap.on(topic)
            self.assertEqual([m.log_time for m in messages], [stamp(row["t"]) for row in rows])
        for row, message in zip(rows, mcap.on("/pose")):
            value = json.loads(message.data)
            self.assertEqual(nanoseconds(value["timestamp"]), message.log_time)
            self.assertEqual(value["frame_id"], "map")
            self.assertEqual(value["pose"]["position"]["x"], float(row["x"]))
            turn = value["pose"]["orientation"]
            self.assertAlmostEqual(2 * math.atan2(turn["z"], turn["w"]), math.remainder(float(row["yaw"]), math.tau))
        for row, message in zip(rows, mcap.on("/odomd/pose")):
            value = json.loads(message.data)
            self.assertEqual(value["map"]["yaw"], float(row["yaw"]))
            self.assertEqual(value["odom"]["x"], float(row["odom_x"]))
            self.assertEqual(value["sigma"]["y"], float(row["sigma_y"]))
            self.assertEqual(value["mode_name"], row["mode"])
            self.assertEqual(value["calibration"]["gyro_bias"], float(row["gyro_bias"]))

        camera = rows_of(self.drive / "camera.csv")
        self.assertEqual(len(mcap.on("/camera/pose")), len(camera))
        for row, message in zip(camera, mcap.on("/camera/measurement")):
            value = json.loads(message.data)
            self.assertEqual(message.log_time, stamp(row["t_arrival"]))
            self.assertEqual(nanoseconds(value["timestamp"]), stamp(row["t_capture"]))
            self.assertEqual(value["sigma_yaw"], float(row["sigma_yaw"]))
        truth = rows_of(self.drive / "truth.csv")
        self.assertEqual(len(mcap.on("/truth/state")), len(truth))
        self.assertEqual(json.loads(mcap.on("/truth/state")[-1].data)["y"], float(truth[-1]["y"]))

    def test_composed_transforms_give_the_pose(self) -> None:
        mcap = self.export(self.pose)
        self.assertEqual(set(mcap.topics()), {"/pose", "/tf", "/odomd/pose"})
        for message, pose in zip(mcap.on("/tf"), mcap.on("/pose")):
            to_odom, to_base = json.loads(message.data)["transforms"]
            self.assertEqual((to_odom["parent_frame_id"], to_odom["child_frame_id"]), ("map", "odom"))
            self.assertEqual((to_base["parent_frame_id"], to_base["child_frame_id"]), ("odom", "base_link"))
            turn = 2 * math.atan2(to_odom["rotation"]["z"], to_odom["rotation"]["w"])
            x, y = to_base["translation"]["x"], to_base["translation"]["y"]
            position = json.loads(pose.data)["pose"]["position"]
            shift, c, s = to_odom["translation"], math.cos(turn), math.sin(turn)
            self.assertAlmostEqual(shift["x"] + c * x - s * y, position["x"])
            self.assertAlmostEqual(shift["y"] + s * x + c * y, position["y"])

    def test_a_drive_without_poses_is_replayed(self) -> None:
        replayed = self.export(self.drive)
        read = self.export(self.drive, "--pose", self.pose)
        self.assertEqual(
            [(m.log_time, m.data) for m in replayed.on("/pose")],
            [(m.log_time, m.data) for m in read.on("/pose")],
        )

    def test_csv_for_plotjuggler(self) -> None:
        file = self.directory / "out.csv"
        odom("export", self.pose, "--csv", file)
        rows = rows_of(file)
        poses = rows_of(self.pose)
        self.assertEqual(len(rows), len(poses))
        self.assertEqual(next(iter(rows[0])), "time")
        for row, pose in zip(rows, poses):
            self.assertEqual(stamp(row["time"]), stamp(pose["t"]))
            self.assertEqual(float(row["map/x"]), float(pose["x"]))
            self.assertEqual(float(row["velocity/yaw"]), float(pose["yaw_rate"]))
            self.assertTrue(all(math.isfinite(float(value)) for value in row.values()))

    def test_tum_for_evo(self) -> None:
        # https://github.com/MichaelGrupp/evo/wiki/Formats: eight numbers separated by single blanks, # before comments
        folder = self.directory / "tum"
        odom("export", self.drive, "--pose", self.pose, "--tum", folder)
        sources = {"pose": (self.pose, "t", ""), "odometry": (self.pose, "t", "odom_"),
                   "camera": (self.drive / "camera.csv", "t_capture", ""), "truth": (self.drive / "truth.csv", "t", "")}
        self.assertEqual({file.stem for file in folder.iterdir()}, set(sources))
        for name, (file, time, prefix) in sources.items():
            lines = (folder / f"{name}.tum").read_text(encoding="ascii").splitlines()
            rows = [line.split(" ") for line in lines if not line.startswith("#")]
            expected = sorted(rows_of(file), key=lambda row: row[time])
            self.assertEqual([stamp(row[0]) for row in rows], [stamp(row[time]) for row in expected])
            for row, pose in zip(rows, expected):
                _, x, y, z, *flat, turn, cosine = map(float, row)
                self.assertEqual([x, y, z, *flat], [float(pose[prefix + "x"]), float(pose[prefix + "y"]), 0, 0, 0])
                self.assertAlmostEqual(turn, cosine * math.tan(float(pose[prefix + "yaw"]) / 2))
        self.assertIn("pose.csv: Not a directory", odom("export", self.pose, "--tum", self.pose, status=2))

    def test_the_layout_names_existing_topics(self) -> None:
        mcap = self.export(self.drive)
        layout = json.loads((Path(__file__).parents[3] / "docs/foxglove-layout.json").read_text(encoding="utf-8"))
        panels = layout["configById"]
        self.assertEqual(sorted(re.findall(r"[^\s\"]+![a-z]+", json.dumps(layout["layout"]))), sorted(panels))
        self.assertLessEqual(set(panels["3D!map"]["topics"]), set(mcap.topics()))
        self.assertEqual(panels["3D!map"]["followTf"], json.loads(mcap.on("/pose")[0].data)["frame_id"])
        paths = re.findall(r'"value": "([^"]+)"', json.dumps(panels))
        self.assertGreater(len(paths), 10)
        for path in paths:
            topic, *names = path.split(".")
            value = json.loads(mcap.on(topic)[-1].data)
            for name in names:
                value = value[name]
            self.assertIsInstance(value, (*NUMBER, str), path)

    def test_the_input_is_not_overwritten(self) -> None:
        before = self.pose.read_bytes()
        for option in "--csv", "--mcap":
            said = odom("export", self.pose, option, self.pose, status=2)
            self.assertIn("is what is read; name another file", said)
        self.assertEqual(self.pose.read_bytes(), before)

    def test_a_trajectory_suffices(self) -> None:
        mcap = self.export(self.drive / "truth.csv")
        (transform,) = json.loads(mcap.on("/tf")[0].data)["transforms"]
        self.assertEqual((transform["parent_frame_id"], transform["child_frame_id"]), ("map", "base_link"))

    def test_poses_need_no_frames(self) -> None:
        folder = self.directory / "silent"
        folder.mkdir()
        (folder / "pose.csv").write_bytes(self.pose.read_bytes())
        alone = self.export(folder)
        self.assertEqual(set(alone.topics()), {"/pose", "/tf", "/odomd/pose"})
        self.assertIn("is what is read", odom("export", folder, "--csv", folder / "pose.csv", status=2))
        for name in "camera.csv", "car.toml", "truth.csv":
            (folder / name).write_bytes((self.drive / name).read_bytes())
        (folder / "can.log").write_bytes(b"")
        silent = self.export(folder)
        self.assertEqual(len(silent.on("/pose")), len(alone.on("/pose")))
        self.assertTrue(silent.on("/camera/pose") and silent.on("/truth/pose"))

    def test_the_same_drive_gives_the_same_bytes(self) -> None:
        self.assertEqual(self.export(self.drive).data, self.export(self.drive).data)

    def test_unusable_input_is_refused_in_one_line(self) -> None:
        out = self.directory / "never.mcap"
        bad = self.directory / "bad.csv"
        for text, expected in (
            ("", "is empty"),
            ("t,x,y\n", 'no column "yaw"'),
            ("t,x,y,yaw\n", "nothing to export"),
            ("t,x,y,yaw\n1,2,3,4\n0.5,2,3,4\n", "runs backwards"),
            ("t,x,y,yaw\n1,2,nan,4\n", "not a finite number"),
            ("t,x,y,yaw,mode\n1,2,3,4,asleep\n", '"asleep" is not a mode'),
            ("t,x,y,yaw\n-1.5,2,3,4\n", "which MCAP cannot store"),
        ):
            bad.write_text(text)
            error = odom("export", bad, "--mcap", out, status=2)
            self.assertIn(expected, error.splitlines()[-1])
            self.assertEqual(len(error.splitlines()), 2 if "nothing" in expected else 1, error)
            self.assertFalse(out.exists())
        self.assertIn("has no car.toml", odom("export", "/usr", "--mcap", out, status=2))
        self.assertIn("--mcap, --csv or --tum", odom("export", self.pose, status=2))
        self.assertIn("use --csv", odom("export", self.pose, "--mcap", self.directory / "a.csv", status=2))
        self.assertIn("--drive", odom("export", "--mcap", out, status=2))

    def test_a_recording_has_the_published_poses(self) -> None:
        recording = self.directory / "recording"
        daemon = support.Daemon(self.directory, self.drive)
        self.addCleanup(daemon.kill)
        socket = self.directory / "record.sock"
        odom("record", "--out", recording, "--socket", socket, "--wait", 60, "--duration", 3)
        mcap = self.export(recording)
        rows = rows_of(recording / "pose.csv")
        self.assertGreater(len(rows), 0)
        self.assertEqual([m.log_time for m in mcap.on("/pose")], [stamp(row["t"]) for row in rows])
        self.assertGreater(len(mcap.on("/can/yaw_rate")), 0)


class Reader(unittest.TestCase):
    """The reader can fail: no byte of a file may change unnoticed."""

    def test_finds_every_changed_byte(self) -> None:
        directory = Path(self.enterContext(tempfile.TemporaryDirectory()))
        pose = directory / "pose.csv"
        pose.write_text("t,x,y,yaw\n1.0,2,3,0\n1.005,2.1,3,0\n")
        out = directory / "out.mcap"
        odom("export", pose, "--mcap", out)
        data = out.read_bytes()
        mcap_reader.File(data)
        for at in range(len(data)):
            changed = bytearray(data)
            changed[at] ^= 0x10
            with self.assertRaises(Exception, msg=f"byte {at} of {len(data)}"):
                mcap_reader.File(bytes(changed))


if __name__ == "__main__":
    unittest.main()
