#!/bin/bash
# clang-tidy over every source file of the tree. Ends with a dated summary line.
set -uo pipefail
cd "$(dirname "$0")/../.."
begin=$SECONDS
tools/dependencies.sh campaign || exit 1
mkdir -p build/logs
log=build/logs/tidy.log
cmake --preset release >/dev/null || exit 1
git ls-files -z '*.cpp' '*.c' |
  xargs -0 -n 1 -P "$(nproc)" clang-tidy --quiet -p build/release --extra-arg=-Wno-unknown-warning-option 2>&1 |
  grep -v -E '^[0-9]+ warnings? (generated|treated as errors?)' | tee "$log"
status=${PIPESTATUS[1]}
# A header's warning is repeated by each file that includes it.
warnings=$(grep -E ': (warning|error): ' "$log" | sort -u | wc -l)
[ "$warnings" = 0 ] || status=1
echo "$(date -u +%F) clang-tidy: $(git ls-files '*.cpp' '*.c' | wc -l) files, $warnings warnings; $((SECONDS - begin)) s"
exit "$status"
