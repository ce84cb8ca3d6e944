#!/bin/bash
# The unit tests under ThreadSanitizer (clang). Ends with a dated summary line.
. "$(dirname "$0")/common.sh"
# The runtime of clang exits at start on kernels that randomise more address bits than it expects.
run=()
setarch "$(uname -m)" -R true 2>/dev/null && run=(setarch "$(uname -m)" -R)
tests() {
  cmake --preset tsan && cmake --build --preset tsan -j "$(nproc)" &&
    TSAN_OPTIONS=${TSAN_OPTIONS:-halt_on_error=1:second_deadlock_stack=1:suppressions=$PWD/tests/campaign/tsan.supp} \
      "${run[@]}" ctest --preset tsan --progress -j "$(nproc)"
}
unit_tests tests
