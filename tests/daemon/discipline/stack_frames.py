#!/usr/bin/env python3
"""Checks in the machine code of a program that no function's stack frame comes near the 1 MB that threads of odomd have.

The compiler's own warning does not see templates of the standard library: a copied std::variant once took 0.9 MB.
"""

import re
import subprocess
import sys

LARGEST = 128 * 1024  # bytes; touch_stack() makes 256 kB resident, far more than a tick needs
ON_PURPOSE = "touch_stack"


def large_frames(program):
    function = ""
    code = subprocess.run(["objdump", "-dC", "--no-show-raw-insn", program], capture_output=True, text=True, check=True)
    for line in code.stdout.splitlines():
        if begin := re.match(r"[0-9a-f]+ <(.*)>:$", line):
            function = begin[1]
        # With and without -fstack-clash-protection.
        frame = re.search(r"\bsub +\$0x([0-9a-f]{4,8}),%rsp|\blea +-0x([0-9a-f]{4,8})\(%rsp\),%r11", line)
        if frame and int(frame[1] or frame[2], 16) > LARGEST:
            yield function, int(frame[1] or frame[2], 16)


found = list(large_frames(sys.argv[1]))
if not any(ON_PURPOSE in function for function, _ in found):
    sys.exit(f"the frame of {ON_PURPOSE}() was not seen: this check does not read the code of {sys.argv[1]}")
if too_large := [f"{size} bytes: {function[:200]}" for function, size in found if ON_PURPOSE not in function]:
    sys.exit("\n".join(too_large))
