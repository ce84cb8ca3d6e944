#!/bin/bash
# All unit tests, including those of the tools, under AddressSanitizer and UBSan. Ends with a dated
# summary line.
set -uo pipefail
cd "$(dirname "$0")/../.."
begin=$SECONDS
tools/dependencies.sh campaign || exit 1
mkdir -p build/logs
log=build/logs/asan.log
{
  # Without -O1 the long replays take an hour; with it, g++ wrongly reports uninitialised values.
  cmake --preset asan -DODOMD_TESTS=ON -DODOMD_TOOLS=ON -DCMAKE_C_FLAGS_DEBUG="-O1 -g1" \
    -DCMAKE_CXX_FLAGS_DEBUG="-O1 -g1 -Wno-maybe-uninitialized" && cmake --build --preset asan -j "$(nproc)" &&
    UBSAN_OPTIONS=${UBSAN_OPTIONS:-print_stacktrace=1} ctest --preset asan --progress -j "$(nproc)"
} 2>&1 | tee "$log"
status=${PIPESTATUS[0]}
verdict=$(grep -E '[0-9]+% tests passed' "$log" | tail -n 1)
echo "$(date -u +%F) asan: ${verdict:-did not build}; $((SECONDS - begin)) s"
exit "$status"
