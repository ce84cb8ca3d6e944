#!/bin/bash
# Measures how odom serve affects the beat, and shows its page: serve.sh BUILD_DIR FOLDER
#
# Drives a simulated car into odomd in real time, for 60 s alone and for 60 s with 50 viewers, 10 of whom read nothing,
# and compares the 99th percentiles of the ticks' lateness and of cyclictest's, and the server's memory. Then checks
# the metrics with Prometheus' own parsers, and writes screenshots of the page in Chromium into FOLDER. Fails if viewers
# raise the percentile of the beat by a tenth or the memory of the server by 8 MB.
set -euo pipefail
[ $# = 2 ] || { sed -n '2,7s/^# \?//p' "$0" >&2; exit 2; }
here=$(realpath "$(dirname "$0")")
PATH=$(realpath "$1")/bin:$PATH
mkdir -p "$2"
out=$(realpath "$2")
seconds=${SERVE_SECONDS:-60}
run=$(mktemp -d)
trap 'kill $(jobs -p) 2>/dev/null || true; wait; rm -rf "$run"' EXIT
cd "$run"

sim=(odom sim --scenario lap --laps 40 --live --can - --camera-socket "$run/camera.sock")
"${sim[@]}" --config-only --out car >/dev/null
mkfifo bus
odomd --config car/car.toml --can - --exit-at-end --runtime-directory "$run" --log-level error <bus &
"${sim[@]}" --out drive >bus 2>/dev/null &
sleep 5

# measure NAME: the lateness during these seconds, from odomd's histogram and from cyclictest [us].
measure() {
  local -a before after
  mapfile -t before < <(histogram)
  cyclictest -q -t1 -p80 -i5000 -D "$seconds" -h 20000 2>/dev/null >cyclic || true
  mapfile -t after < <(histogram)
  printf '%s\n' "${before[@]}" "${after[@]}" | awk '{n[NR] = $1} END {
    for (i = 1; i <= 64; ++i) all += d[i] = n[i + 64] - n[i]
    for (i = 1; (sum += d[i]) < 0.99 * all; ++i);
    printf "%.1f", 2 ^ ((i - 1 - (sum - 0.99 * all) / d[i]) / 4)}' >"$1.beat"
  awk '/^[0-9]/ {all += n[++k] = $2; at[k] = $1} END {while (sum < 0.99 * all) sum += n[++i]; print at[i] + 0}' cyclic >"$1.cyclic"
  echo "$1: p99 of the ticks' lateness $(cat "$1.beat") us, of cyclictest $(cat "$1.cyclic") us"
}
histogram() {
  curl -sN --max-time 2 "http://127.0.0.1:$port/events" |
    sed -n '/^event: state/{n;s/^data: //p;q}' | jq '.beat.late[]'
}

odom serve --listen 127.0.0.1:0 --shm "$run/pose" --socket "$run/status.sock" 2>said &
server=$!
sleep 2
port=$(sed -n 's/.*:\([0-9]*\)\/.*/\1/p' said)
measure alone
memory() { awk '/^VmRSS/ {print $2}' "/proc/$server/status"; }
rss=$(memory)
for i in $(seq 50); do
  if [ "$i" -le 10 ]; then
    (exec 3<>"/dev/tcp/127.0.0.1/$port"; printf 'GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n' >&3; exec sleep 600) &
  else
    nice -n 10 curl -sN "http://127.0.0.1:$port/events" >/dev/null &
  fi
done
sleep 2
measure viewers
grown=$(($(memory) - rss))

curl -s "http://127.0.0.1:$port/metrics" >metrics
odom status --openmetrics --socket "$run/status.sock" >printed
/usr/bin/python3 - metrics printed <<'end'
import sys
from prometheus_client import openmetrics, parser
import prometheus_client.openmetrics.parser
for name in sys.argv[1:]:
    text = open(name).read()
    families = list(openmetrics.parser.text_string_to_metric_families(text))
    classic = list(parser.text_string_to_metric_families(text))
    print(f"{name}: {len(families)} families in OpenMetrics, {len(classic)} in the older format")
end
/usr/bin/python3 "$here/serve_screenshots.py" "http://127.0.0.1:$port/" "$out"

echo "memory of the server: $rss kB, with viewers $grown kB more"
paste alone.beat viewers.beat alone.cyclic viewers.cyclic | awk -v grown="$grown" '{
  printf "ratio of p99: beat %.2f, cyclictest %.2f\n", $2 / $1, $4 / $3
  if ($2 / $1 > 1.1) failed = "the beat later by more than a tenth"
  if (grown > 8192) failed = "more than 8192 kB"
  if (failed) {print "FAIL: " failed; exit 1}}'
