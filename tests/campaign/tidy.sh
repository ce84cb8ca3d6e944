#!/bin/bash
# clang-tidy for every source file of the tree, mypy for the Python files. Ends with dated summary
# lines.
#
#   tests/campaign/tidy.sh [FILE...]
#
# FILE: check only these. The warnings are kept in build/logs/tidy.log.
. "$(dirname "$0")/common.sh"
log=build/logs/tidy.log
# clang's own compile commands for everything that can be built, including benchmarks and fuzzers.
cmake -G Ninja -B build/tidy -DCMAKE_C_COMPILER=clang-16 -DCMAKE_CXX_COMPILER=clang++-16 -DCMAKE_EXPORT_COMPILE_COMMANDS=ON \
  -DODOMD_TESTS=ON -DODOMD_UNITY=OFF -DODOMD_BENCH=ON -DODOMD_FUZZ=ON >build/logs/configure-tidy.log 2>&1 || {
  cat build/logs/configure-tidy.log
  exit 1
}
jq -r '.[].file' build/tidy/compile_commands.json >build/tidy/files
known() { grep -qxF "$PWD/$1" build/tidy/files; }

files=()
for file in "${@:-}"; do [ -z "$file" ] || files+=("$(realpath --relative-to=. "$file")"); done
[ ${#files[@]} -gt 0 ] || mapfile -t files < <(git ls-files '*.cpp' '*.c')
checked=() passed_over=()
for file in "${files[@]}"; do
  if known "$file"; then checked+=("$file"); else passed_over+=("$file"); fi
done
[ ${#passed_over[@]} = 0 ] || echo "not built here, so not checked: ${passed_over[*]}"

printf '%s\0' "${checked[@]}" |
  xargs -0 -n 1 -P "$(nproc)" clang-tidy-16 --quiet -p build/tidy 2>&1 |
  grep -v -E '^[0-9]+ warnings? (and [0-9]+ errors? )?(generated|treated as errors?)' | tee "$log"
status=${PIPESTATUS[1]}
# Each file that includes a header repeats the header's warnings.
warnings=$(grep -E ': (warning|error): ' "$log" | sort -u | wc -l)
[ "$warnings" = 0 ] || status=1
echo "$(date -u +%F) clang-tidy: ${#checked[@]} files, $warnings warnings; $((SECONDS - begin)) s"
[ $# = 0 ] || exit "$status"

mapfile -t modules < <(git ls-files 'python/odom/*.py' 'examples/*.py' 'tests/python/*.py' 'tests/examples/*.py' 'tests/tools/export/*.py')
MYPYPATH=python:tests/python:tests/examples:tests/tools/export mypy --strict --cache-dir build/tidy/mypy "${modules[@]}" || status=1
echo "$(date -u +%F) mypy --strict: ${#modules[@]} files"
exit "$status"
