#!/bin/bash
# The unit tests under ThreadSanitizer (clang). Ends with a dated summary line.
set -uo pipefail
cd "$(dirname "$0")/../.."
begin=$SECONDS
tools/dependencies.sh campaign || exit 1
mkdir -p build/logs
log=build/logs/tsan.log
# clang 14's runtime stops at its start on kernels that randomise more address bits than it expects.
run=()
setarch "$(uname -m)" -R true 2>/dev/null && run=(setarch "$(uname -m)" -R)
{
  cmake --preset tsan && cmake --build --preset tsan -j "$(nproc)" &&
    TSAN_OPTIONS=${TSAN_OPTIONS:-halt_on_error=1:second_deadlock_stack=1:suppressions=$PWD/tests/campaign/tsan.supp} \
      "${run[@]}" ctest --preset tsan --progress -j "$(nproc)"
} 2>&1 | tee "$log"
status=${PIPESTATUS[0]}
verdict=$(grep -E '[0-9]+% tests passed' "$log" | tail -n 1)
echo "$(date -u +%F) tsan: ${verdict:-did not build}; $((SECONDS - begin)) s"
exit "$status"
