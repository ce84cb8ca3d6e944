#!/bin/bash
# All unit tests, including those of the tools, under AddressSanitizer and UBSan. Ends with a dated
# summary line.
. "$(dirname "$0")/common.sh"
# Without -O1 the long replays take an hour; with it, g++ wrongly reports uninitialised values.
tests() {
  cmake --preset asan -DODOMD_TESTS=ON -DODOMD_TOOLS=ON -DCMAKE_C_FLAGS_DEBUG="-O1 -g1" \
    -DCMAKE_CXX_FLAGS_DEBUG="-O1 -g1 -Wno-maybe-uninitialized" && cmake --build --preset asan -j "$(nproc)" &&
    UBSAN_OPTIONS=${UBSAN_OPTIONS:-print_stacktrace=1} ctest --preset asan --progress -j "$(nproc)"
}
unit_tests tests
