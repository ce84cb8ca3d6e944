#!/bin/bash
# The whole test suite, with nothing skipped: formatting, release build and unit tests; those of the
# daemon and libodom also under AddressSanitizer and UBSan (tests/campaign/asan.sh runs the rest); and
# the lab (a virtual machine with a real CAN bus and PREEMPT_RT).
#
#   bash tests/run.sh
#   bash tests/run.sh --quick    for small changes: only formatting, release build and unit tests
#
# Installs the packages it needs (Debian). ODOMD_DRIVES=DIRECTORY[:DIRECTORY...] adds the tests on
# real drives; without it, they print `not run: N`. The last line is `N passed, N failed`; the exit status is 0
# only when nothing failed. Logs stay in build/logs.
set -uo pipefail
cd "$(dirname "$0")/.."
case $# in 0) quick= ;; *) quick=$1 ;; esac
if [ $# -gt 1 ] || { [ -n "$quick" ] && [ "$quick" != --quick ]; }; then
  sed -n '2,11s/^# \{0,1\}//p' "$0" >&2
  exit 2
fi

passed=0
failed=0
not_run=0
summary=()
failures=()
logs=build/logs

# Compiling an Eigen file takes up to 1.5 GB, so a machine with little memory runs fewer compilers.
jobs=$(nproc)
memory_jobs=$(awk '/^MemAvailable/ {print int($2 / 1500000)}' /proc/meminfo)
[ "$jobs" -le "$memory_jobs" ] || jobs=$((memory_jobs > 1 ? memory_jobs : 1))

export UBSAN_OPTIONS=${UBSAN_OPTIONS:-print_stacktrace=1}
export CTEST_PARALLEL_LEVEL=$jobs CLICOLOR=0 GTEST_COLOR=no

# note PART PASSED FAILED SECONDS: adds a part's result to the totals.
note() {
  passed=$((passed + $2))
  failed=$((failed + $3))
  summary+=("$(printf '%-22s %5d passed %4d failed %5d s' "$1" "$2" "$3" "$4")")
}

# note_failures PART: stores each line of standard input, to be repeated at the end.
note_failures() {
  local line
  while IFS= read -r line; do failures+=("$1: $line"); done
}

# failed_in JUNIT: prints the tests that did not pass, with the first lines of their output.
failed_in() {
  awk '
    /<testcase / {
      name = $0; sub(/.*<testcase name="/, "", name); sub(/".*/, "", name)
      bad = !/status="run"/
      said = 0
      if (bad) print name
    }
    /<\/system-out>/ {bad = 0}
    bad && (/: Failure$/ || /ERROR: |runtime error: |SUMMARY: / || said) && said < 5 {print "  " $0; said++}' \
    "$1" 2>/dev/null |
    sed 's/&lt;/</g; s/&gt;/>/g; s/&quot;/"/g; s/&apos;/'"'"'/g; s/&amp;/\&/g'
}

# part NAME COMMAND...: a step without tests of its own, which counts only if it fails.
part() {
  local name=$1 begin=$SECONDS log
  log=$logs/part-${1//[^a-z]/-}.log
  shift
  echo "=== $name"
  if "$@" 2>&1 | tee "$log"; then
    note "$name" 0 0 $((SECONDS - begin))
  else
    echo "=== $name FAILED"
    note "$name" 0 1 $((SECONDS - begin))
    failures+=("$name failed: see $log")
    note_failures "$name" < <(grep -iE 'error|cannot' "$log" | head -n 10)
    return 1
  fi
}

formatting() {
  git ls-files -z '*.hpp' '*.cpp' '*.h' '*.c' |
    xargs -0 -r -n 20 -P "$jobs" clang-format --dry-run -Werror
}

# build PRESET [OPTION...]
build() {
  cmake --preset "$1" -DODOMD_TESTS=ON "${@:2}" >"$logs/configure-$1.log" 2>&1 || {
    cat "$logs/configure-$1.log"
    return 1
  }
  nice cmake --build --preset "$1" -j "$jobs"
}

# unit_tests PRESET: counts CTest's results; a skipped or disabled test counts as failed.
unit_tests() {
  local preset=$1 begin=$SECONDS junit=$PWD/$logs/unit-$1.xml total bad
  echo "=== unit tests ($preset)"
  rm -f "$junit"
  ctest --preset "$preset" --progress --output-junit "$junit"
  counted() { sed -n "/<testsuite /,/>/s/.*[ \t]$1=\"\([0-9]*\)\".*/\1/p" "$junit" 2>/dev/null | head -n 1; }
  total=$(counted tests)
  bad=$(($(counted failures) + $(counted disabled) + $(counted skipped)))
  if [ "${total:-0}" = 0 ]; then
    echo "=== unit tests ($preset): none ran"
    failures+=("unit tests ($preset): none ran")
    total=1 bad=1
  fi
  note "unit tests ($preset)" $((total - bad)) "$bad" $((SECONDS - begin))
  note_failures "$preset" < <(failed_in "$junit")
  local here
  here=$(sed -n 's/.*not run: \([0-9][0-9]*\).*/\1/p' "build/$preset/Testing/Temporary/LastTest.log" |
    awk '{n += $1} END {print n + 0}')
  not_run=$((not_run + here))
}

# The lab's machines are mostly idle: they run in parallel with the next build, which has a lower
# priority.
lab_job= lab_begin=0
start_lab() {
  echo "=== lab, in parallel with the following steps"
  lab_begin=$SECONDS
  LAB_TIMEOUT=${LAB_TIMEOUT:-900} tests/lab/lab.sh test >"$logs/lab.log" 2>&1 &
  lab_job=$!
}

finish_lab() {
  local log=$logs/lab.log result ok bad status=0
  wait "$lab_job" || status=$?
  echo "=== lab"
  cat "$log"
  result=$(tail -n 1 "$log")
  if [[ $result =~ ^lab:\ ([0-9]+)\ passed,\ ([0-9]+)\ failed$ ]]; then
    ok=${BASH_REMATCH[1]} bad=${BASH_REMATCH[2]}
    # CTest's exit status and the number of failures must agree.
    [ "$status" = 0 ] || [ "$bad" != 0 ] || bad=1
  else
    echo "=== lab did not run to its end"
    ok=$(grep -c '^ok ' "$log") bad=$(($(grep -c '^not ok ' "$log") + 1))
    note_failures "lab" < <(tail -n 15 "$log" | grep -vE '^(ok|not ok|lab:) ')
  fi
  note "lab" "$ok" "$bad" $((SECONDS - lab_begin))
  note_failures "lab" < <(grep -E '^(not ok|lab:) ' "$log" | grep -vE '^lab: .* passed, ')
}

mkdir -p "$logs"
part "dependencies" tools/dependencies.sh test
part "formatting" formatting
if part "build (release)" build release; then
  unit_tests release
  [ -n "$quick" ] || start_lab
fi
if [ -z "$quick" ]; then
  part "build (asan)" build asan -DODOMD_TOOLS=OFF
  asan_built=$?
  [ -z "$lab_job" ] || finish_lab
  [ "$asan_built" != 0 ] || unit_tests asan
fi

echo
echo "=== summary (logs in $logs)"
printf '%s\n' "${summary[@]}"
if [ ${#failures[@]} != 0 ]; then
  # The failures come last and are limited, so that the end of a log shows them.
  printf '%s\n' "${failures[@]:0:60}" | cut -c -300
  [ ${#failures[@]} -le 60 ] || echo "and $((${#failures[@]} - 60)) lines more in $logs"
fi
[ -z "$quick" ] || echo "quick: no sanitizers, no lab"
echo "not run: $not_run (tests on real drives; set ODOMD_DRIVES)"
echo "in $((SECONDS / 60)) min $((SECONDS % 60)) s"
echo "$passed passed, $failed failed"
[ "$failed" = 0 ]
