# A full bus: 8,000 frames a second for ten seconds on vcan, counted at both ends. None is lost, and
# all are decoded.

rate=8000
# A drive of four protected messages, repeated four times with compressed stamps. The counters wrap
# at 14 or 15: after a multiple of 240 frames of each message they continue where they began.
simulate --scenario lap --duration 45 --standstill 3
awk '{id = substr($3, 1, 3)} n[id]++ < (id == "1A2" ? 8160 : 4080) {print $3}' drive.log >once
cat once once once once | awk -v rate=$rate '{printf "(%.6f) vcan0 %s\n", 1e9 + NR / rate, $1}' >full.log
frames=$(wc -l <full.log)
check "the log holds ten seconds of traffic" "$frames frames" test "$frames" = 81600

add_vcan vcan0
# A buffer for seconds of traffic, not for tenths: a busy host may stall one of the machine's
# processors.
awk '/^receive_buffer/ {next} {print} /^\[can\]/ {print "receive_buffer = 8388608"}' drive/car.toml >drive/roomy.toml
start_daemon drive/roomy.toml --can vcan0
begin=$(date +%s%N)
canplayer -I full.log
took=$((($(date +%s%N) - begin) / 1000000))
await 20 status ".can[0].received + .can[0].lost == $frames" -e
sent=$(link_packets vcan0)
echo "   $sent frames in $took ms: $((sent * 1000 / took)) a second; $(status '[.can[0], .beat.ticks, .beat.missed]' -c)"
check "every frame was sent" "$sent of $frames" test "$sent" = "$frames"
# A busy host makes the machine slow: then the rate is lower, but the count is the same.
check "it was the rate that was meant, or a quarter of it on a busy host" "$took ms" test $took -lt 40800
shows "every frame was received, none lost" ".can[0] | .received == $frames and .lost == 0"
shows "every frame is decoded" ".frames.decoded == $frames and ([.frames[]] | add) == $frames"
stop_daemon
