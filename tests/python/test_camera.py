"""The camera's side, against a socket that stands for the daemon's."""

from __future__ import annotations

import math
import socket
import unittest

import odom
import support
from odom._library import CameraMessageStruct


class Camera(unittest.TestCase):
    def setUp(self) -> None:
        self.directory = support.Directory()
        self.addCleanup(self.directory.remove)
        self.path = self.directory.path / "camera.sock"

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
        with self.assertRaises(OSError):
            camera.send(5, math.nan, 2.0, 3.0, sigma_x=0.1, sigma_y=0.2, sigma_yaw=0.3)
        with self.assertRaises(OSError):
            camera.send(5, 1.0, 2.0, 3.0, sigma_x=0.0, sigma_y=0.2, sigma_yaw=0.3)
        camera.close()
        with self.assertRaises(OSError):
            camera.send(5, 1.0, 2.0, 3.0, sigma_x=0.1, sigma_y=0.2, sigma_yaw=0.3)


if __name__ == "__main__":
    unittest.main()
