"""The control loops of README.md, docs/shm.md and libodom(3): they compile, and they steer only with a fresh pose whose
mode and sigma they have checked. Each runs on a stand-in for libodom, which supplies one pose after another.
"""

import enum
import os
import pathlib
import re
import subprocess
import tempfile
import textwrap
import types
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
C = [os.environ.get("CC", "cc"), "-std=c11"]

# mode, standard deviation of the position [m] (the loop allows 0.3 m), expected action
POSES = [
    ("TRACKING", 0.1, "steer"),
    ("TRACKING", 0.5, "stop"),
    ("INITIALISING", 0.1, "stop"),
    ("DEAD_RECKONING", 0.25, "steer"),
    ("FAULT", 0.1, "stop"),
    ("DEGRADED", 136.0, "stop"),
    ("DEGRADED", 0.1, "steer"),
    ("TRACKING", float("nan"), "stop"),
]
EXPECTED = [action for _, _, action in POSES] + ["stop"]  # at the end the daemon is silent

STAND_IN = """
#include <odom/odom.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void steer(const odom_pose* pose) { (void)pose; puts("steer"); }
static void stop(void) { puts("stop"); }
static const struct { unsigned mode; double sigma; } given[] = {%s};
enum { COUNT = sizeof given / sizeof *given };
static int next;

odom_status odom_open(const char* name, odom_client** client) {
  (void)name;
  *client = (odom_client*)calloc(1, 1);
  return ODOM_OK;
}
odom_status odom_wait(odom_client* client, odom_pose* pose, size_t size, int64_t timeout_ns) {
  (void)client, (void)timeout_ns;
  if (next > COUNT) exit(0);
  const int now = next++;
  if (now == COUNT) return ODOM_STALE;
  memset(pose, 0, size);
  pose->tick = (uint64_t)now + 1;
  pose->mode = given[now].mode;
  pose->covariance[0] = pose->covariance[3] = given[now].sigma * given[now].sigma;
  return ODOM_OK;
}
odom_status odom_predict(const odom_pose* from, int64_t time_ns, odom_pose* to) {
  (void)time_ns;
  if (from->mode == ODOM_INITIALISING) return ODOM_NO_POSE;
  *to = *from;
  return ODOM_OK;
}
"""


def blocks(path: str, language: str) -> list[str]:
    text = (ROOT / path).read_text()
    return [textwrap.dedent(b) for b in re.findall(rf"^ *```{language}\n(.*?)^ *```", text, re.M | re.S)]


def loop_of(path: str, language: str) -> str:
    """The block that steers."""
    (loop,) = [block for block in blocks(path, language) if "steer(" in block]
    return loop


def stand_in(limit: float = 0.3) -> str:
    given = ", ".join(f"{{ODOM_{mode}, {'0.0 / 0.0' if sigma != sigma else sigma / 0.3 * limit}}}"
                      for mode, sigma, _ in POSES)
    return STAND_IN.replace("%s", given)


class Loops(unittest.TestCase):
    def steer_as_expected(self, compiler: list[str], suffix: str, program: str) -> None:
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            source = folder / f"loop{suffix}"
            source.write_text(program)
            pose = folder / "pose.o"  # odom_position_sigma, odom_mode_name
            include = f"-I{ROOT / 'shm_api/include'}"
            subprocess.run([*C, include, "-c", ROOT / "shm_api/libodom/pose.c", "-o", pose], check=True)
            subprocess.run([*compiler, "-Wall", "-Wextra", "-Werror", "-Wno-unused-function", "-Wno-div-by-zero",
                            include, source, pose, "-lm", "-o", folder / "loop"], check=True)
            done = subprocess.run([folder / "loop"], capture_output=True, text=True, timeout=20, check=False)
            self.assertEqual(done.stdout.splitlines(), EXPECTED)

    def test_the_readme(self) -> None:
        body = loop_of("README.md", "c").replace("#include <odom/odom.h>\n", "")
        (limit,) = re.findall(r"odom_position_sigma\(&ahead\) <= ([0-9.]+)", body)
        self.steer_as_expected(C, ".c", f"{stand_in(float(limit))}\nint main(void) {{\n{body}\nreturn 0;\n}}\n")

    def test_the_manual_page(self) -> None:
        page = (ROOT / "man/libodom.3").read_text()
        (loop,) = re.findall(r"^\.Bd -literal[^\n]*\n(.*?)^\.Ed", page, re.M | re.S)
        self.steer_as_expected(C, ".c", f"{stand_in()}\n{loop}")

    def test_the_page_in_cpp(self) -> None:
        body = loop_of("docs/shm.md", "cpp")
        unused = "".join(f"odom_status {name} {{ return ODOM_INVALID; }}\n" for name in (
            "odom_latest(odom_client*, odom_pose*, size_t)", "odom_at(odom_client*, int64_t, odom_pose*, size_t)"))
        program = (f"#include <odom/odom.hpp>\nextern \"C\" {{{stand_in()}{unused}\n"
                   f"void odom_close(odom_client* client) {{ free(client); }}}}\n"
                   f"static void steer(const odom::Pose& pose) {{ steer(&pose); }}\n"
                   f"int main() {{\n{body}\nreturn 0;\n}}\n")
        self.steer_as_expected([os.environ.get("CXX", "c++"), "-std=c++17"], ".cpp", program)

    def test_the_page_in_python(self) -> None:
        class OdomError(Exception):
            pass

        class Silent(Exception):
            pass

        # The real record needs libodom; this one has its mode and sigma.
        mode = enum.Enum("Mode", ["INITIALISING", "TRACKING", "DEAD_RECKONING", "DEGRADED", "STANDSTILL", "FAULT"])
        left = [types.SimpleNamespace(mode=mode[m], position_sigma=s, time_ns=0) for m, s, _ in POSES]
        ended = []

        class Client:
            def __enter__(self):
                return self

            def __exit__(self, *_):
                return False

            def wait(self, pose, timeout):
                if left:
                    return left.pop(0)
                if ended:
                    raise Silent
                ended.append(True)
                raise OdomError

        def predict(pose, time_ns):
            if pose.mode is mode.INITIALISING:
                raise OdomError
            return pose

        actions: list[str] = []
        names = {"odom": types.SimpleNamespace(Client=Client, predict=predict, Mode=mode, OdomError=OdomError),
                 "steer": lambda pose: actions.append("steer"), "stop": lambda: actions.append("stop")}
        with self.assertRaises(Silent):
            exec(loop_of("docs/shm.md", "python").replace("import odom\n", ""), names)
        self.assertEqual(actions, EXPECTED)


if __name__ == "__main__":
    unittest.main()
