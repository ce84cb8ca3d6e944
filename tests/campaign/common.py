"""What the campaigns share: options of the command line, running programs, and many drives in parallel."""

import argparse
import concurrent.futures
import contextlib
import dataclasses
import datetime
import json
import math
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterator

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
DEGREES = 180 / math.pi
NAME = pathlib.Path(sys.argv[0]).stem
BEGUN = datetime.datetime.now(datetime.timezone.utc)


class Failed(Exception):
    """A failed command, described in one line."""


# Programs.

def last_line(text: str) -> str:
    lines = text.strip().splitlines()
    return lines[-1] if lines else ""


def run(*command: object) -> "subprocess.CompletedProcess[str]":
    words = [str(word) for word in command]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise Failed(f"{' '.join(words)}: {last_line(done.stderr) or f'exit status {done.returncode}'}")
    return done


def output(*command: object) -> str:
    return run(*command).stdout


def replay(odom, config, folder, poses, *options):
    """Replays a drive's log into a file of poses. Returns the JSON that the program prints."""
    done = run(odom, "replay", "--config", config, "--dbc", folder / "car.dbc", "--can", folder / "drive.log",
               "--out", poses, *options, "--json")
    return json.loads(last_line(done.stderr))


def evaluate(odom, folder, poses, *options):
    """The errors of files of poses against the drive's truth, as odom evaluate computes them."""
    files = [word for file in poses for word in ("--pose", file)]
    return json.loads(output(odom, "evaluate", "--reference", folder / "truth.csv", *files, *options,
                             "--json"))["estimates"]


@contextlib.contextmanager
def scratch() -> Iterator[pathlib.Path]:
    """A folder that is removed at the end."""
    with tempfile.TemporaryDirectory(prefix=f"{NAME}-") as folder:
        yield pathlib.Path(folder)


# Many drives.

@contextlib.contextmanager
def named(what):
    """Prefixes the message of a failure in the block with `what`."""
    try:
        yield
    except Failed as error:
        raise Failed(f"{what}: {error}") from error


def side_by_side(jobs, measure, tasks):
    """The results of `measure(*task)`, in the order of the tasks. Threads suffice: other programs do the work."""
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        started = [pool.submit(measure, *task) for task in tasks]
        try:
            for done, _ in enumerate(concurrent.futures.as_completed(started), start=1):
                if sys.stderr.isatty():
                    print(f"\r{done} of {len(tasks)} ", end="", file=sys.stderr, flush=True)
            return [one.result() for one in started]
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
        finally:
            if sys.stderr.isatty():
                print(file=sys.stderr)


def simulate(odom, options, seed, folder):
    """Runs odom sim, unless the folder already has the drive that this command makes."""
    command = [odom, "sim", *options, "--seed", seed]
    text = " ".join(str(word) for word in command[1:]) + "\n"
    made_by = folder / "command"
    if made_by.exists() and made_by.read_text() == text:
        return
    folder.mkdir(parents=True, exist_ok=True)
    made_by.unlink(missing_ok=True)
    run(*command, "--out", folder, "--force")
    made_by.write_text(text)


def each_drive(given, tasks, measure):
    """Simulates drives, the tasks (name, options of odom sim, seed). Returns the results of
    `measure(name, seed, folder, work)`, where `work` is a scratch folder; the drive's folder stays with --work."""
    def one(name, options, seed):
        with scratch() as work, named(f"{name}, seed {seed}"):
            folder = (given.work or work / "drives") / name / str(seed)
            simulate(given.odom, options, seed, folder)
            return measure(name, seed, folder, work)

    return side_by_side(given.jobs, one, tasks)


# The command line.

def parser(doc, seeds=None, what="drives of each course", jobs=True, work=False, programs=("odom",)):
    """A parser for a campaign with this docstring, which runs these programs. `work`: for each_drive."""
    made = argparse.ArgumentParser(description=doc.splitlines()[0])
    made.set_defaults(programs=programs, bin=ROOT / "build/release/bin")
    if programs:
        made.add_argument("--bin", type=pathlib.Path, metavar="DIR", help="programs; default: build/release/bin")
    if seeds:
        made.add_argument("--seeds", type=int, default=seeds, metavar="N", help=f"{what}; default: {seeds}")
    if jobs:
        made.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)), metavar="N",
                          help="in parallel; default: one per processor")
    if work:
        made.add_argument("--work", type=pathlib.Path, metavar="DIR",
                          help="keep the simulated drives here, and reuse existing ones: "
                               "empty it when the simulator has changed")
    return made


def parse(made):
    given = made.parse_args()
    if any(getattr(given, name, 1) < 1 for name in ("seeds", "jobs", "kills")) or not getattr(given, "slack", 1.0) >= 1:
        made.error("1 or more: " + ", ".join(f"--{name}" for name in ("seeds", "jobs", "kills", "slack") if hasattr(given, name)))
    given.bin = given.bin.resolve()
    for program in given.programs:
        if not os.access(given.bin / program, os.X_OK):
            made.error(f"{given.bin / program} is missing: cmake --preset release && cmake --build --preset release")
    given.odom = given.bin / "odom"
    return given


# Results.

@dataclasses.dataclass(frozen=True)
class Row:
    """A bar's row in the table."""
    what: str
    required: str
    measured: str
    met: bool


def geometric_mean(values: list[float]) -> float:
    return math.exp(statistics.fmean(math.log(max(value, 1e-9)) for value in values))


def table(rows):
    yield "| bar | what | required | measured | met |"
    yield "|---|---|---|---|---|"
    for bar, row in rows:
        yield f"| {bar} | {row.what} | {row.required} | {row.measured} | {'yes' if row.met else '**no**'} |"


def finish(rows):
    """Prints the last line. Returns 1 if one of the rows, (bar, row), is not met, otherwise 0."""
    missed = sum(not row.met for _, row in rows)
    return last_words(f"{len(rows) - missed} bars met, {missed} missed", missed)


def last_words(text, bad):
    """Prints the dated last line; returns the exit status."""
    took = (datetime.datetime.now(datetime.timezone.utc) - BEGUN).total_seconds()
    print(f"{BEGUN:%F} {NAME}: {text}, in {took:.0f} s")
    return 1 if bad else 0


def main(campaign):
    """Runs a campaign and exits with its status, or with 1 and a line if the work failed."""
    try:
        sys.exit(campaign())
    except (Failed, OSError) as error:
        sys.exit(f"{NAME}: {error}")
