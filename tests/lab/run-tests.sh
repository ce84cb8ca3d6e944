#!/bin/bash
# Runs test scripts one after the other, each after guest.sh (those below systemd/ after service.sh, too), and
# counts their lines `ok NAME` and `not ok NAME: why`. A script that fails, or has no result, counts as a failed
# test with its own name. The sums go to $LAB_SHARED/counts.
set -u
here=$(dirname "$0")
limit=${LAB_TEST_TIMEOUT:-300}

passed=0
failed=0
for script in "$@"; do
  name=$(basename "$script" .sh)
  begin=$(date +%s.%N)
  work=$(mktemp -d)
  helpers=("$here/guest.sh")
  [[ $script != */systemd/* ]] || helpers+=("$here/service.sh")
  cat "${helpers[@]}" "$script" >"$work/.test"
  (cd "$work" && LAB_TEST=$name timeout -k 5 "$limit" bash .test 2>&1) | tee "$work/.output"
  status=${PIPESTATUS[0]}
  ok=$(grep -c '^ok ' "$work/.output")
  not_ok=$(grep -c '^not ok ' "$work/.output")
  if [ "$status" != 0 ] || [ $((ok + not_ok)) = 0 ]; then
    why="ended with status $status"
    [ "$status" != 124 ] || why="no end after $limit s"
    # A script with a failed check prints "not ok", continues and ends with status 1. Any other end is an
    # additional failure.
    if [ "$not_ok" = 0 ] || [ "$status" != 1 ]; then
      echo "not ok $name: $why, after $ok results"
      not_ok=$((not_ok + 1))
    fi
  fi
  passed=$((passed + ok))
  failed=$((failed + not_ok))
  awk -v name="$name" -v a="$begin" -v b="$(date +%s.%N)" 'BEGIN {printf "-- %s: %.1f s\n", name, b - a}'
  ip -br link show type vcan | sed 's/[ @].*//' | xargs -r -n 1 ip link del
  rm -rf "$work"
done
echo "$passed $failed" >"$LAB_SHARED/counts"
[ $failed = 0 ]
