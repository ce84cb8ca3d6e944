# The main task on a real bus with a real-time kernel: canplayer plays a simulated lap into odomd.
# Every tick is published or counted as missed, no frame is lost, and the poses differ from the
# log's replay only by the effect of the stamps' jitter.

# The effect of jitter is known for a filter that holds each signal's newest value, like the
# paper's.
model=paper

# in_status NAME FILTER: the status before the daemon's end satisfies the filter, in which $n is $frames.
in_status() { check "$1" "$(cat status.json)" jq -e --argjson n "$frames" "$2" status.json; }

# play_drive NAME LOG BUS...: plays the log on these buses, which it must name.
play_drive() {
  local name=$1 log=$2 bus arguments=() recorder comparison
  shift 2
  odom replay --config drive/car.toml --model $model --can "$log" --out replay.csv >/dev/null

  add_vcan "$@"
  for bus; do arguments+=(--can "$bus"); done
  listen any received.log
  start_daemon drive/car.toml --model $model "${arguments[@]}"
  odom pose --shm /lab --wait 10 --follow --csv --clock realtime --until-stale >poses.csv 2>follow.log &
  recorder=$!
  shows "$name: real time is granted" '.realtime | .priority == 45 and .memory_locked'

  canplayer -I "$log"
  await 5 test "$(wc -l <received.log)" -ge "$frames"
  sleep 0.5
  status . >status.json
  stop_daemon "$name"
  wait $recorder
  reap $logger
  for bus; do ip link del "$bus"; done

  # candump and odomd received every frame that was sent; odomd sent none.
  check "$name: candump received every frame, and no other" "$(wc -l <received.log) of $frames" \
    test "$(wc -l <received.log)" = "$frames"
  in_status "$name: odomd received every frame, the kernel dropped none" \
    '([.can[].received] | add == $n) and ([.can[].lost] | add == 0)'
  in_status "$name: every frame is decoded" '.frames.decoded == $n and ([.frames[]] | add) == $n'
  check_ticks "$name"
  comparison=$(awk -v wakeup="$(jq .beat.wakeup_us.p999/1e6 status.json)" -v gyro=1A2 \
    -f "$ODOMD_SOURCE_DIR/tests/lab/compare_drive.awk" "$log" received.log replay.csv poses.csv) &&
    ok "$name: poses are those of the replay" || not_ok "$name: poses are those of the replay" "$comparison"
  echo "   $comparison"
}

# Rows begin with the first initialised pose and contain their tick. Only rows before the newest tick
# in the status are counted, because rows continue after the status was read, and a missed tick is
# counted only at the next published tick.
check_ticks() { # NAME
  local name=$1 published unpublished backwards missed
  read -r published unpublished backwards < <(awk -F, -v newest="$(jq .pose.tick status.json)" '
    NR == 1 {for (i = 1; i <= NF; i++) if ($i == "tick") tick = i}
    NR > 1 && $tick >= newest {exit}
    NR == 2 {first = $tick}
    NR > 2 && ($tick <= last || $1 <= t) {backwards++}
    NR > 1 {last = $tick; t = $1; n++}
    END {print n + 0, last - first + 1 - n, backwards + 0}' poses.csv)
  missed=$(jq .beat.missed status.json)
  echo "   $(jq -c '.beat | del(.period_s, .last_overrun_age_s, .last_overrun_execution_us)' status.json)"
  says "$name: no published tick was lost on the way to a client" ' 0 lost' cat follow.log
  check "$name: every tick is published or counted as missed" "$unpublished without a pose, $missed missed" \
    test "$unpublished" -le "$missed"
  check "$name: at least half of the ticks are published" "$published, and $unpublished not" \
    test $((published * 100)) -ge $(((published + unpublished) * 50))
  check "$name: times strictly increase" "$backwards of $published do not" test "$backwards" = 0
}

simulate --scenario lap --laps 1
play_drive "one bus" drive.log vcan0

# A car with its wheels on one bus, its steering on another and its gyro on a third.
simulate --scenario slalom --standstill 1 --duration 8
sed 's/ vcan0 \(1A2#\)/ vcan1 \1/; s/ vcan0 \(1A3#\)/ vcan2 \1/' drive.log >three.log
play_drive "three buses" three.log vcan0 vcan1 vcan2
