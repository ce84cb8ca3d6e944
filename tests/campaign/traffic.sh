#!/bin/bash
# Ten minutes of full traffic, natively, next to cyclictest: traffic.sh [SECONDS [CPU]]
#
# odomd takes 8,000 frames/s from a paced log and the camera's poses, and four clients read it. It
# shares a CPU with a cyclictest of the same interval and phase (both wake at multiples of the
# period) and a higher priority, so that odomd cannot delay cyclictest, but other delays of this CPU
# affect both. Fails if
#
#   - a frame is lost or malformed;
#   - odomd misses a cycle, and no sample of cyclictest within one period of the missed instant was
#     late by a fifth of a period (1 ms) or more;
#   - its memory (VmRSS, every second) or the number of its open files grows after the first minute
#     (or third of a shorter run).
#
# Ends with a dated summary line.
seconds=${1:-600} cpu=${2:-$(($(nproc) - 1))}
. "$(dirname "$0")/common.sh"
build odomd odom_command
ODOMD_BIN_DIR=$bin
. tests/daemon/discipline/full_traffic.sh

more_config=$(printf '[realtime]\ncpu = %d' "$cpu")
start_full_traffic "$seconds"
odom pose --shm "$shm" --wait 10 --follow --csv --clock monotonic >"$work/poses.csv" \
  2>"$work/client.poses" &
witness=$!
cyclictest -q -m -p 46 -i 5000 -a "$cpu" --secaligned -D "$seconds" --spike=1000 --spike-nodes=100000 \
  -h 20000 --histfile="$work/histogram" >"$work/cyclictest" 2>&1 &
yardstick=$!
children+=("$witness" "$yardstick")

# After the start, memory is measured every second.
settled=$((seconds < 180 ? seconds / 3 : 60))
from=0 most=0 files=
descriptors() { find "/proc/$daemon/fd" -mindepth 1 | wc -l; }
begin=$SECONDS
until [ "$(status '.can[0].link' 2>/dev/null)" = ended ]; do
  kill -0 "$daemon" 2>/dev/null || fail "odomd ended"
  [ $((SECONDS - begin)) -lt $((seconds + 60)) ] || fail "the log does not end: $(status .can -c)"
  memory=$(awk '/^VmRSS/ {print $2}' "/proc/$daemon/status")
  if [ $((SECONDS - begin)) -ge $settled ]; then
    [ $from != 0 ] || { from=$memory; files=$(descriptors); }
    [ "$memory" -le $most ] || most=$memory
  fi
  sleep 1
done
status . >"$work/status.json"
files_after=$(descriptors)
stop_daemon || fail "odomd ended with status $?"
kill "$witness"
wait "$witness" "$yardstick"
grep -q ' 0 lost' "$work/client.poses" || fail "the witness lost poses: $(tail -n 1 "$work/client.poses")"

value() { jq -r "$1" "$work/status.json"; }
sent=$(cat "$work/frames")
read -r received lost malformed carried camera ticks < <(value '[.can[0].received, .can[0].lost, .can[0].malformed,
  .beat.carried_over, .camera.messages, .beat.ticks] | map(tostring) | join(" ")')

# Missed instants are the gaps between published poses; spikes are `T: 0 Spike: LATE: TS: WOKE` in us.
read -r missed unseen first_unseen < <(awk -v period=5000 '
  FNR == NR {
    if (/Spike:/) {
      gsub(/[A-Za-z:]/, " ")
      due = $3 - $2
      for (k = int(due / period); k * period <= $3 + period; ++k) late[k]
    }
    next
  }
  FNR == 1 {n = split($0, names, ","); for (i = 1; i <= n; i++) column[names[i]] = i; next}
  {
    split($0, fields, ",")
    split(fields[column["t"]], parts, ".")
    k = int((parts[1] * 1000000 + substr(parts[2] "000000", 1, 6)) / period + 0.5)
    if (last) for (i = last + 1; i < k; ++i) {
      ++missed
      if (!((i - 1) in late) && !(i in late) && !((i + 1) in late)) {
        ++unseen
        if (!first) first = i * period / 1000000
      }
    }
    last = k
  }
  END {print missed + 0, unseen + 0, first + 0}' "$work/cyclictest" "$work/poses.csv")

spikes=$(grep -c 'Spike:' "$work/cyclictest")
missing_spikes=$(awk '/Spike:/ {gsub(/[A-Za-z:]/, " "); if ($2 >= 5000) n += int($2 / 5000)} END {print n + 0}' "$work/cyclictest")
cyclic=$(awk -F: '/Avg Latencies/ {avg = $2} /Max Latencies/ {max = $2} END {print "avg " avg + 0 " max " max + 0}' "$work/histogram")
summary="$seconds s: $sent frames, $received received, $lost lost, $malformed malformed, $carried drains left some for the next tick; $camera camera poses;
  $ticks ticks, $missed missed, $unseen of them unseen by cyclictest (it missed $missing_spikes, $spikes samples later than 1 ms);
  wake-up late by (99 %/99.9 %/max) $(value '.beat.wakeup_us | "\(.p99 | round)/\(.p999 | round)/\(.max | round)"') us, cyclictest $cyclic us;
  execution $(value '.beat.execution_us | "\(.p50 | round)/\(.p999 | round)/\(.max | round)"') us (median/99.9 %/max);
  VmRSS $from kB after $settled s, then at most $most kB; open files $files to $files_after"
summary=$(tr -s '\n ' '  ' <<<"$summary")
[ "$received" = "$sent" ] && [ "$lost" = 0 ] && [ "$malformed" = 0 ] || fail "frames lost: $summary"
[ "$unseen" = 0 ] || fail "missed by odomd alone (first at $first_unseen s): $summary"
[ "$most" -le "$from" ] || fail "memory grew: $summary"
[ "$files_after" -le "$files" ] || fail "files stay open: $summary"
echo "$(date -u +%F) traffic: $summary"
