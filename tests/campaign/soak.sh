#!/bin/bash
# Drives the simulated car into odomd for a long time, natively and in real time, through standard
# input and the camera socket: no frame may be lost, nothing may leak or fall behind. cyclictest
# runs at the same time and shows this machine's latencies. Ends with a dated summary line.
#
#   soak.sh [SECONDS]   (default 3600)
seconds=${1:-3600}
. "$(dirname "$0")/common.sh"
build odomd odom_command
PATH=$bin:$PATH

run=$(mktemp -d)
shm=/odomd-soak-$$
children=()
clean_up() {
  [ ${#children[@]} = 0 ] || kill "${children[@]}" 2>/dev/null
  wait
  rm -rf "$run" "/dev/shm$shm" "/dev/shm$shm.lock"
}
trap clean_up EXIT
trap 'exit 130' INT TERM

fail() {
  echo "$(date -u +%F) soak: FAILED: $*"
  tail -n 5 "$run/odomd.log"
  exit 1
}

status() { odom status --json --socket "$run/status.sock" | jq -r "$1"; }
memory() { awk '/^VmRSS/ {print $2}' "/proc/$daemon/status"; }
descriptors() { find "/proc/$daemon/fd" -mindepth 1 | wc -l; }

arguments=(--scenario stop-and-go --laps 10000 --duration "$seconds")
odom sim "${arguments[@]}" --config-only --out "$run/car" >/dev/null || exit 1
mkfifo "$run/bus"
odomd --config "$run/car/car.toml" --can - --shm "$shm" --log-level warn \
  --camera-socket "$run/camera.sock" --status-socket "$run/status.sock" <"$run/bus" 2>"$run/odomd.log" &
daemon=$!
odom sim "${arguments[@]}" --live --can - --camera-socket "$run/camera.sock" >"$run/bus" 2>/dev/null &
simulator=$!
odom pose --shm "$shm" --wait 10 --follow --csv --until-stale >/dev/null 2>"$run/client.log" &
client=$!
cyclictest -q -m -p 40 -i 5000 -D "$seconds" >"$run/cyclictest" 2>/dev/null &
children=("$daemon" "$simulator" "$client" $!)

sleep 10
[ -d "/proc/$daemon" ] || fail "odomd ended"
memory_before=$(memory) descriptors_before=$(descriptors)
while kill -0 "$simulator" 2>/dev/null; do
  kill -0 "$daemon" 2>/dev/null || fail "odomd ended"
  sleep 1
done
wait "$simulator" || fail "odom sim failed"
sleep 1
memory_after=$(memory) descriptors_after=$(descriptors)
read -r ticks missed overruns received bad < <(status '[.beat.ticks, .beat.missed, .beat.overruns,
  .can[0].received, ([.frames[]] | add) - .frames.decoded] | map(tostring) | join(" ")')
wakeup=$(status '.beat.wakeup_us | "\(.p99 | round)/\(.max | round)"')
kill "$daemon"
wait "$daemon" || fail "odomd ended with status $?"
wait "$client"
children=()

summary="$seconds s, $ticks ticks, $missed missed, $overruns overruns; $received frames, $bad not decoded;
  wake-up late by (99 %/max) $wakeup us, cyclictest $(sed -n 's/.*Avg: *\([0-9]*\) Max: *\([0-9]*\).*/avg \1 max \2/p' "$run/cyclictest") us;
  memory $memory_before to $memory_after kB, descriptors $descriptors_before to $descriptors_after; client: $(tail -n 1 "$run/client.log")"
summary=$(tr -s '\n ' '  ' <<<"$summary")
[ $((missed * 1000)) -le "$ticks" ] || fail "too many ticks missed: $summary"
[ "$bad" = 0 ] || fail "frames not decoded: $summary"
[ $((memory_after - memory_before)) -le 512 ] || fail "memory grew: $summary"
[ "$descriptors_after" -le "$descriptors_before" ] || fail "descriptors leaked: $summary"
grep -q ' 0 lost' "$run/client.log" || fail "a client lost ticks: $summary"
echo "$(date -u +%F) soak: $summary"
