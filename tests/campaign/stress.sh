#!/bin/bash
# The shared memory under stress: stress.sh [READS [KILLS]]
#
# Runs a writer that never pauses with readers in threads and processes, until they have made 100
# million reads in a ring of the usual size and as many in a ring of four slots; then kills the
# writer a thousand times. Ends with dated summary lines.
reads=${1:-100000000} kills=${2:-1000}
. "$(dirname "$0")/common.sh"
build test_shm_api
log=build/logs/stress.log

ODOMD_STRESS_READS=$reads ODOMD_STRESS_KILLS=$kills \
  "$bin/test_shm_api" --gtest_filter='TornReads.*:Kills.*' >"$log" 2>&1
status=$?
[ $status = 0 ] || grep -E 'Failure|FAILED' "$log"

sed -n -e 's/^\([0-9]* slots:\)/\1/p' -e '/^[0-9]* kills/p' "$log" |
  sed "s/^/$(date -u +%F) stress: /"
[ $status = 0 ] && verdict=passed || verdict=FAILED
echo "$(date -u +%F) stress: $verdict in $((SECONDS - begin)) s"
exit $status
