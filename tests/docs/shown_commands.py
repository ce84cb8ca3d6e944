#!/usr/bin/env python3
"""Runs what a page shows: shown_commands.py PAGE SHOWN
With --options it runs none, but compares commands in the code of pages with their help, and options that stand alone
with the manual pages: shown_commands.py --options PAGE...

It runs the ```console blocks between the mark <!-- shown: SHOWN --> and the page's next mark. In them each line
`$ COMMAND`, `USER$ COMMAND` or `root# COMMAND` is run, in order, in one new directory that all may write, and must
print the lines below it; `...` stands for anything in a line, and alone for any lines. USER is another user of this
machine, for which the script needs root. Prints `ok NAME` or `not ok NAME: why` for each command; the exit status
is 0 only if all are as shown.
"""

import contextlib
import functools
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
PROGRAMS = [name for name in ("odom", "odomd", "apriltag_camera") if shutil.which(name)]
ROOT = pathlib.Path(__file__).resolve().parents[2]
FENCE, LINE, SPAN = r"^ *```.*\n((?:.*\n)*?) *```$", r"^ {4,}(\S.*)$", r"(?<!`)`([^`\n]+)`(?!`)"
COMMAND = re.compile(rf"(?:^|[\s(|\"])({'|'.join(PROGRAMS)}) ([^|;&)\"`#<\n]*)", re.MULTILINE)


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
    """What a command prints, on either stream. What it leaves in the background runs on until the end."""
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


def end(groups):
    for group in groups:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(group, signal.SIGKILL)


@functools.cache
def help_of(*words):
    """Options and subcommands of a command; None if there is none."""
    helped = subprocess.run([*words, "--help"], capture_output=True, text=True, check=False)
    options, _, below = helped.stdout.partition("Subcommands:\n")
    return None if helped.returncode else (set(re.findall(r"^  (?:-\w,)?(--[-a-z0-9]+)", options, re.MULTILINE)),
                                           re.findall(r"^  ([a-z]+)  +[A-Z]", below, re.MULTILINE))


def unknown_in(page):
    """The commands and options in a page's code that neither a help nor a manual page has."""
    described = "".join(file.read_text() for file in (*ROOT.glob("man/*.[18]"), ROOT / "examples/stanley.py"))
    known = {"--" + option for option in re.findall(r'(?:Fl Fl |"--)([-a-z0-9]+)', described)}
    for code in map("".join, re.findall(f"{FENCE}|{LINE}|{SPAN}", page.replace("\\\n", " "), re.MULTILINE)):
        yield from set(re.findall("^--[-a-z0-9]+", code)).difference(known)
        for program, rest in COMMAND.findall(code):
            words, rest = [program], rest.split()
            while rest and help_of(*words) and help_of(*words)[1] and re.fullmatch("[a-z]+", rest[0]):
                words.append(rest.pop(0))
            if not help_of(*words):
                yield " ".join(words)
            else:
                given = (word.partition("=")[0] for word in rest if word.startswith("--"))
                yield from (" ".join([*words, option]) for option in given if option not in help_of(*words)[0])


def main():
    if sys.argv[1:2] == ["--options"]:
        unknown = [f"{page}: {what}" for page in sys.argv[2:] for what in unknown_in(pathlib.Path(page).read_text())]
        sys.exit("".join(f"not ok {what}: no help has it\n" for what in unknown) or len(sys.argv) == 2)
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
        end(groups)
        shutil.rmtree(directory)
    if not steps:
        print(f"not ok {name}: nothing is shown: {wanted}")
    sys.exit(1 if failed or not steps else 0)


if __name__ == "__main__":
    main()
