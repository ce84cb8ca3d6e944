"""Runs the commands of pages that need neither CAN nor root, as printed except for stated changes. BLOCKS says which
are not run; shown_commands.py --options checks their options. Of docs/tutorial.md, steps 1, 2, 3, 9 and 10 run, without the fit.
"""

import contextlib
import os
import re
import resource
import shutil
import socket
import subprocess
import tempfile
import textwrap
import unittest
import xml.etree.ElementTree

from shown_commands import ROOT, end, run

USER = "daemon" if os.geteuid() == 0 else None  # a user without privileges
BLOCKS = {  # each page's indented blocks, by their first words: RUN, or why they are not run
    "README.md": {"sudo apt install ./{odomd,odom-tools,odom-web}": "RUN", "git clone": "tests/tools/demo_test.cpp",
                  "sudo apt install ./{odomd,odom-tools,lib": "root", "odomd --config": "root", "odom record": "a car"},
    "docs/your-computer.md": {"dtparam": "settings", "odomd": "RUN"},
    "docs/web.md": {"odom serve ": "as in RUN, without a token", "(umask": "RUN", "odom status": "RUN",
                    "sudo sh": "root; tests/lab/systemd/web.sh"},
    "docs/bridge.md": {"odom bridge  ": "RUN", "odom bridge --frame-base": "RUN", "sudo systemctl": "root",
                       "[Service]": "settings", '{"timestamp"': "RUN"},
    "docs/camera.md": {"apriltag_camera": "a camera; tests/examples/apriltag_camera_test.cpp"},
}
TEXT = {page: (ROOT / page).read_text(encoding="utf-8") for page in BLOCKS}
TUTORIAL = (ROOT / "docs/tutorial.md").read_text(encoding="utf-8")
GET = r"""get() { exec 4<>/dev/tcp/127.0.0.1/$(sed 's/.*:\([0-9]*\).*/\1/' web)
  printf 'GET %s HTTP/1.0\r\nHost: localhost\r\nCookie: %s\r\n\r\n' "$@" >&4; grep -E 'HTTP|Cookie|odom_up' <&4; }; """


def blocks(page):
    text = re.sub(r"^ *```.*?^ *```$", "", TEXT[page], flags=re.MULTILINE | re.DOTALL)
    return [textwrap.dedent(block).strip() for block in re.findall(r"(?<=\n\n)(?: {4,}.*\n)+", text)]


def block(page, start, *changes):
    """The block that begins with `start`, after changes (pattern, replacement), each of which must match."""
    (text,) = (text for text in blocks(page) if text.startswith(start) and BLOCKS[page][start] == "RUN")
    for pattern, replacement in changes:
        assert re.search(pattern, text), f"{page}: no {pattern} in {text}"
        text = re.sub(pattern, replacement, text)
    return text


def step(number):
    """The text of a step of the tutorial."""
    return re.search(rf"^## {number}\. (.*?)(?=^## )", TUTORIAL, re.MULTILINE | re.DOTALL)[1]


def figures(number):
    """What a step's commands print, and the numbers of the rows in their last table, by name."""
    commands = "\n".join(line[4:] for line in step(number).splitlines()
                         if line.startswith("    ") and "odom identify fit" not in line)
    done = subprocess.run(["sh", "-ec", commands], capture_output=True, text=True, check=True)
    rows = re.findall(r"^(\S.*?\]|NEES.*?\))((?: +-?[\d.]+)+)$", done.stdout, re.MULTILINE)
    return done.stderr + done.stdout, {name.strip(): [float(number) for number in numbers.split()] for name, numbers in rows}


class Pages(unittest.TestCase):
    def setUp(self):
        folder = self.enterContext(tempfile.TemporaryDirectory())
        shutil.chown(folder, USER or os.geteuid())
        self.enterContext(contextlib.chdir(folder))
        os.environ.update(XDG_RUNTIME_DIR=folder, ODOM_SHM=folder + "/pose")
        resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))  # even if the user may have more
        self.groups = []
        self.printed = lambda commands: run(USER, commands, self.groups)
        self.addCleanup(end, self.groups)

    def start_car(self):
        """Starts odomd as in README.md. Returns the status once camera poses arrive."""
        return self.printed(block(
            "README.md", "sudo apt install ./{odomd,odom-tools,odom-web}", ("^sudo apt.*\n", ""),
            ("odomd --config", "odomd --shm $ODOM_SHM --config"),
            ("odom watch$", "until odom status | grep 'camera .*fine'; do sleep 0.2; done; odom status")))

    def test_every_block_runs_or_has_a_reason(self):
        for page, starts in BLOCKS.items():
            known = [start for text in blocks(page) for start in starts if text.startswith(start)]
            self.assertEqual((sorted(known), len(known)), (sorted(starts), len(blocks(page))), page)

    def test_a_simulated_car_drives_and_nobody_needs_root(self):
        self.assertRegex(self.start_car(), "(?s)degraded.*not_realtime")
        end(self.groups)
        self.assertRegex(self.printed(block(
            "docs/your-computer.md", "odomd", ("^odomd", "odom sim --live --out car --force 2>sim.log | odomd"),
            ("car.toml", "car/car.toml"), ("can0", "-"), ("/mine", "$PWD/mine"), ("\n", " 2>odomd.log &\n"),
            ("odom.*mine$", r"until \g<0> --once | grep -A4 degraded; do sleep 0.2; done"))), "not_realtime")

    @unittest.skipUnless(shutil.which("odom-web"), "not built")
    def test_a_phone_needs_the_token_once_and_metrics_are_the_daemons(self):
        self.start_car()
        self.assertRegex(
            self.printed(GET + block("docs/web.md", "(umask", (r"0\.0\.0\.0", "0.0.0.0:0")) + """ 2>web &
                until grep -s TOKEN web; do sleep 0.2; done
                get /; get "/?token=$(cat token)"; get /metrics "odom_token=$(cat token)" """),
            r"(?s) 401 .* 303 .*HttpOnly; SameSite=Strict.* 200 .*\nodom_up 1\n")
        metrics = block("docs/web.md", "odom status", ("/var/lib/node_exporter/", "")) + "; cat odom.prom"
        self.assertRegex(self.printed(metrics), "\nodom_up 1\n")
        end(self.groups)
        self.assertRegex(self.printed(metrics), "\nodom_up 0\n")

    def test_the_bridge_sends_what_its_page_shows(self):
        self.start_car()
        receiver = self.enterContext(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
        receiver.bind(("127.0.0.1", 0))
        receiver.settimeout(10)
        command = re.search("odom bridge --udp", block("docs/bridge.md", "odom bridge  "))[0]
        self.printed(f"{command} 127.0.0.1:{receiver.getsockname()[1]} --duration 1")
        shown, sent = block("docs/bridge.md", '{"timestamp"'), receiver.recv(65536).decode()
        self.assertEqual(set(re.findall(r'"\w+":', shown)).difference(re.findall(r'"\w+":', sent)), set())

    def test_the_bridge_takes_its_options_and_has_its_topics(self):
        page = TEXT["docs/bridge.md"]
        launch = xml.etree.ElementTree.fromstring(re.search("```xml\n(.*?)```", page, re.DOTALL)[1])
        lines = [launch.find("executable").get("cmd"), *re.findall("^ +(odom bridge[^#\n]*)", page, re.MULTILINE),
                 "odom bridge " + re.search('"ODOM_BRIDGE_OPTIONS=(.*)"', page)[1]]
        for line in lines:  # the domain is checked last
            self.assertTrue("--udp" in line or "not a domain" in self.printed(line + " --domain 999"), line)
        topics = re.findall(r"^- `/(\w+)` \(`(\w+)/msg/(\w+)`", page, re.MULTILINE)
        self.assertEqual([f'{package}_msg_dds__{kind}__desc, "rt/{name}"' for name, package, kind in topics],
                         re.findall(r'writer\((.*?),\s+\d', (ROOT / "tools/bridge/dds.cpp").read_text()))

    def test_the_tutorials_figures_are_those_of_its_commands(self):
        _, (_, alone), (_, both), (said, broken), (_, car) = map(figures, (1, 2, 3, 9, 10))
        position, near = both["position rms [m]"], both["35 ms error mean [mm]"]
        faulty = broken["position rms [m]"]
        for number, figure in (
                (2, f"`end error` of {alone['end error [m]'][0]:.2f} m after {alone['path length [m]'][0]:.1f} m"),
                (2, f"`heading error at the end` of {alone['heading error at the end [deg]'][0]:.1f}°"),
                (3, f"falls from {1e3 * position[0]:.0f} mm (`odometry`) to {1e3 * position[1]:.0f} mm (`pose`)"),
                (3, f"({near[1]:.1f} mm instead of {near[0]:.1f} mm)"),
                (9, f"{1e3 * faulty[0]:.1f} mm with the camera ({1e3 * position[1]:.1f} mm in step 3)"),
                (9, f"{1e3 * faulty[1]:.0f} mm without it ({1e3 * position[0]:.0f} mm)"),
                (10, f"instead of {1e3 * car['end error [m]'][0]:.0f} mm")):
            self.assertIn(figure, " ".join(step(number).split()))
        warning = re.search(r"warns `([^`]+)`", step(9))[1]
        self.assertIn(warning, said)
        self.assertNotIn("were gated", said)  # it is frozen: no second finding on the same samples
        self.assertIn("larger than that of faulty.", said)  # and no advice on sensors that both have


if __name__ == "__main__":
    unittest.main()
