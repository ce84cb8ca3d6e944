#!/usr/bin/env python3
"""Measures the power of the unit tests: how many small changes of the code (mutants) an area's own tests find.

All mutants are built at once, into a copy of the tree in build/mutants; ODOMD_MUTANT selects the active one. An area's
tests are those in the mirror of its folder. A crash and a timeout count as killed. No test can find a mutant that is
equivalent to the original, so that a rate of 100 % is out of reach.
"""

import hashlib
import json
import os
import pathlib
import resource
import signal
import subprocess
import sys
import tempfile
import time

import common
from mutants import places, tree

AREAS = {"can_protocol": "can_protocol/", "shm_api": "shm_api/", "configuration": "daemon/core/config",
         "estimator": "estimator/", "evaluation": "tools/evaluation/"}


def choose(area, seed, count):
    """Mutants in the order of their digests, so that a change elsewhere in the tree does not change the choice."""
    found = [mutant for name in tree.files(AREAS[area] + "*") if name.endswith((".cpp", ".c"))
             for mutant in places.Source(name, (common.ROOT / name).read_text(encoding="utf-8")).mutants()]
    found.sort(key=lambda mutant: hashlib.sha256(f"{seed} {mutant.key}".encode()).digest())
    chosen: list[places.Mutant] = []
    for mutant in found:
        if len(chosen) < count and not any(mutant.cuts(other) for other in chosen):
            chosen.append(mutant)
    return chosen


def own_tests(area, program):
    """The filter for the program's tests in the mirror of the area."""
    with tempfile.NamedTemporaryFile(suffix=".json") as listed:
        subprocess.run([program, "--gtest_list_tests", f"--gtest_output=json:{listed.name}"],
                       stdout=subprocess.DEVNULL, check=True)
        suites = json.load(listed)["testsuites"]
    return ":".join(f"{suite['name']}.{test['name']}" for suite in suites for test in suite["testsuite"]
                    if test["file"].startswith(str(tree.COPY / "tests" / AREAS[area])))


def run(program, tests, mutant, limit):
    """The duration of the tests [s]; None if one fails or if they take longer than the limit."""
    begun = time.monotonic()
    with tempfile.TemporaryDirectory() as scratch:
        process = subprocess.Popen(
            [program], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            start_new_session=True, cwd=scratch,
            env={**os.environ, "ODOMD_MUTANT": str(mutant), "GTEST_FAIL_FAST": "1", "GTEST_FILTER": tests,
                 "TMPDIR": scratch, "TEST_TMPDIR": scratch})
        try:
            status = process.wait(limit)
        except subprocess.TimeoutExpired:
            status = None
        finally:
            try:
                os.killpg(process.pid, signal.SIGKILL)  # including programs that the tests started
            except ProcessLookupError:
                pass
            process.wait()
    return time.monotonic() - begun if status == 0 else None


def survivors(area, mutants, jobs):
    """The mutants, {mutant: number}, that no test kills."""
    programs = [(path, tests) for path in tree.programs(AREAS[area]).values() if (tests := own_tests(area, path))]
    timed = []
    for path, tests in programs:  # as many in parallel as later, to show that they do not disturb each other
        times = common.side_by_side(jobs, run, jobs * [(path, tests, 0, 900)])
        if None in times:
            sys.exit(f"mutants: {path.name} fails without a mutant")
        timed.append((max(times), path, tests))
    timed.sort()
    print(f"{area}: {sum(seconds for seconds, *_ in timed):.1f} s without a mutant", file=sys.stderr)

    def survives(number):  # a test may fail by chance: only two failures kill
        return all(any(run(path, tests, number, 10 + 5 * seconds) for _ in range(2)) for seconds, path, tests in timed)

    survived = common.side_by_side(jobs, survives, [(number,) for number in mutants.values()])
    alive = [mutant for mutant, lives in zip(mutants, survived) if lives]
    print(f"{area}: {len(alive)} of {len(mutants)} survive", file=sys.stderr)
    return sorted(alive, key=lambda mutant: (mutant.file, mutant.line))


def options():
    made = common.parser(__doc__, programs=())
    made.add_argument("--seed", type=int, default=1, help="of the choice; default: 1")
    made.add_argument("--mutants", type=int, default=60, metavar="N", help="of each area; default: 60")
    made.add_argument("--area", action="append", choices=AREAS, help="this area; several times: these")
    made.add_argument("--list", action="store_true", help="only print the mutants, with a third to spare")
    made.add_argument("--json", type=pathlib.Path, metavar="FILE", help="write the result as JSON")
    made.add_argument("--baseline", type=pathlib.Path, metavar="FILE", help="fail if a rate is below this result's")
    given = common.parse(made)
    if given.mutants < 1:
        made.error("--mutants: 1 or more")
    return given


def main():
    given = options()
    areas = given.area or list(AREAS)
    # A third more than needed, because some do not compile.
    chosen = {area: choose(area, given.seed, given.mutants + given.mutants // 3) for area in areas}
    every = [mutant for area in areas for mutant in chosen[area]]
    if given.list:
        print(*(f"{mutant.file}:{mutant.line}: {mutant.before}\n    {mutant.after}" for mutant in every), sep="\n")
        return 0
    before = json.loads(given.baseline.read_text(encoding="utf-8")) if given.baseline else {}
    if before and before.get("seed") != given.seed:
        sys.exit(f"mutants: {given.baseline} has other mutants, of seed {before.get('seed', 'unknown')}: use that --seed, or write it again with --json")
    numbers = tree.build({mutant: i for i, mutant in enumerate(every, start=1)},
                         [AREAS[area] for area in areas], given.jobs)
    for what, limit in ((resource.RLIMIT_CORE, 0), (resource.RLIMIT_AS, 4 << 30), (resource.RLIMIT_FSIZE, 1 << 30)):
        resource.setrlimit(what, (limit, limit))  # a mutant may request any amount
    result, rows, fallen = {"seed": given.seed}, ["| area | mutants | killed | rate |", "|---|---|---|---|"], []
    for area in areas:
        mutants = dict([(mutant, numbers[mutant]) for mutant in chosen[area] if mutant in numbers][:given.mutants])
        alive = survivors(area, mutants, given.jobs)
        killed = len(mutants) - len(alive)
        rate = killed / max(len(mutants), 1)
        for mutant in alive:
            print(f"{mutant.file}:{mutant.line}: {mutant.before}\n    {mutant.after}", flush=True)
        rows.append(f"| {area} | {len(mutants)} | {killed} | {100 * rate:.0f} % |")
        if rate < before.get(area, {"rate": 0})["rate"]:
            fallen.append(f"{area}: the rate was {100 * before[area]['rate']:.0f} %")
        result[area] = {"mutants": len(mutants), "killed": killed, "rate": rate,
                        "survivors": [mutant.key for mutant in alive]}
        if given.json:
            given.json.write_text(json.dumps(result, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    print(*rows, *fallen, sep="\n")
    killed, of = (sum(result[area][key] for area in areas) for key in ("killed", "mutants"))
    return common.last_words(f"{killed} of {of} killed", fallen)


if __name__ == "__main__":
    common.main(main)
