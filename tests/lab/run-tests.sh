#!/bin/bash
# Runs test scripts one after the other and counts their lines `ok NAME` and `not ok NAME: why`.
# A script that fails, or has no result, counts as a failed test with its own name.
# The sums go to $LAB_SHARED/counts.
set -u

passed=0
failed=0
for script in "$@"; do
  name=$(basename "$script" .sh)
  begin=$(date +%s.%N)
  work=$(mktemp -d)
  {
    (cd "$work" && LAB_TEST=$name timeout -k 5 "${LAB_TEST_TIMEOUT:-300}" bash "$script" 2>&1)
    echo "status $?" >"$work/.status"
  } | tee "$work/.output"
  status=$(sed 's/status //' "$work/.status")
  ok=$(grep -c '^ok ' "$work/.output")
  not_ok=$(grep -c '^not ok ' "$work/.output")
  if [ "$status" != 0 ] || [ $((ok + not_ok)) = 0 ]; then
    why="ended with status $status"
    [ "$status" != 124 ] || why="no end after ${LAB_TEST_TIMEOUT:-300} s"
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
  rm -rf "$work"
done
echo "$passed $failed" >"$LAB_SHARED/counts"
[ $failed = 0 ]
