"""What the campaigns share: options of the command line, programs that are run, and many drives side by side."""

import argparse
import concurrent.futures
import datetime
import json
import os
import pathlib
import subprocess
import sys
from typing import Any

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent


class Failed(Exception):
    """A command that failed; in one line."""


def last_line(text: str) -> str:
    lines = text.strip().splitlines()
    return lines[-1] if lines else ""


def run(*command: object) -> "subprocess.CompletedProcess[str]":
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise Failed(last_line(done.stderr) or f"{command[0]}: exit status {done.returncode}")
    return done


def side_by_side(jobs, measure, tasks):
    """The results of `measure(*task)`, in the order of the tasks."""
    with concurrent.futures.ProcessPoolExecutor(jobs) as pool:
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


def parser(doc, seeds):
    """For a campaign with this docstring, over so many drives of each course."""
    made = argparse.ArgumentParser(description=doc.splitlines()[0])
    made.add_argument("--seeds", type=int, default=seeds, metavar="N",
                      help=f"drives of each course; default: {seeds}")
    made.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)), metavar="N",
                      help="drives in parallel; default: one per processor")
    return made


def add_work(made):
    made.add_argument("--work", type=pathlib.Path, metavar="DIR",
                      help="keep the simulated drives here, and reuse existing ones: "
                           "empty it when the simulator has changed")


def add_bars(made, bars):
    """For a campaign that holds a model to bars."""
    made.add_argument("--only", action="append", choices=bars, metavar="BAR",
                      help=f"this bar; several times: these. One of {', '.join(bars)}")
    made.add_argument("--slack", type=float, default=1.0, metavar="X",
                      help="widen the limits by this factor: figures of a few seeds scatter")
    made.add_argument("--model", default="full", help="the model to evaluate; default: full")
    made.add_argument("--json", type=pathlib.Path, metavar="FILE", help="write all figures as JSON")
    made.add_argument("--odom", type=pathlib.Path, default=ROOT / "build/release/bin/odom", metavar="FILE",
                      help="the program; default: the one of the release build")
    add_work(made)


def parse(made):
    given = made.parse_args()
    if given.seeds < 1 or given.jobs < 1 or not getattr(given, "slack", 1.0) >= 1:
        made.error("--seeds, --jobs and --slack: 1 or more")
    require_program(made, getattr(given, "odom", None))
    return given


def require_program(made, program):
    if program and not os.access(program, os.X_OK):
        made.error(f"{program} is missing: cmake --preset release && cmake --build --preset release")


def finish(name: str, begun: datetime.datetime, rows: list[Any], file: pathlib.Path | None,
           figures: dict[str, Any]) -> None:
    """Writes the figures and the last line, and ends with 1 if one of the rows, (bar, row), is not met."""
    if file:
        document = {**figures, "rows": [{"bar": bar, **vars(row)} for bar, row in rows]}
        file.write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n")
    missed = sum(not row.met for _, row in rows)
    took = (datetime.datetime.now(datetime.timezone.utc) - begun).total_seconds()
    print(f"{begun:%F} {name}: {len(rows) - missed} bars met, {missed} missed, in {took:.0f} s")
    sys.exit(1 if missed else 0)


def table(rows):
    yield "| bar | what | required | measured | met |"
    yield "|---|---|---|---|---|"
    for bar, row in rows:
        yield f"| {bar} | {row.what} | {row.required} | {row.measured} | {'yes' if row.met else '**no**'} |"
