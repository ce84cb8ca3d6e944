#!/bin/bash
# Demonstrates odomd live, without any CAN hardware: builds it, drives a simulated car for a lap in
# real time, and reports how accurate its pose was.
#
#   bash tools/demo.sh
#
# The simulator sends the car's CAN frames to odomd's standard input and the camera poses to its
# socket, while a client reads the pose from shared memory. The results (poses, report, picture) are
# in build/demo. The words in ODOMD_DEMO_ARGUMENTS are passed to `odom sim`, such as '--laps 3'.
set -euo pipefail
cd "$(dirname "$0")/.."

[ $# = 0 ] || {
  echo "demo: takes no arguments; for odom sim: ODOMD_DEMO_ARGUMENTS='$*' bash tools/demo.sh" >&2
  exit 2
}
tools/dependencies.sh build
echo "=== building (several minutes; an interrupted build continues where it stopped)"
# The demonstration needs no tests; a tree that is already configured keeps its settings.
tests=()
[ -f build/release/CMakeCache.txt ] || tests=(-DODOMD_TESTS=OFF)
mkdir -p build/logs
cmake --preset release "${tests[@]}" >build/logs/configure-release.log 2>&1 || {
  cat build/logs/configure-release.log
  exit 1
}
cmake --build --preset release -j "$(nproc)" --target odomd odom
PATH=$PWD/build/release/bin:$PATH

# This run has its own sockets and segment: it disturbs no daemon, and leaves nothing behind.
run=$(mktemp -d "${TMPDIR:-/tmp}/odomd-demo.XXXXXX")
out=$PWD/build/demo
shm=/odomd-demo-$$
children=()
clean_up() {
  [ ${#children[@]} = 0 ] || kill "${children[@]}" 2>/dev/null || true
  wait
  rm -rf "$run" "/dev/shm$shm" "/dev/shm$shm.lock"
}
trap clean_up EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

fail() {
  echo "demo: $*" >&2
  [ ! -s "$run/odomd.log" ] || sed 's/^/  odomd: /' "$run/odomd.log" >&2
  exit 1
}

read -r -a arguments <<<"${ODOMD_DEMO_ARGUMENTS-}"
[[ " ${arguments[*]-} " == *" --scenario"[\ =]* ]] || arguments+=(--scenario lap)
[[ " ${arguments[*]} " == *" --laps"[\ =]* ]] || arguments+=(--laps 1)
simulator=(odom sim "${arguments[@]}" --live --can - --camera-socket "$run/camera.sock")
"${simulator[@]}" --config-only --out "$run/car" >/dev/null && [ -f "$run/car/car.toml" ] || {
  echo "demo: fix ODOMD_DEMO_ARGUMENTS='${ODOMD_DEMO_ARGUMENTS-}'; $out is unchanged" >&2
  exit 2
}
# The results of an earlier run are removed only once this one can start.
rm -rf "$out"
mkdir -p "$out"

echo "=== driving: odom sim | odomd, camera poses over a socket"
mkfifo "$run/bus"
odomd --config "$run/car/car.toml" --can - --exit-at-end --shm "$shm" --log-level warn \
  --camera-socket "$run/camera.sock" --status-socket "$run/status.sock" \
  <"$run/bus" 2>"$run/odomd.log" &
daemon=$!
"${simulator[@]}" --out "$run/drive" >"$run/bus" 2>"$run/sim.log" &
driving=$!
odom pose --shm "$shm" --wait 10 --follow --csv --clock log --until-stale \
  >"$out/pose.csv" 2>"$run/client.log" &
client=$!
odom pose --shm "$shm" --wait 10 --follow --until-stale 2>/dev/null |
  awk 'NR % 5 == 1 { print; fflush() }' &  # one line per second
watcher=$!
children=("$daemon" "$driving" "$client" "$watcher")

# The counts are lost when the daemon ends, so keep its last answer.
noted=
while kill -0 "$daemon" 2>/dev/null; do
  ! odom status --socket "$run/status.sock" >"$run/status" 2>/dev/null || mv "$run/status" "$out/status.txt"
  ! odom status --json --socket "$run/status.sock" >"$run/status" 2>/dev/null || mv "$run/status" "$out/status.json"
  if [ -z "$noted" ] && grep -qs not_realtime "$out/status.json"; then
    echo "note: without real-time privileges the mode is degraded (not_realtime): ticks may be late," \
      "which is fine here, but not on a car; docs/realtime.md, \"What is asked of the machine\""
    noted=yes
  fi
  sleep 0.5
done
wait "$daemon" || fail "odomd failed"
wait "$driving" || fail "odom sim failed: $(tail -n 1 "$run/sim.log")"
wait "$client" || fail "the client failed: $(tail -n 1 "$run/client.log")"
wait "$watcher" || true
children=()

# The same drive without the camera, for comparison.
cp "$run"/drive/{drive.log,camera.csv,truth.csv,car.dbc,car.toml} "$out"
odom replay --config "$run/car/car.toml" --can "$out/drive.log" --out "$out/odometry.csv" >/dev/null 2>&1
odom evaluate --reference "$out/truth.csv" --pose "$out/odometry.csv" --pose "$out/pose.csv" --align none \
  --camera "$out/camera.csv" --picture "$out/track.png" --title "odomd, live" >"$out/evaluation.txt"

# The main figures of report and status; the complete files are next to the picture.
echo "=== report (pose: with the camera; odometry: without)"
sed -n '/^ .*odometry .*pose/p; /path length/p; /end error \[/p; /position rms \[/p; /heading error at/p' "$out/evaluation.txt"
echo
awk '/^── /{shown = $2 == "beat" || $2 == "calibration"} shown || ($1 == "source" && $2 == "state") || $1 == "camera"' "$out/status.txt" | grep . ||
  echo "demo: odom status did not show the beat; see $out/status.txt" >&2
echo
# The beat counts missed ticks (above), until half a second before the end; a client's count would differ.
echo "client      $(tail -n 1 "$run/client.log" | sed 's/^odom pose: //; s/[0-9]* missed by the daemon, //')"
echo
echo "poses, logs, evaluation and status: $out"
echo "picture: $out/track.png"
echo "to use the programs here: export PATH=$PWD/build/release/bin:\$PATH"
echo "next: docs/tutorial.md"
