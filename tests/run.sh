#!/bin/bash
# The whole test suite, nothing skipped: formatting, release build and unit tests, the same under
# AddressSanitizer and UBSan, and the lab (a virtual machine with a real CAN bus and PREEMPT_RT).
#
#   bash tests/run.sh
#
# Installs the packages it needs (Debian). ODOMD_DRIVES=DIRECTORY adds the tests on real drives;
# without it these say `not run: N`. The last line is `N passed, N failed`; the exit status is 0
# only when nothing failed. Logs stay in build/logs.
set -uo pipefail
cd "$(dirname "$0")/.."

passed=0
failed=0
not_run=0
summary=()
logs=build/logs

# A compiler on an Eigen file takes up to 1.5 GB: a machine with little memory gets fewer of them.
jobs=$(nproc)
memory_jobs=$(awk '/^MemAvailable/ {print int($2 / 1500000)}' /proc/meminfo)
[ "$jobs" -le "$memory_jobs" ] || jobs=$((memory_jobs > 1 ? memory_jobs : 1))

export UBSAN_OPTIONS=${UBSAN_OPTIONS:-print_stacktrace=1}
export CTEST_PARALLEL_LEVEL=$jobs CLICOLOR=0 GTEST_COLOR=no

# note PART PASSED FAILED SECONDS: adds a part's result to the sums.
note() {
  passed=$((passed + $2))
  failed=$((failed + $3))
  summary+=("$(printf '%-22s %5d passed %4d failed %5d s' "$1" "$2" "$3" "$4")")
}

# part NAME COMMAND...: a step without tests of its own; counts only when it fails.
part() {
  local name=$1 begin=$SECONDS
  shift
  echo "=== $name"
  if "$@"; then
    note "$name" 0 0 $((SECONDS - begin))
  else
    echo "=== $name FAILED"
    note "$name" 0 1 $((SECONDS - begin))
    return 1
  fi
}

formatting() {
  git ls-files -z '*.hpp' '*.cpp' '*.h' '*.c' |
    xargs -0 -r -n 20 -P "$jobs" clang-format --dry-run -Werror
}

build() {
  cmake --preset "$1" -DODOMD_TESTS=ON >"$logs/configure-$1.log" 2>&1 || {
    cat "$logs/configure-$1.log"
    return 1
  }
  cmake --build --preset "$1" -j "$jobs"
}

# unit_tests PRESET: counts what CTest ran; a skipped or disabled test is a failed one.
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
    total=1 bad=1
  fi
  note "unit tests ($preset)" $((total - bad)) "$bad" $((SECONDS - begin))
  local here
  here=$(sed -n 's/.*not run: \([0-9][0-9]*\).*/\1/p' "build/$preset/Testing/Temporary/LastTest.log" |
    awk '{n += $1} END {print n + 0}')
  not_run=$((not_run + here))
}

lab() {
  local begin=$SECONDS log=$logs/lab.log result ok bad
  echo "=== lab"
  LAB_TIMEOUT=${LAB_TIMEOUT:-600} tests/lab/lab.sh test 2>&1 | tee "$log"
  local status=${PIPESTATUS[0]}
  result=$(tail -n 1 "$log")
  if [[ $result =~ ^lab:\ ([0-9]+)\ passed,\ ([0-9]+)\ failed$ ]]; then
    ok=${BASH_REMATCH[1]} bad=${BASH_REMATCH[2]}
    # The machine's own verdict and the count must agree.
    [ "$status" = 0 ] || [ "$bad" != 0 ] || bad=1
  else
    echo "=== lab did not run to its end"
    ok=$(grep -c '^ok ' "$log") bad=$(($(grep -c '^not ok ' "$log") + 1))
  fi
  note "lab" "$ok" "$bad" $((SECONDS - begin))
}

mkdir -p "$logs"
part "dependencies" tools/dependencies.sh test
part "formatting" formatting
if part "build (release)" build release; then
  unit_tests release
  lab
fi
part "build (asan)" build asan && unit_tests asan

echo
echo "=== summary (logs in $logs)"
printf '%s\n' "${summary[@]}"
echo "not run: $not_run (tests on real drives; set ODOMD_DRIVES)"
echo "in $((SECONDS / 60)) min $((SECONDS % 60)) s"
echo "$passed passed, $failed failed"
[ "$failed" = 0 ]
