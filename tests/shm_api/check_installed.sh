#!/bin/sh
# Installs the client library into a separate directory, builds programs against it with pkg-config
# and with find_package, and lets them follow a writer.
#   check_installed.sh BUILD_DIR PUBLISHER CC CXX [SANITIZERS]
# EMULATOR is the command that runs a cross-built program; empty for native programs.
set -eu
build=$1 publisher=$2 cc=$3 cxx=$4 sanitizers=${5:+-fsanitize=$5}
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
writer=
trap 'if [ -n "$writer" ]; then kill "$writer"; fi; rm -rf "$work"' EXIT

for component in library development; do
  cmake --install "$build" --component $component --prefix "$work/prefix" >"$work/install.log"
done

export PKG_CONFIG_PATH
PKG_CONFIG_PATH=$(dirname "$(find "$work/prefix" -name odom.pc)")
libraries=$(dirname "$PKG_CONFIG_PATH")
warnings='-Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror'
# Unquoted on purpose: lists of flags.
$cc -std=c11 $warnings $sanitizers "$here/consumer/pose.c" -o "$work/pose_c" \
  $(pkg-config --cflags --libs odom) -Wl,-rpath,"$libraries"
# The example in docs/shm.md is a part of this program.
example=$(awk '/^```c$/ { c = 1; next } c && /^```$/ { exit } c' "$here/../../docs/shm.md")
case $(cat "$here/consumer/pose.c") in
*"${example:?}"*) ;;
*) echo 'docs/shm.md has another example'; exit 1 ;;
esac
# Each header compiles alone, in its languages. The examples are programs in C++.
for header in types.h odom.h odom.hpp; do
  echo "#include <odom/$header>" >"$work/alone.c"
  [ $header = odom.hpp ] ||
    $cc -std=c11 $warnings $(pkg-config --cflags odom) -fsyntax-only "$work/alone.c"
  [ $header != odom.hpp ] || cat >>"$work/alone.c" <<'end'
double x_of(odom::Client& client) {
  double x = 0.0;
  (void)client.read_in_place([&x](const odom::View& view) { x = view.x(); });
  return x;
}
end
  $cxx -std=c++17 -x c++ $warnings -Wold-style-cast $(pkg-config --cflags odom) -fsyntax-only \
    "$work/alone.c"
done

cmake -S "$here/consumer" -B "$work/build" -DCMAKE_PREFIX_PATH="$work/prefix" \
  -DCMAKE_C_COMPILER="$cc" -DCMAKE_C_FLAGS="$sanitizers" >"$work/configure.log" ||
  { cat "$work/configure.log"; exit 1; }
cmake --build "$work/build" >"$work/build.log" || { cat "$work/build.log"; exit 1; }

# Without a segment: an error of one line, and exit status 1.
if ${EMULATOR-} "$work/pose_c" "$work/segment" 2>"$work/message"; then exit 1; fi
grep -q 'no such segment' "$work/message"

"$publisher" "$work/segment" 100000000 2000 &
writer=$!
tries=0
until [ -e "$work/segment" ]; do
  tries=$((tries + 1))
  [ $tries -lt 100 ]
  sleep 0.05
done
for program in "$work/pose_c" "$work/build/pose_c" "$work/build/pose_c_static"; do
  ${EMULATOR-} "$program" "$work/segment" >"$work/output"
  grep -q 'in place' "$work/output"
done
