# Sourced by tests with full traffic for the real odomd: 8,000 frames/s on four buses, of which the
# 500 of the simulated car are mapped and protected, 28 camera poses/s, clients that wait for every
# pose, a client that polls, and one that reads the status.
#
# Expects ODOMD_BIN_DIR, and $name, the name of the test. Leaves its files in $work.
discipline=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
. "$discipline/../../lab/guest.sh" # await, status
work=$(mktemp -d)
run=$work
shm=/odomd-$name-$$
children=()

clean_up() {
  [ ${#children[@]} = 0 ] || kill "${children[@]}" 2>/dev/null
  await 10 no_children || kill -KILL "${children[@]}" 2>/dev/null
  wait
  rm -rf "$work" "/dev/shm$shm" "/dev/shm$shm.lock"
}
trap clean_up EXIT
trap 'exit 130' INT TERM

no_children() {
  local child
  for child in "${children[@]}"; do ! kill -0 "$child" 2>/dev/null || return 1; done
}

fail() {
  echo "$name: FAILED: $*"
  [ ! -s "$work/odomd.log" ] || tail -n 5 "$work/odomd.log" | sed 's/^/  odomd: /'
  exit 1
}

# start_full_traffic SECONDS [COMMAND...]: the traffic for this time, into an odomd that is started by
# COMMAND (if given). $more_config is added to its configuration. The number of frames is in
# $work/frames once all have been sent.
start_full_traffic() {
  local seconds=$1
  shift
  odom sim --scenario stop-and-go --laps 10000 --duration "$seconds" --start-time 1000 \
    --out "$work/car" >/dev/null || fail "odom sim"
  echo "${more_config-}" >>"$work/car/car.toml"
  mkfifo "$work/bus"
  "$@" odomd --config "$work/car/car.toml" --can - --shm "$shm" --log-level warn \
    --camera-socket "$work/camera.sock" --status-socket "$work/status.sock" \
    <"$work/bus" 2>"$work/odomd.log" &
  daemon=$!
  children+=("$daemon")
  awk -v rate=8000 -v own=500 -v count="$work/frames" -f "$discipline/full_traffic.awk" \
    "$work/car/drive.log" >"$work/bus" &
  children+=($!)
  await 60 status '.beat.ticks > 0' -e || fail "odomd does not begin"
  odom camera send --log "$work/car/camera.csv" --socket "$work/camera.sock" --shm "$shm" \
    --wait 20 >/dev/null 2>&1 &
  children+=($!)
  local client
  for client in 1 2 3 4; do
    odom pose --shm "$shm" --wait 20 --follow --csv >/dev/null 2>&1 &
    children+=($!)
  done
}

# stop_daemon: returns the daemon's exit status, also if it has ended before.
stop_daemon() {
  kill "$daemon" 2>/dev/null
  wait "$daemon"
}
