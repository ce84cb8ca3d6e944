# Sourced by the scripts of the campaigns: changes to the root of the tree and installs the packages for $needs (default: campaign).
set -uo pipefail
cd "$(dirname "$0")/../.." || exit 1
begin=$SECONDS
name=$(basename "$0" .sh)
bin=$PWD/build/release/bin
tools/dependencies.sh "${needs:-campaign}" || exit 1
mkdir -p build/logs

# build TARGET...: builds targets of the release build.
build() {
  cmake --preset release -DODOMD_TESTS=ON >/dev/null && cmake --build --preset release --target "$@" >/dev/null || exit 1
}

# unit_tests COMMAND...: runs this command, which builds and runs unit tests; prints a dated summary line.
unit_tests() {
  local status verdict log=build/logs/$name.log
  "$@" 2>&1 | tee "$log"
  status=${PIPESTATUS[0]}
  verdict=$(grep -E '[0-9]+% tests passed' "$log" | tail -n 1)
  echo "$(date -u +%F) $name: ${verdict:-did not build}; $((SECONDS - begin)) s"
  exit "$status"
}
