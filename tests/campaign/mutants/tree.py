"""A copy of the tree with mutants that are switched on at run time, and its build."""

import collections
import json
import re
import subprocess
import sys

import common

COPY = common.ROOT / "build/mutants/tree"
BUILD = COPY / "build/release"
SWITCH = COPY.parent / "switch.h"
SWITCH_CODE = """\
#pragma once
#include <stdlib.h>
static int mutant_number;
__attribute__((constructor(101))) static void read_mutant_number(void) {
  const char* text = getenv("ODOMD_MUTANT");
  mutant_number = text ? atoi(text) : 0;
}
static inline int mutant_is_on(int number) { return mutant_number == number; }
""" + "".join(f'#pragma GCC diagnostic ignored "-W{name}"\n' for name in (
    "parentheses", "conversion", "sign-conversion", "maybe-uninitialized", "uninitialized", "type-limits",
    "implicit-fallthrough", "unused-but-set-variable", "unused-variable", "unused-function", "empty-body",
    "bool-compare", "array-bounds", "stringop-overflow", "stringop-overread", "nonnull"))


def files(prefix):
    listed = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard", prefix],
                            cwd=common.ROOT, capture_output=True, text=True, check=True).stdout
    return [name for name in listed.split("\0") if name and (common.ROOT / name).is_file()]


def rewritten(code, mutants):
    """The code with the mutants, (mutant, number), as variants; each line moves down by one."""
    by_place = collections.defaultdict(list)
    for mutant, number in mutants:
        by_place[mutant.begin, mutant.end, mutant.form].append((number, mutant.after))
    for (begin, end, form), variants in sorted(by_place.items(), reverse=True):
        to_bool = "!!" if form == "condition" else ""
        if form == "statement":
            new = "".join(f"if (mutant_is_on({number})) {{ {after} }} else " for number, after in variants)
            new = f"{{ {new}{{ {code[begin:end]} }} }}"
        else:
            new = "".join(f"mutant_is_on({number}) ? {to_bool}({after}) : " for number, after in variants)
            new = f"({new}{to_bool}({code[begin:end]}))"
        code = code[:begin] + new + code[end:]
    return f'#include "{SWITCH}"\n{code}'


def copy(numbers):
    """Writes the tree with the mutants. Unchanged files keep their times, so that they are not built again."""
    by_file = collections.defaultdict(list)
    for mutant, number in numbers.items():
        by_file[mutant.file].append((mutant, number))
    contents = {COPY / name: (common.ROOT / name).read_bytes() for name in files(".")}
    for name, mutants in by_file.items():
        contents[COPY / name] = rewritten(contents[COPY / name].decode(), mutants).encode()
    for path in COPY.rglob("*"):
        if path.is_file() and path not in contents and not path.is_relative_to(COPY / "build"):
            path.unlink()  # no longer in the tree
    for path, content in {**contents, SWITCH: SWITCH_CODE.encode()}.items():
        if not path.exists() or path.read_bytes() != content:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
            if path != SWITCH:
                path.chmod((common.ROOT / path.relative_to(COPY)).stat().st_mode)


def programs(prefix):
    """The GoogleTest programs, {target: file}, that have a source in the mirror of the prefix."""
    found = {}
    for file in (BUILD / ".cmake/api/v1/reply").glob("target-*.json"):
        target = json.loads(file.read_text(encoding="utf-8"))
        linked = " ".join(part["fragment"] for part in target.get("link", {}).get("commandFragments", []))
        if "gtest_main" in linked and any(one["path"].startswith(f"tests/{prefix}") for one in target["sources"]):
            found[target["name"]] = BUILD / target["artifacts"][0]["path"]
    return found


def build(numbers, prefixes, jobs):
    """Builds the programs of these prefixes; returns the mutants without those that do not compile."""
    query = BUILD / ".cmake/api/v1/query/codemodel-v2"
    query.parent.mkdir(parents=True, exist_ok=True)
    query.touch()
    while True:
        copy(numbers)
        subprocess.run(["cmake", "--preset", "release", "-DODOMD_TESTS=ON", "-DODOMD_REBUILD_FAST=ON",
                        "-DODOMD_UNITY=OFF"], cwd=COPY, stdout=subprocess.DEVNULL, check=True)
        targets = sorted({name for prefix in prefixes for name in programs(prefix)})
        print(f"builds {len(numbers)} mutants into {', '.join(targets)}", file=sys.stderr)
        done = subprocess.run(["ninja", "-C", BUILD, "-k", "0", f"-j{jobs}", *targets], capture_output=True, text=True,
                              check=False)
        if done.returncode == 0:
            return numbers
        for mark in (": error:", ""):  # if the error is in a header, a later line names our file
            named = {((BUILD / file).resolve(), int(line) - 1)
                     for file, line in re.findall(rf"^([^\s:]+):(\d+):\d+{mark}", done.stdout, re.M)}
            broken = {mutant for mutant in numbers if any((COPY / mutant.file, line) in named for line in mutant.lines)}
            if broken:
                break
        else:
            sys.exit(f"{done.stdout[-4000:]}\nmutants: the build fails, and not for a mutant")
        print(f"{len(broken)} do not compile", file=sys.stderr)
        numbers = {mutant: number for mutant, number in numbers.items() if mutant not in broken}
