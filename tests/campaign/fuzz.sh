#!/bin/bash
# Runs every fuzzer (clang, libFuzzer, ASan and UBSan) for a given time: fuzz.sh [SECONDS] [NAME...]
#
# SECONDS is per fuzzer (default 600); NAME is as in tests/fuzz (default: all). Findings are kept in
# build/fuzz/found/NAME, the growing corpus in build/fuzz/corpus/NAME. Ends with a dated summary line.
seconds=${1:-600}
shift || true
case $seconds in '' | *[!0-9]*) sed -n '2,5s/^# \{0,1\}//p' "$0" >&2; exit 2 ;; esac
. "$(dirname "$0")/common.sh"
cmake --preset fuzz >build/logs/configure-fuzz.log 2>&1 || { cat build/logs/configure-fuzz.log; exit 1; }
[ $# -gt 0 ] || set -- $(basename -s .cpp tests/fuzz/*.cpp)
cmake --build --preset fuzz -j "$(nproc)" --target $(printf 'fuzz_%s ' "$@") || exit 1

# fuzz NAME: runs a fuzzer; prints a line, returns its status.
fuzz() {
  local corpus=build/fuzz/corpus/$1 found=build/fuzz/found/$1 log=build/logs/fuzz-$1.log words=() status=0
  mkdir -p "$corpus" "$found"
  [ ! -f "tests/fuzz/$1.dict" ] || words=(-dict="tests/fuzz/$1.dict")
  UBSAN_OPTIONS=${UBSAN_OPTIONS:-print_stacktrace=1} "build/fuzz/bin/fuzz_$1" "${words[@]}" \
    -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 -print_final_stats=1 -verbosity=1 \
    -artifact_prefix="$found/" "$corpus" "tests/fuzz/seeds/$1" >"$log" 2>&1 || status=$?
  echo "fuzz_$1: status $status, $(sed -n 's/stat::number_of_executed_units: //p' "$log") runs; $log"
  [ $status = 0 ] || grep -m 3 -E 'ERROR|SUMMARY|fuzz: broken|runtime error' "$log"
  return $status
}

broken=0
for name; do
  fuzz "$name" || broken=$((broken + 1))
done
echo "$(date -u +%F) fuzz: $# fuzzers of $seconds s each, $broken broken; $((SECONDS - begin)) s"
[ $broken = 0 ]
