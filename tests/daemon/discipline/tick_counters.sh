#!/bin/bash
# Checks that no allocation, lock, exception or page fault occurs in the beat of the real odomd from
# its first tick, under full traffic and while a recording begins: tick_counters.sh LIBRARY [TICKS [INJECT]]
#
# LIBRARY is built from tick_counters.cpp. With INJECT (allocation, lock, exception or fault) the
# library itself does this in the beat's thread, and the test checks that it is counted.
set -uo pipefail
library=$1 ticks=${2:-10000} injected=${3-}
name=tick-counters${injected:+-$injected}
. "$(dirname "$0")/full_traffic.sh"

start_full_traffic $((ticks / 200 + 30)) env LD_PRELOAD="$library" TICK_COUNTERS_OUT="$work/counts" \
  TICK_COUNTERS_TICKS="$ticks" TICK_COUNTERS_INJECT="$injected"
odom record --socket "$work/record.sock" --wait 20 --out "$work/recorded" &
children+=($!)
await $((ticks / 200 + 120)) grep -q other_locks "$work/counts" || fail "no counts: $(status .beat -c)"
read -r published received camera locked < <(status '[.beat.ticks, .can[0].received,
  .camera.messages, .realtime.memory_locked] | map(tostring) | join(" ")')
stop_daemon || fail "odomd ended with status $?"

counted() { awk -v name="$1" '$1 == name {print $2}' "$work/counts"; }
echo "$name: $(tr '\n' ' ' <"$work/counts")"
echo "$name: $published ticks in all, $received frames, $camera camera poses, memory locked: $locked"

[ "$(counted ticks)" = "$ticks" ] || fail "counted $(counted ticks) ticks, not $ticks"
[ "$(counted other_allocations)" -gt 100 ] && [ "$(counted other_locks)" -gt 0 ] ||
  fail "the program does not pass by the counters"

# expect WHAT COUNTER...: zero, or the number that was injected.
expect() {
  local what=$1 sum=0 counter
  shift
  for counter; do sum=$((sum + $(counted "$counter"))); done
  if [ "$what" = "$injected" ]; then
    [ $sum -gt 0 ] || fail "an injected $what was not counted"
  elif [ -z "$injected" ]; then
    [ $sum = 0 ] || fail "$sum ${what}s in $ticks ticks"
  fi
}
expect allocation allocations
expect lock locks
expect exception exceptions
if [ "$locked" = true ]; then
  expect fault minor_faults major_faults
else
  echo "not run: 1 (page faults: this machine refuses to lock memory)"
fi

if [ -z "$injected" ]; then
  # Of the 40 frames that arrive per tick, 4 are of mapped messages; the others are ignored.
  [ "$received" -ge $((published * 3)) ] || fail "the traffic was not full: $received frames"
  [ "$camera" -ge $((published / 15)) ] || fail "the traffic was not full: $camera camera poses"
  [ "$(wc -l <"$work/recorded/beat.csv")" -gt 2 ] || fail "nothing was recorded"
fi
