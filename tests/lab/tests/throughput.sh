# A full bus: 8,000 frames a second for ten seconds on vcan, counted at both ends. None is lost, and
# all are decoded.
. "$(dirname "$0")/../guest.sh"

rate=8000
# A drive of four protected messages, repeated four times with compressed stamps. The counters wrap
# at 14 or 15: after a multiple of 240 frames of each message they continue where they began.
odom sim --scenario lap --duration 45 --standstill 3 --out drive >/dev/null 2>&1
awk '{id = substr($3, 1, 3)} n[id]++ < (id == "1A2" ? 8160 : 4080) {print $3}' drive/drive.log >once
cat once once once once | awk -v rate=$rate '{printf "(%.6f) vcan0 %s\n", 1e9 + NR / rate, $1}' >full.log
frames=$(wc -l <full.log)
check "the log holds ten seconds of traffic" "$frames frames" test "$frames" = 81600

add_vcan vcan0
# A buffer for seconds of traffic, not for tenths: a busy host may stall one of the machine's
# processors.
awk '/^receive_buffer/ {next} {print} /^\[can\]/ {print "receive_buffer = 8388608"}' drive/car.toml >drive/roomy.toml
start_daemon drive/roomy.toml --can vcan0 || not_ok "start" "$(cat odomd.log)"
begin=$(date +%s%N)
canplayer -I full.log
took=$((($(date +%s%N) - begin) / 1000000))
await 20 status ".can[0].received + .can[0].lost == $frames" -e
sent=$(link_packets vcan0)
status . >status.json
echo "   $sent frames in $took ms: $((sent * 1000 / took)) a second; $(jq -c '.can[0], .beat.ticks, .beat.missed' status.json | tr '\n' ' ')"
check "every frame was sent" "$sent of $frames" test "$sent" = "$frames"
# A busy host makes the machine slow: then the rate is lower, but the count is the same.
check "it was the rate that was meant, or a quarter of it on a busy host" "$took ms" test $took -lt 40800
check "every frame was received, none lost" "$(jq -c '.can[0]' status.json) of $frames" \
  jq -e --argjson n "$frames" '.can[0] | .received == $n and .lost == 0' status.json
check "every frame is decoded" "$(jq -c .frames status.json)" \
  jq -e --argjson n "$frames" '.frames.decoded == $n and ([.frames[]] | add) == $n' status.json
stop_daemon
check "ends cleanly" "status $daemon_status: $(tail -n 3 odomd.log)" test $daemon_status = 0
remove_link vcan0
