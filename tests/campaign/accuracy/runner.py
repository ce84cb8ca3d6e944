"""Runs many drives in parallel, and prints the table of their bars."""

import concurrent.futures
import sys


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


def table(rows):
    yield "| bar | what | required | measured | met |"
    yield "|---|---|---|---|---|"
    for bar, row in rows:
        yield f"| {bar} | {row.what} | {row.required} | {row.measured} | {'yes' if row.met else '**no**'} |"
