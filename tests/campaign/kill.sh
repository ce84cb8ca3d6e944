#!/bin/bash
# Kills the daemon at random times: kill.sh [KILLS], default 10000. odomd is repeatedly killed with
# SIGKILL after 20 to 70 ms of a drive, while three readers follow the pose. Asserts that readers see
# only complete poses (on the grid of their instance, with increasing ticks, finite, and without
# negative variances), that each attaches to every successor or a later one, and that every successor
# resumes from its predecessor's pose if that is less than 2 s old. Ends with a dated summary line.
kills=${1:-10000}
case $kills in '' | 0 | *[!0-9]*) sed -n '2,6s/^# \{0,1\}//p' "$0" >&2; exit 2 ;; esac
. "$(dirname "$0")/common.sh"
build odomd odom_command odom_shared
export PYTHONPATH=$PWD/python ODOM_LIBRARY=$PWD/build/release/lib/libodom.so.0
exec /usr/bin/python3 tests/campaign/kill.py "$bin" "$kills"
