#!/bin/bash
# Time from exec to the first pose, natively: start.sh [STARTS], default 20. Starts odomd with
# frames ready on its standard input, kills it after its first pose, and starts it again. A second
# series with high priority for all threads shows the time of the start itself. Ends with a dated
# summary line; fails if the median is longer than 150 ms.
starts=${1:-20}
. "$(dirname "$0")/common.sh"
build odomd odom_command first_pose
work=$(mktemp -d)
shm=/odomd-start-$$
trap 'rm -rf "$work" "/dev/shm$shm" "/dev/shm$shm.lock"' EXIT

# The car is already moving: the first frames have a speed.
"$bin/odom" sim --duration 5 --standstill 0 --out "$work/car" >/dev/null || exit 1

# measure COMMAND...: both times of all starts; COMMAND starts the program.
measure() {
  "$@" "$bin/first_pose" "$bin/odomd" "$work/car/car.toml" "$work/car/drive.log" "$shm" "$starts" | tr '\n' ' '
}
usual=$(measure) && [ -n "$usual" ] || exit 1
ahead="not allowed here"
! chrt -f 10 true 2>/dev/null || ahead=$(measure chrt -f 10)
median=$(awk '{print $3}' <<<"$usual")
verdict=$(awk -v median="$median" 'BEGIN {print median <= 150 ? "" : "FAILED: "}')
echo "$(date -u +%F) start: $verdict$starts starts, ms from before the start: $usual; ahead of other work (SCHED_FIFO): $ahead"
[ -z "$verdict" ]
