"""The client, on a segment whose writer takes commands, and the camera's sender."""

from __future__ import annotations

import math
import pickle
import socket
import tempfile
import threading
import time
import unittest
from pathlib import Path

import odom
import support
from odom._library import CameraMessageStruct

SLOW = 1.0  # s, the longest period: the segment becomes silent after four of them


class DirectoryTest(unittest.TestCase):
    def setUp(self) -> None:
        self.path = Path(self.enterContext(tempfile.TemporaryDirectory())) / "pose"


class Camera(DirectoryTest):
    """The camera's side, against a socket that stands for the daemon's."""

    def listen(self) -> socket.socket:
        door = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self.addCleanup(door.close)
        door.bind(str(self.path))
        door.listen()
        return door

    def test_a_pose_arrives_on_the_wire(self) -> None:
        door = self.listen()
        with odom.CameraSender(self.path) as camera:
            camera.send(
                5, 1.0, 2.0, 3.0, sigma_x=0.1, sigma_y=0.2, sigma_yaw=0.3, clock=odom.Clock.LOG
            )
            connection, _ = door.accept()
            with connection:
                message = CameraMessageStruct.from_buffer_copy(connection.recv(4096))
        self.assertEqual((message.magic, message.version, message.clock), (0x4D43444F, 1, 2))
        self.assertEqual((message.sequence, message.capture_ns), (1, 5))
        self.assertEqual((message.x, message.y, message.yaw), (1.0, 2.0, 3.0))
        self.assertEqual((message.sigma_x, message.sigma_y, message.sigma_yaw), (0.1, 0.2, 0.3))

    def test_reports_what_cannot_be_sent(self) -> None:
        with self.assertRaises(FileNotFoundError):
            odom.CameraSender(self.path)
        self.listen()
        camera = odom.CameraSender(self.path)
        for x, sigma_x in [(math.nan, 0.1), (1.0, 0.0)]:
            with self.assertRaises(OSError):
                camera.send(5, x, 2.0, 3.0, sigma_x=sigma_x, sigma_y=0.2, sigma_yaw=0.3)
        camera.close()
        with self.assertRaises(OSError):
            camera.send(5, 1.0, 2.0, 3.0, sigma_x=0.1, sigma_y=0.2, sigma_yaw=0.3)


class ClientTest(DirectoryTest):
    def segment(self, period: float = SLOW) -> support.Segment:
        segment = support.Segment(self.path, period)
        self.addCleanup(segment.kill)
        return segment

    def opened(self, **fields: float) -> tuple[support.Segment, odom.Client]:
        """A segment with one pose, and its client."""
        segment = self.segment()
        segment.publish(**fields)
        return segment, self.client()

    def client(self) -> odom.Client:
        client = odom.Client(self.path)
        self.addCleanup(client.close)
        return client

    def assert_status(self, status: odom.Status, call: object, *arguments: object) -> None:
        assert callable(call)
        with self.assertRaises(odom.OdomError) as caught:
            call(*arguments)
        self.assertIs(caught.exception.status, status)

    def test_a_pose_arrives_as_it_was_published(self) -> None:
        segment = self.segment()
        client = self.client()
        self.assert_status(odom.Status.NO_POSE, client.latest)
        segment.publish(
            x=1.25, y=-2.5, yaw=7.0, vx=1.5, odom_x=3.0, variance_x=0.04, variance_yaw=0.25,
            mode=2, conditions=1 << 2 | 1 << 12, reset_count=3, health=1 << 9, jump_yaw=0.5,
            gyro_bias=0.01, camera_messages=9,
        )  # fmt: skip
        pose, details = client.latest_details()
        self.assertEqual(pose, client.latest())
        self.assertEqual((pose.tick, pose.x, pose.y, pose.yaw), (1, 1.25, -2.5, 7.0))
        self.assertEqual((pose.vx, pose.odom_x, pose.jump_yaw), (1.5, 3.0, 0.5))
        self.assertEqual((pose.sigma_x, pose.sigma_y, pose.sigma_yaw), (0.2, 0.0, 0.5))
        self.assertEqual((pose.position_sigma, pose.mode_name), (0.2, "dead_reckoning"))
        self.assertIs(pose.mode, odom.Mode.DEAD_RECKONING)
        self.assertEqual(pose.conditions, odom.Conditions.BUS_DOWN | odom.Conditions.INPUT_ENDED)
        self.assertEqual(pose.reset_count, 3)
        self.assertTrue(pose.is_healthy(odom.Source.STEERING))
        self.assertFalse(pose.is_healthy(odom.Source.CAMERA))
        self.assertEqual((details.gyro_bias, details.camera_messages), (0.01, 9))
        self.assertEqual(len(details.source_age_ns), 16)
        self.assertEqual(pickle.loads(pickle.dumps(pose)), pose)
        self.assertFalse(client.stale)

    def test_a_pose_at_a_past_time_is_interpolated(self) -> None:
        segment = self.segment()
        now = time.monotonic_ns()
        for tick in range(1, 6):
            segment.publish(tick=tick, time_ns=now + tick * 10_000_000, x=tick * 0.01, vx=1.0)
        client = self.client()
        self.assertAlmostEqual(client.at(now + 25_000_000).x, 0.025, places=9)
        self.assertEqual(client.at(now + 30_000_000).tick, 3)
        self.assert_status(odom.Status.TOO_OLD, client.at, now)
        self.assert_status(odom.Status.TOO_NEW, client.at, now + 60_000_000)
        self.assertAlmostEqual(client.predict(now + 25_000_000).x, 0.025, places=9)
        self.assertAlmostEqual(client.predict(now + 70_000_000).x, 0.07, places=9)

    def test_a_pose_is_predicted_at_most_100_ms_ahead(self) -> None:
        pose = self.opened(x=1.0, yaw=math.pi / 2, vx=2.0, variance_x=0.01, reset_count=4)[1].latest()
        ahead = odom.predict(pose, pose.time_ns + 100_000_000)
        self.assertAlmostEqual(ahead.x, 1.0, places=9)
        self.assertAlmostEqual(ahead.y, 0.2, places=9)
        self.assertEqual((ahead.tick, ahead.reset_count), (pose.tick, 4))
        self.assertGreater(ahead.sigma_x, pose.sigma_x)
        self.assert_status(odom.Status.TOO_NEW, odom.predict, pose, pose.time_ns + 100_000_001)
        self.assert_status(odom.Status.TOO_OLD, odom.predict, pose, pose.time_ns - 1)
        lost = pose._replace(mode=odom.Mode.INITIALISING)
        self.assert_status(odom.Status.NO_POSE, odom.predict, lost, pose.time_ns)

    def test_a_wait_ends_with_the_next_pose_while_other_threads_run(self) -> None:
        segment, client = self.opened(x=1.0)
        first = client.latest()
        arrived: list[odom.Pose] = []
        waiter = threading.Thread(target=lambda: arrived.append(client.wait(first, support.TIMEOUT)))
        waiter.start()
        support.await_(client._in_use._lock.locked)
        with self.assertRaisesRegex(RuntimeError, "one thread at a time"):
            client.info()
        segment.publish(x=2.0)
        waiter.join(support.TIMEOUT)
        self.assertEqual([pose.x for pose in arrived], [2.0])

    def test_a_long_wait_takes_the_first_pose_that_there_is(self) -> None:
        segment = self.segment()
        client = self.client()
        arrived: list[odom.Pose] = []
        waiter = threading.Thread(target=lambda: arrived.append(client.wait(None, support.TIMEOUT)))
        waiter.start()
        waiter.join(0.5)  # long enough to look twice without finding a pose
        while waiter.is_alive():  # on a busy machine the waiter may not even have begun
            segment.publish(x=1.0)
            waiter.join(0.5)
        self.assertEqual([pose.x for pose in arrived], [1.0])

    def test_a_wait_without_a_pose_times_out(self) -> None:
        segment = self.segment()
        client = self.client()
        self.assert_status(odom.Status.TIMEOUT, client.wait, None, 0.0)
        segment.publish(x=1.0)
        pose = client.latest()
        self.assert_status(odom.Status.TIMEOUT, client.wait, pose, 0.01)
        self.assert_status(odom.Status.TIMEOUT, client.wait, None, 0.3)  # longer than a slice
        for timeout in (-1.0, math.nan, math.inf):
            self.assertRaises(ValueError, client.wait, pose, timeout)

    def test_memory_of_ones_own_is_filled_again_and_again(self) -> None:
        segment = self.segment()
        client = self.client()
        raw = odom.PoseStruct()
        self.assertIs(client.read_into(raw), odom.Status.NO_POSE)
        segment.publish(x=1.0)
        self.assertIs(client.read_into(raw), odom.Status.OK)
        self.assertEqual((raw.tick, raw.x), (1, 1.0))
        segment.publish(x=2.0)
        self.assertIs(client.wait_into(raw, support.TIMEOUT), odom.Status.OK)
        self.assertEqual((raw.tick, raw.x), (2, 2.0))
        self.assertIs(client.wait_into(raw, 0.0), odom.Status.TIMEOUT)
        self.assertEqual((raw.tick, raw.x), (2, 2.0))

    def test_silence_raises_and_carries_the_last_pose(self) -> None:
        segment, client = self.opened(x=1.0, gyro_bias=0.5)
        segment.silence()
        self.assertTrue(client.stale)
        with self.assertRaises(odom.StaleError) as caught:
            client.latest()
        self.assertEqual(caught.exception.pose.x, 1.0)
        self.assertIs(caught.exception.status, odom.Status.STALE)
        with self.assertRaises(odom.StaleError) as caught:
            client.latest_details()
        assert caught.exception.details is not None
        self.assertEqual(caught.exception.details.gyro_bias, 0.5)
        with self.assertRaises(odom.StaleError) as waited:
            client.wait(caught.exception.pose, 0.3)
        self.assertEqual(waited.exception.pose.x, 1.0)
        self.assertEqual(client.info().period_ns, round(SLOW * 1e9))  # of the last segment

    def test_reports_info_and_beat(self) -> None:
        segment = self.segment(0.5)
        segment.publish()
        segment.send("missed 7")
        client = self.client()
        info = client.info()
        self.assertEqual((info.period_ns, info.model, info.version), (500_000_000, "paper", "0.1.0"))
        self.assertEqual((info.front_axle, info.slots, info.abi_major), (0.175, 256, 1))
        beat = client.beat()
        self.assertEqual((beat.ticks, beat.missed, len(beat.wakeup)), (1, 7, 64))
        now = time.monotonic_ns()
        self.assertEqual(client.to_clock(odom.Clock.REALTIME, now), now + info.realtime_offset_ns)
        self.assert_status(odom.Status.INVALID, client.to_clock, odom.Clock.LOG, now)

    def test_reports_what_cannot_be_opened(self) -> None:
        self.assert_status(odom.Status.NO_SEGMENT, odom.Client, self.path)
        self.assert_status(odom.Status.INVALID, odom.Client, "no-slash")
        self.assert_status(odom.Status.INVALID, odom.Client, "/with\0nul")
        self.path.write_bytes(bytes(8192))
        self.path.chmod(0o600)
        self.assert_status(odom.Status.ABI, odom.Client, self.path)
        self.path.chmod(0o666)
        self.assert_status(odom.Status.REFUSED, odom.Client, self.path)
        with self.assertRaisesRegex(odom.OdomError, "is odomd running"):
            odom.Client(self.path.with_name("elsewhere"))

    def test_a_closed_client_answers_invalid(self) -> None:
        segment = self.segment()
        segment.publish()
        with odom.Client(self.path) as client:
            client.latest()
        self.assert_status(odom.Status.INVALID, client.latest)
        client.close()


if __name__ == "__main__":
    unittest.main()
