# Plays a log on buses into odomd and compares the output with the log's replay. Tests source this
# together with guest.sh.

# The effect of jitter is known for a filter that holds each signal's newest value, like the
# paper's.
model=paper

# play_drive NAME LOG CONFIG BUS...: plays the log on the buses that it names.
play_drive() {
  local name=$1 log=$2 config=$3
  shift 3
  local frames bus arguments=() logger recorder
  frames=$(wc -l <"$log")
  odom replay --config "$config" --model $model --can "$log" --out replay.csv >/dev/null

  add_vcan "$@"
  for bus; do arguments+=(--can "$bus"); done
  candump -L any >received.log &
  logger=$!
  await 5 grep -q any /proc/net/can/rcvlist_all
  start_daemon "$config" --model $model "${arguments[@]}" || not_ok "$name: start" "$(cat odomd.log)"
  odom pose --shm /lab --wait 10 --follow --csv --clock realtime --until-stale --out poses.csv 2>follow.log &
  recorder=$!
  check "$name: real time is granted" "$(status .realtime -c)" \
    status '.realtime | .priority == 45 and .memory_locked' -e

  canplayer -I "$log"
  await 5 test "$(wc -l <received.log)" -ge "$frames"
  sleep 0.5
  status . >status.json
  stop_daemon
  check "$name: ends cleanly" "status $daemon_status: $(tail -n 3 odomd.log)" test $daemon_status = 0
  wait $recorder
  kill $logger
  wait $logger 2>/dev/null
  for bus; do remove_link "$bus"; done

  check_counts "$name" "$frames"
  check_ticks "$name"
  local comparison matched
  comparison=$(awk -v wakeup="$(jq .beat.wakeup_us.p999/1e6 status.json)" -v gyro=1A2 \
    -f "$ODOMD_SOURCE_DIR/tests/lab/compare_drive.awk" "$log" received.log replay.csv poses.csv)
  matched=$?
  echo "   $comparison"
  check "$name: poses are those of the replay" "$comparison" test $matched = 0
}

# Both ends received every frame that was sent; the daemon itself sent none.
check_counts() { # NAME FRAMES
  local name=$1 frames=$2
  echo "   $(jq -c '.can[] | {name, received, lost, carried_over}' status.json | tr '\n' ' ')"
  check "$name: candump received every frame, and no other" "$(wc -l <received.log) of $frames" \
    test "$(wc -l <received.log)" = "$frames"
  check "$name: odomd received every frame, none lost" "$(jq -c .can status.json) of $frames" \
    jq -e --argjson n "$frames" '[.can[].received] | add == $n' status.json
  check "$name: the kernel dropped nothing" "$(jq -c .can status.json)" jq -e '[.can[].lost] | add == 0' status.json
  check "$name: every frame is decoded" "$(jq -c .frames status.json) of $frames" \
    jq -e --argjson n "$frames" '.frames.decoded == $n and ([.frames[]] | add) == $n' status.json
}

# Rows begin with the first initialised pose and contain their tick. They continue after the status
# was read, and missed ticks are counted only at the next published tick: so rows count only up to
# the tick before the status' newest.
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
  echo "   $(tail -n 1 follow.log)"
  check "$name: no published tick was lost on the way to a client" "$(tail -n 1 follow.log)" \
    grep -q ' 0 lost' follow.log
  check "$name: every tick is published or counted as missed" "$unpublished without a pose, $missed missed" \
    test "$unpublished" -le "$missed"
  check "$name: at least half of the ticks are published" "$published, and $unpublished not" \
    test $((published * 100)) -ge $(((published + unpublished) * 50))
  check "$name: times strictly increase" "$backwards of $published do not" test "$backwards" = 0
}
