"""The figures of docs/tutorial.md that replays give: its commands of steps 1, 2, 3 and 9 are run as printed."""

import pathlib
import re
import subprocess
import tempfile
import unittest

PAGE = (pathlib.Path(__file__).resolve().parents[2] / "docs/tutorial.md").read_text(encoding="utf-8")


def step(number):
    """The text of a step."""
    return re.search(rf"^## {number}\. (.*?)(?=^## )", PAGE, re.MULTILINE | re.DOTALL)[1]


def printed(number, folder):
    """What the commands of a step print, and the rows of its last table: their numbers."""
    commands = "\n".join(line[4:] for line in step(number).splitlines() if line.startswith("    "))
    run = subprocess.run(["sh", "-ec", commands], cwd=folder, capture_output=True, text=True, check=True)
    rows = re.findall(r"^(\S.*?\]|NEES.*?\))((?: +-?[\d.]+)+)$", run.stdout, re.MULTILINE)
    return run.stderr, {name.strip(): [float(number) for number in numbers.split()] for name, numbers in rows}


class Tutorial(unittest.TestCase):
    def test_its_figures_are_those_of_its_commands(self):
        with tempfile.TemporaryDirectory() as folder:
            printed(1, folder)
            _, alone = printed(2, folder)
            _, both = printed(3, folder)
            warnings, broken = printed(9, folder)
        position, near = both["position rms [m]"], both["35 ms error mean [mm]"]
        faulty = broken["position rms [m]"]
        for number, figure in (
                (2, f"`end error` of {alone['end error [m]'][0]:.2f} m after {alone['path length [m]'][0]:.1f} m"),
                (2, f"`heading error at the end` of {alone['heading error at the end [deg]'][0]:.1f}°"),
                (3, f"falls from {1e3 * position[0]:.0f} mm (`odometry`) to {1e3 * position[1]:.0f} mm (`pose`)"),
                (3, f"({near[1]:.1f} mm instead of {near[0]:.1f} mm)"),
                (9, f"{1e3 * faulty[0]:.1f} mm with the camera ({1e3 * position[1]:.1f} mm in step 3)"),
                (9, f"{1e3 * faulty[1]:.0f} mm without it ({1e3 * position[0]:.0f} mm)")):
            self.assertIn(figure, " ".join(step(number).split()))
        warning = re.search(r"warns `([^`]+)`", step(9))[1]
        self.assertIn(warning, warnings)


if __name__ == "__main__":
    unittest.main()
