"""The rooms of the tree: which folder may include which, and how large folders and files may become. Python's own
unittest; needs no build.

budget.txt has the total size that each room may have.

ROOMS is the one place where these arrows are written down. A folder may include itself and the folders after its
colon, which stand above it in the list: so there is no circle. The folders of one house stand together, so that there
is no circle between houses (tools/identify, tools, ...) either. A new arrow is added here; one that points down the
list would make a circle: move a file instead.
"""

import os
import pathlib
import re
import subprocess
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
HOUSES = ("base", "can_protocol", "estimator", "shm_api", "daemon", "tools")

ROOMS = """
base:

can_protocol:
can_protocol/dbc: base can_protocol
can_protocol/decode: base can_protocol can_protocol/dbc
can_protocol/sources: base can_protocol

estimator/common:
estimator/integrity: estimator/common
estimator/ekf: estimator/common estimator/integrity
estimator/baselines: estimator/common estimator/integrity
estimator: estimator/common estimator/ekf estimator/integrity estimator/baselines

shm_api/include/odom:
shm_api/layout: shm_api/include/odom
shm_api/libodom: shm_api/include/odom shm_api/layout
shm_api: base shm_api/include/odom shm_api/layout shm_api/libodom

daemon/diagnostics:
daemon/core: daemon/diagnostics base can_protocol can_protocol/dbc can_protocol/decode can_protocol/sources
    estimator/common estimator/ekf estimator/integrity estimator shm_api/include/odom
daemon/journal: base daemon/core
daemon/sockets: base can_protocol estimator/common shm_api/include/odom daemon/core daemon/journal
daemon/realtime: base can_protocol/sources shm_api/include/odom shm_api daemon/core daemon/journal daemon/sockets
daemon/housekeeping: base can_protocol can_protocol/sources estimator/common shm_api/include/odom shm_api
    daemon/core daemon/journal daemon/sockets daemon/realtime
daemon: daemon/diagnostics base can_protocol can_protocol/dbc can_protocol/decode can_protocol/sources
    shm_api/libodom shm_api daemon/core daemon/journal daemon/sockets daemon/realtime daemon/housekeeping

tools/math: estimator/common
tools/cli: base shm_api daemon/core
tools/diagnostics: daemon/diagnostics tools/cli
tools/drive_files: daemon/diagnostics base can_protocol can_protocol/sources estimator/common estimator/integrity
    shm_api/include/odom daemon/core tools/cli tools/diagnostics
tools/chart: tools/cli
tools/replay: daemon/diagnostics base can_protocol can_protocol/dbc can_protocol/decode can_protocol/sources
    estimator/common daemon/core tools/math tools/cli tools/drive_files tools/diagnostics
tools/evaluation: base daemon/diagnostics estimator/common daemon/core tools/math tools/cli tools/drive_files tools/chart
    tools/diagnostics tools/replay
tools/live: base can_protocol can_protocol/sources estimator/common shm_api/include/odom
    shm_api/libodom daemon/core tools/math tools/cli
tools/live/watch: base shm_api/include/odom shm_api daemon/core tools/cli tools/drive_files tools/live
tools/report: estimator/common daemon/core tools/math tools/cli tools/drive_files tools/chart tools/evaluation
    tools/live
tools/bridge: base estimator/common shm_api/include/odom tools/math tools/cli tools/drive_files tools/live
tools/export: daemon/diagnostics can_protocol/decode estimator/common daemon/core tools/cli
    tools/drive_files tools/replay tools/bridge
tools/config_patch: daemon/diagnostics daemon/core tools/cli
tools/sim/car: base estimator/common tools/math tools/cli
tools/sim/course: tools/sim/car
tools/sim/sensors: base estimator/common tools/math tools/cli tools/sim/car
tools/sim: base can_protocol can_protocol/decode can_protocol/sources estimator/common shm_api/include/odom
    tools/cli tools/drive_files tools/live tools/sim/car tools/sim/course tools/sim/sensors
tools/fault: base can_protocol can_protocol/dbc can_protocol/decode can_protocol/sources estimator/common
    daemon/core daemon/sockets tools/math tools/cli tools/drive_files tools/live tools/sim
tools/marker_tracking: tools/cli tools/drive_files
tools/identify/common: daemon/diagnostics can_protocol can_protocol/decode can_protocol/sources estimator/common
    daemon/core tools/math tools/cli tools/drive_files tools/diagnostics tools/replay tools/config_patch
tools/identify/weighing: daemon/diagnostics daemon/core tools/cli tools/diagnostics tools/identify/common
tools/identify/inertia: daemon/diagnostics tools/math tools/cli tools/diagnostics tools/replay tools/config_patch
    tools/identify/common
tools/identify/noise: daemon/core tools/math tools/cli tools/diagnostics tools/replay tools/identify/common
tools/identify/latency: daemon/diagnostics estimator/common daemon/core tools/math tools/cli tools/drive_files
    tools/diagnostics tools/replay tools/identify/common
tools/identify/stiffness: base daemon/diagnostics daemon/core tools/math tools/cli tools/chart tools/diagnostics
    tools/replay tools/identify/common
tools/identify/fit: daemon/diagnostics base estimator/common daemon/core
    tools/math tools/cli tools/drive_files tools/diagnostics tools/replay tools/evaluation
    tools/config_patch tools/marker_tracking tools/identify/common tools/identify/latency
tools/init: can_protocol can_protocol/dbc can_protocol/decode can_protocol/sources estimator/common
    daemon/diagnostics daemon/core tools/math tools/cli tools/config_patch tools/live tools/sim tools/identify/common
tools/doctor: daemon/diagnostics base can_protocol can_protocol/dbc can_protocol/decode can_protocol/sources
    daemon/core tools/math tools/diagnostics tools/replay tools/evaluation tools/live tools/identify/common
    tools/identify/latency
tools/serve: base tools/cli tools/live tools/live/watch tools/doctor
tools/import: base can_protocol/decode can_protocol/sources
    daemon/diagnostics daemon/core tools/math tools/cli tools/config_patch tools/drive_files tools/init tools/sim
tools/commands: base daemon/diagnostics can_protocol can_protocol/dbc can_protocol/sources daemon/core tools/cli
    tools/drive_files tools/chart tools/diagnostics tools/replay tools/evaluation tools/live tools/live/watch
    tools/report tools/bridge tools/export tools/sim/car tools/sim tools/fault
    tools/identify/common tools/doctor tools/import tools/init tools/serve
tools/completion: daemon tools/commands
tools: tools/cli tools/commands tools/completion
"""

FILES_AT_MOST = 45
LINES_AT_MOST = 350

LONGER = {
    "shm_api/writer.cpp": "one protocol: claiming the segment, taking one over and publishing lean on each other",
}

INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*(?:"([^"]+)"|<(odom/[^>]+)>)', re.MULTILINE)
SOURCES = (".hpp", ".cpp", ".h", ".c", ".in")


def read_tree() -> dict[str, str]:
    """Path -> text of all files of the product."""
    return {path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8")
            for house in HOUSES for path in sorted((ROOT / house).rglob("*"))
            if path.is_file() and "__pycache__" not in path.parts}


def folder(path: str) -> str:
    return os.path.dirname(path)


def table(text: str) -> dict[str, list[str]]:
    """Folder -> folders that it may include, in the order of the text."""
    entries = re.sub(r"\n +", " ", text.strip()).split("\n")
    return {name: allowed.split() for name, _, allowed in (entry.partition(":") for entry in entries if entry)}


def includes(tree: dict[str, str]) -> set[tuple[str, str]]:
    """(file, file that it includes) of files in different folders. What is not in the tree is generated or a
    library's."""
    found = set()
    for path, text in tree.items():
        if path.endswith(SOURCES):
            for quoted, public in INCLUDE.findall(text):
                sibling = os.path.normpath(os.path.join(folder(path), quoted))
                target = f"shm_api/include/{public}" if public else sibling if sibling in tree else quoted
                if target in tree and folder(target) != folder(path):
                    found.add((path, target))
    return found


def mistakes_in(rooms: dict[str, list[str]]) -> list[str]:
    """Mistakes in the table itself."""
    names = list(rooms)
    found = [f"{room} may include {target}, which does not stand above it" for room, allowed in rooms.items()
             for target in allowed if target not in names[:names.index(room)]]
    for house in {"/".join(name.split("/")[:depth]) for name in names for depth in (1, 2)}:
        at = [i for i, name in enumerate(names) if name == house or name.startswith(house + "/")]
        if at and at[-1] - at[0] >= len(at):
            found.append(f"the rooms of {house} do not stand together")
    return found


def mistakes(tree: dict[str, str], rooms: dict[str, list[str]]) -> list[str]:
    """What is wrong with a tree, a line each."""
    found = mistakes_in(rooms)
    arrows = includes(tree)
    for path, target in sorted(arrows):
        if folder(target) not in rooms.get(folder(path), ()):
            found.append(f"{path} includes {target}: {folder(path)} may not include {folder(target)}")
    used = {(folder(path), folder(target)) for path, target in arrows}
    found += [f"{room} does not include {target} any more: strike it out" for room, allowed in rooms.items()
              for target in allowed if (room, target) not in used]
    for room in sorted({folder(path) for path in tree}):
        files = [path for path in tree if folder(path) == room]
        if room not in rooms and any(path.endswith(SOURCES[:-1]) for path in files):
            found.append(f"{room} does not stand in ROOMS")
        if len(files) > FILES_AT_MOST:
            found.append(f"{room} holds {len(files)} files, {FILES_AT_MOST} are allowed")
    for path, text in tree.items():
        lines = text.count("\n")
        if lines > LINES_AT_MOST and path not in LONGER:
            found.append(f"{path} has {lines} lines, {LINES_AT_MOST} are allowed")
    found += [f"{path} is not longer than {LINES_AT_MOST} lines: strike it out" for path in LONGER
              if tree.get(path, "").count("\n") <= LINES_AT_MOST]
    return found


def read_budget(text: str) -> list[tuple[str, list[str], int, int]]:
    """Room, what git lists, allowed, target."""
    rows = [[cell.strip() for cell in line.split("|")] for line in text.splitlines() if not line.startswith("#")]
    return [(room, paths.split(), int(allowed), int(target)) for room, paths, allowed, target in rows]


def size_of(room: str, paths: list[str]) -> int:
    """Lines of the files; for the room `words`, their words."""
    listed = subprocess.run(["git", "ls-files", "-z", "--", *paths], cwd=ROOT, capture_output=True, text=True, check=True)
    texts = [(ROOT / name).read_bytes() for name in listed.stdout.split("\0") if name and (ROOT / name).exists()]
    return sum(len(text.decode().split()) if room == "words" else text.count(b"\n") for text in texts)


def excesses(sizes: dict[str, int], budget: list[tuple[str, list[str], int, int]]) -> list[str]:
    return [f"{room} has {sizes[room]}, {allowed} are allowed: save as many as you add, see budget.txt"
            for room, _, allowed, _ in budget if sizes[room] > allowed]


class Budget(unittest.TestCase):
    budget = read_budget((pathlib.Path(__file__).parent / "budget.txt").read_text(encoding="utf-8"))

    def test_no_room_exceeds_it(self):
        sizes = {room: size_of(room, paths) for room, paths, _, _ in self.budget}
        print(f"\n{'room':26}{'lines':>7}{'allowed':>9}{'target':>8}")
        for room, _, allowed, target in self.budget:
            print(f"{room:26}{sizes[room]:7}{allowed:9}{target:8}")
        self.assertEqual(excesses(sizes, self.budget), [])
        self.assertGreater(min(sizes.values()), 0)

    def test_an_excess_is_found(self):
        self.assertEqual(excesses({"fault": 11, "sim": 3}, [("fault", [], 10, 9), ("sim", [], 3, 2)]),
                         ["fault has 11, 10 are allowed: save as many as you add, see budget.txt"])


class Rooms(unittest.TestCase):
    tree: dict[str, str]

    @classmethod
    def setUpClass(cls):
        cls.tree = read_tree()

    def test_the_tree_is_as_written(self):
        self.assertEqual(mistakes(self.tree, table(ROOMS)), [])

    def test_the_tree_is_read(self):
        self.assertGreater(len(self.tree), 500)
        self.assertGreater(len(includes(self.tree)), 900)

    # Checks that the test can fail.

    def test_mistakes_in_files_are_found(self):
        def with_more(path, more):
            return {path: self.tree[path] + more}

        base = sum(folder(path) == "base" for path in self.tree)
        shorter = self.tree["shm_api/writer.cpp"].rpartition("}")[0].replace("\n}\n", "}")
        for changes, found in (
                (with_more("can_protocol/frame.hpp", '#include "daemon/core/config.hpp"\n'),
                 "can_protocol/frame.hpp includes daemon/core/config.hpp: can_protocol may not include daemon/core"),
                (with_more("tools/chart/axis.cpp", '#  include "../math/median.hpp"\n'),
                 "tools/chart/axis.cpp includes tools/math/median.hpp: tools/chart may not include tools/math"),
                (with_more("base/counter.hpp", "#include <odom/types.h>\n"),
                 "base/counter.hpp includes shm_api/include/odom/types.h: base may not include shm_api/include/odom"),
                (with_more("estimator/integrity/consensus.hpp", '#include "estimator/ekf/state.hpp"\n'),  # a circle
                 "estimator/integrity/consensus.hpp includes estimator/ekf/state.hpp: "
                 "estimator/integrity may not include estimator/ekf"),
                ({"tools/new/file.hpp": ""}, "tools/new does not stand in ROOMS"),
                ({f"base/more_{i}.hpp": "" for i in range(FILES_AT_MOST)},
                 f"base holds {base + FILES_AT_MOST} files, {FILES_AT_MOST} are allowed"),
                ({"base/long.hpp": "\n" * (LINES_AT_MOST + 1)}, "base/long.hpp has 351 lines, 350 are allowed"),
                ({"base/short.hpp": "\n" * LINES_AT_MOST}, None),
                ({"shm_api/writer.cpp": shorter}, "shm_api/writer.cpp is not longer than 350 lines: strike it out")):
            with self.subTest(found):
                self.assertEqual(mistakes({**self.tree, **changes}, table(ROOMS)), [found] if found else [])

    def test_mistakes_in_the_table_are_found(self):
        tracking = "tools/marker_tracking: tools/cli tools/drive_files\n"
        apart = ROOMS.replace(tracking, "").replace("tools/identify/weighing:", tracking + "tools/identify/weighing:")
        self.assertIn("the rooms of tools/identify do not stand together", mistakes(self.tree, table(apart)))
        for before, after, found in (
                ("tools/chart: tools/cli", "tools/chart: tools/cli tools/report",
                 ["tools/chart may include tools/report, which does not stand above it",
                  "tools/chart does not include tools/report any more: strike it out"]),
                ("tools/math: estimator/common", "tools/math: base estimator/common",
                 ["tools/math does not include base any more: strike it out"])):
            self.assertEqual(mistakes(self.tree, table(ROOMS.replace(before, after))), found)


if __name__ == "__main__":
    unittest.main()
