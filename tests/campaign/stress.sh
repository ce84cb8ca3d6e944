#!/bin/bash
# The shared memory under stress: stress.sh [READS [KILLS]]
#
# A writer that never pauses, with readers in threads and processes, until they have made 100
# million reads in a ring of the usual size, and as many in a ring of four slots; a thousand kills
# of such a writer; and a reader that preempts the writer on its CPU, without real-time throttling
# where permitted. Ends with dated summary lines.
reads=${1:-100000000} kills=${2:-1000}
. "$(dirname "$0")/common.sh"
build test_shm_api shm_preemption
log=build/logs/stress.log

begin=$SECONDS
ODOMD_STRESS_READS=$reads ODOMD_STRESS_KILLS=$kills \
  "$bin/test_shm_api" --gtest_filter='TornReads.*:Kills.*' >"$log" 2>&1
status=$?
[ $status = 0 ] || grep -E 'Failure|FAILED' "$log"

# Only briefly: meanwhile a real-time loop of another program could block its CPU for ever.
throttle=/proc/sys/kernel/sched_rt_runtime_us
before=$(cat $throttle)
restore() { [ "$(cat $throttle)" = "$before" ] || echo "$before" >$throttle; }
trap restore EXIT
trap 'exit 130' INT TERM
if ! echo -1 2>/dev/null >$throttle; then echo "stress: real-time throttling stays on: not root"; fi
"$bin/shm_preemption" 20000 >>"$log" 2>&1 || status=1
restore

sed -n -e 's/^\([0-9]* slots:\)/\1/p' -e '/^[0-9]* kills/p' -e '/^preemption/p' "$log" |
  sed "s/^/$(date -u +%F) stress: /"
[ $status = 0 ] && verdict=passed || verdict=FAILED
echo "$(date -u +%F) stress: $verdict in $((SECONDS - begin)) s"
exit $status
