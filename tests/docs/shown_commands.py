#!/usr/bin/env python3
"""Runs what a page shows: shown_commands.py PAGE SHOWN

A page marks with <!-- shown: SHOWN --> where the ```console blocks begin that are meant, until its
next mark. In them a line `$ COMMAND`, `USER$ COMMAND` or `root# COMMAND` is run, in order, in one
new directory that all may write, and prints the lines below it; `...` stands for anything in a line, and alone for
any lines. A USER is another one of this machine, which takes root. Prints `ok NAME` or
`not ok NAME: why` for each; the exit status is 0 only when all are as shown.
"""

import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile

PROMPT = re.compile(r"(?:(?P<user>[a-z]+)\$|(?P<root>root)#|\$) (?P<command>.*)")
TIME_LIMIT_S = 60


def shown_in(page, wanted):
    """(user or None, command, lines that it prints) in their order."""
    steps, mark, inside = [], None, False
    for line in page.splitlines():
        if found := re.fullmatch(r"<!-- shown: (.*) -->", line):
            mark = found[1]
        elif line.startswith("```"):
            inside = mark == wanted and line == "```console"
        elif inside and steps and not steps[-1][2] and steps[-1][1].endswith("\\"):
            steps[-1][1] += "\n" + line
        elif inside and (prompt := PROMPT.fullmatch(line)):
            steps.append([prompt["user"], prompt["command"], []])
        elif inside:
            steps[-1][2].append(line)
    return steps


def pattern_of(lines):
    """What matches the output that these lines show."""
    parts = (r"(?:.*\n)*" if line == "..." else
             ".*".join(re.escape(part) for part in line.split("...")) + r"\n" for line in lines)
    return re.compile("".join(parts))


def run(user, command, groups):
    """What it prints, on either stream. What it leaves in the background goes on until the end."""
    words = ["bash", "-c", command]
    if user:
        words = ["setpriv", f"--reuid={user}", f"--regid={user}", "--init-groups",
                 "--inh-caps=-all", *words]
    with tempfile.TemporaryFile() as output:
        process = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=output,
                                   stderr=subprocess.STDOUT, start_new_session=True)
        groups.append(process.pid)
        try:
            process.wait(TIME_LIMIT_S)
        except subprocess.TimeoutExpired:
            return f"no end after {TIME_LIMIT_S} s\n"
        output.seek(0)
        return output.read().decode(errors="backslashreplace")


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    page, wanted = sys.argv[1:]
    name = pathlib.Path(page).stem
    steps = shown_in(pathlib.Path(page).read_text(), wanted)
    groups, failed = [], 0
    directory = tempfile.mkdtemp()
    os.chmod(directory, 0o777)
    os.chdir(directory)
    try:
        for user, command, lines in steps:
            printed = run(user, command, groups)
            what = f"{name}: {user or ''}$ {command}".replace("\n", " ")
            if pattern_of(lines).fullmatch(printed):
                print(f"ok {what}", flush=True)
            else:
                failed += 1
                print(f"not ok {what}: printed {shlex.quote(printed)}", flush=True)
    finally:
        for group in groups:
            try:
                os.killpg(group, signal.SIGKILL)
            except ProcessLookupError:
                pass
        shutil.rmtree(directory)
    if not steps:
        print(f"not ok {name}: nothing is shown: {wanted}")
    sys.exit(1 if failed or not steps else 0)


if __name__ == "__main__":
    main()
