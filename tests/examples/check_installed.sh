#!/bin/sh
# Installs library, headers, examples and the Python module into a separate directory, builds the
# examples there with pkg-config and with find_package, and lets each follow a path.
#   check_installed.sh BUILD_DIR SEGMENT_WRITER CC CXX PYTHON [SANITIZERS]
set -eu
build=$1 writer=$2 cc=$3 cxx=$4 python=$5 sanitizers=${6:+-fsanitize=$6}
work=$(mktemp -d)
publisher=
trap 'if [ -n "$publisher" ]; then kill "$publisher" || :; fi; rm -rf "$work"' EXIT

for component in library development python; do
  cmake --install "$build" --component $component --prefix "$work/prefix" >"$work/install.log"
done
examples=$work/prefix/share/doc/odom/examples
cp -r "$examples" "$work/by_make"

export PKG_CONFIG_PATH
PKG_CONFIG_PATH=$(dirname "$(find "$work/prefix" -name odom.pc)")
libraries=$(dirname "$PKG_CONFIG_PATH")
warnings='-Wall -Wextra -Werror'
make -C "$work/by_make" CC="$cc" CXX="$cxx" CFLAGS="-O2 $warnings $sanitizers" \
  CXXFLAGS="-O2 $warnings $sanitizers" LDFLAGS="-Wl,-rpath,$libraries" >"$work/log" 2>&1 ||
  { cat "$work/log"; exit 1; }
{ cmake -S "$examples" -B "$work/by_cmake" -DCMAKE_PREFIX_PATH="$work/prefix" \
  -DCMAKE_C_COMPILER="$cc" -DCMAKE_CXX_COMPILER="$cxx" \
  -DCMAKE_C_FLAGS="$sanitizers" -DCMAKE_CXX_FLAGS="$sanitizers" &&
  cmake --build "$work/by_cmake"; } >"$work/log" 2>&1 || { cat "$work/log"; exit 1; }

printf 'x,y\n0,0\n1,0\n2,0\n' >"$work/path.csv"
mkfifo "$work/commands"
"$writer" "$work/segment" 500000000 <"$work/commands" >"$work/log" &
exec 3>"$work/commands"
while :; do echo 'publish vx=1.0'; sleep 0.05; done >&3 &
publisher=$!

# follows PROGRAM...: the program must give three commands and end.
follows() {
  timeout 120 "$@" --shm "$work/segment" --path "$work/path.csv" --cycles 3 >"$work/output"
  { [ "$(wc -l <"$work/output")" = 4 ] && grep -q ',drive,' "$work/output"; } ||
    { cat "$work/output"; exit 1; }
}
until [ -e "$work/segment" ]; do sleep 0.05; done
for program in by_make/stanley_c by_make/stanley_cpp by_cmake/stanley_c by_cmake/stanley_cpp; do
  follows "$work/$program"
done
# A library with sanitizers cannot be loaded into an ordinary Python.
if [ -z "$sanitizers" ]; then
  unset ODOM_LIBRARY
  PYTHONPATH=$(dirname "$(dirname "$(find "$work/prefix" -name py.typed)")")
  export PYTHONPATH PYTHONDONTWRITEBYTECODE=1
  follows "$python" "$examples/stanley.py"
fi
