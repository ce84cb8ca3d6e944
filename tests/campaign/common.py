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
from typing import Any

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
ODOM = pathlib.Path(os.environ.get("ODOM", ROOT / "build/release/bin/odom"))
PROCESSORS = len(os.sched_getaffinity(0))
DEGREES = 180 / math.pi


@dataclasses.dataclass(frozen=True)
class Row:
    """A bar's row in the table."""
    what: str
    required: str
    measured: str
    met: bool


class Failed(Exception):
    """A failed command, described in one line."""


def geometric_mean(values: list[float]) -> float:
    return math.exp(statistics.fmean(math.log(max(value, 1e-9)) for value in values))


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


@contextlib.contextmanager
def named(what):
    """Puts `what` before the message of a failure inside."""
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
                    print(f"\r{done} of {len(tasks)} drives ", end="", file=sys.stderr, flush=True)
            return [one.result() for one in started]
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
        finally:
            if sys.stderr.isatty():
                print(file=sys.stderr)


def each_drive(given, measure, tasks):
    """The results of `measure(course, seed, folder, scratch)` for the tasks (course, seed); the folder stays with --work."""
    def one(course, seed):
        with tempfile.TemporaryDirectory(prefix="drive-") as name, named(f"{course.name}, seed {seed}"):
            scratch = pathlib.Path(name)
            return measure(course, seed, (given.work or scratch / "drives") / course.name / str(seed), scratch)

    return side_by_side(given.jobs, one, tasks)


def parser(doc, seeds=None, what="drives of each course", jobs=True, odom=True):
    """A parser for a campaign with this docstring."""
    made = argparse.ArgumentParser(description=doc.splitlines()[0])
    if seeds:
        made.add_argument("--seeds", type=int, default=seeds, metavar="N", help=f"{what}; default: {seeds}")
    if jobs:
        made.add_argument("--jobs", type=int, default=PROCESSORS, metavar="N",
                          help="in parallel; default: one per processor")
    if odom:
        made.add_argument("--odom", type=pathlib.Path, default=ODOM, metavar="FILE",
                          help="the program; default: $ODOM, else the one of the release build")
    return made


def add_work(made):
    made.add_argument("--work", type=pathlib.Path, metavar="DIR",
                      help="keep the simulated drives here, and reuse existing ones: "
                           "empty it when the simulator has changed")


def add_bars(made, bars):
    """The options of a campaign that compares a model with bars."""
    made.add_argument("--only", action="append", choices=bars, metavar="BAR",
                      help=f"this bar; several times: these. One of {', '.join(bars)}")
    made.add_argument("--slack", type=float, default=1.0, metavar="X",
                      help="widen the limits by this factor: figures of a few seeds scatter")
    made.add_argument("--model", default="full", help="the model to evaluate; default: full")
    made.add_argument("--json", type=pathlib.Path, metavar="FILE", help="write all figures as JSON")
    add_work(made)


def parse(made):
    given = made.parse_args()
    if any(getattr(given, name, 1) < 1 for name in ("seeds", "jobs")) or not getattr(given, "slack", 1.0) >= 1:
        made.error("1 or more: " + ", ".join(f"--{name}" for name in ("seeds", "jobs", "slack") if hasattr(given, name)))
    require_program(made, getattr(given, "odom", None))
    return given


def require_program(made, program):
    if program and not os.access(program, os.X_OK):
        made.error(f"{program} is missing: cmake --preset release && cmake --build --preset release")


def finish(name: str, begun: datetime.datetime, rows: list[Any], file: pathlib.Path | None,
           figures: dict[str, Any]) -> int:
    """Writes the figures and the last line. Returns 1 if one of the rows, (bar, row), is not met, otherwise 0."""
    if file:
        document = {**figures, "rows": [{"bar": bar, **vars(row)} for bar, row in rows]}
        file.write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n")
    missed = sum(not row.met for _, row in rows)
    return last_words(name, begun, f"{len(rows) - missed} bars met, {missed} missed", missed)


def last_words(name, begun, text, bad):
    """Prints the dated last line; returns the exit status."""
    took = (datetime.datetime.now(datetime.timezone.utc) - begun).total_seconds()
    print(f"{begun:%F} {name}: {text}, in {took:.0f} s")
    return 1 if bad else 0


def now():
    return datetime.datetime.now(datetime.timezone.utc)


def table(rows):
    yield "| bar | what | required | measured | met |"
    yield "|---|---|---|---|---|"
    for bar, row in rows:
        yield f"| {bar} | {row.what} | {row.required} | {row.measured} | {'yes' if row.met else '**no**'} |"


def main(campaign):
    """Runs a campaign and exits with its status, or with 1 and a line if the work failed."""
    try:
        sys.exit(campaign())
    except (Failed, OSError) as error:
        sys.exit(f"{pathlib.Path(sys.argv[0]).stem}: {error}")
