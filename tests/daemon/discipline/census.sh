#!/bin/bash
# Traces all system calls of the beat of the real odomd under full traffic with strace: only those of
# the design may occur, each at most as often as the design allows.
#
# The feeder reads the log: here the beat has no bus to receive from. The lab runs the same check with
# real buses.
set -uo pipefail
name=census
. "$(dirname "$0")/full_traffic.sh"

# The kernel's clock source decides whether reading the clock is a system call.
case $(cat /sys/devices/system/clocksource/clocksource0/current_clocksource) in
  tsc | kvm-clock | hyperv* | arch_sys_counter) clock_is_a_call=0 ;;
  *) clock_is_a_call=1 ;;
esac

# -I 2: a signal ends strace, which also ends the daemon.
start_full_traffic 90 strace -I 2 -f -ff -qq -s 1 -o "$work/trace"
pid=$(status .pid)
# thread_of NAME: the trace of the thread.
thread_of() {
  local task
  for task in "/proc/$pid/task/"*; do
    [ "$(cat "$task/comm")" != "$1" ] || echo "$work/trace.${task##*/}"
  done
}
beat=$(thread_of odomd-beat)
relay=$(thread_of odomd-relay)
await 80 status '.beat.ticks >= 600 and .camera.messages >= 20' -e ||
  fail "no traffic: $(status '[.beat, .can, .camera]' -c)"
echo "$name: $(status '"\(.beat.ticks) ticks, \(.can[0].received) frames, \(.camera.messages) camera poses"')"
stop_daemon "$pid" || fail "odomd ended with status $?"

check() { awk -v buses=0 -v cameras=1 -v clock_is_a_call=$clock_is_a_call -f "$discipline/census.awk" "$1"; }
check "$beat" || fail "the beat makes system calls that it must not make"
# The check can fail: no other thread passes it.
for other in "$relay" "$work/trace.$pid"; do
  ! check "$other" >/dev/null || fail "the check passes what is not the beat: $other"
done
