# CAN controllers: bit timing, state, error counters and restart-ms as configured, on two emulated
# SJA1000 on one wire; a link that goes down and up while the beat continues; and error states,
# which the emulation lacks, on a serial adapter (slcan) that the test emulates.
. "$(dirname "$0")/../guest.sh"

odom sim --scenario lap --standstill 1 --duration 3 --ideal --out drive >/dev/null 2>&1
bus=$(awk '{print $2; exit}' drive/drive.log)
frames=$(wc -l <drive/drive.log)

state_is() { status ".can[0].controller.state == \"$1\"" -e; }
link_is() { status ".can[0].link == \"$1\"" -e; }
journal_has() { grep -q -- "$1" odomd.log; }

# Every tick of the beat, as a client sees it, while the link goes down and up. The machine itself
# misses ticks, so each of five spans with a down and up is followed by an equally long span without
# a change. A link that blocks the beat does so every time: then even the best of the five spans has
# a gap at least 25 ms larger than usual, or at least ten more missed ticks.
uptime_s() { cut -d' ' -f1 /proc/uptime; }
follow() {
  odom pose --shm /lab --follow --csv --until-stale --out poses.csv 2>follow.log &
  follower=$!
}
span() { # span NAME COMMAND: runs the command and waits 0.2 s
  local name=$1 begin
  shift
  begin=$(uptime_s)
  "$@"
  sleep 0.2
  echo "$name $begin $(uptime_s)" >>spans
}
# holes: prints NAME MISSED LARGEST of each span, in ticks
holes() {
  awk '
    NR == FNR {name[NR] = $1; begin[NR] = $2; end[NR] = $3; n = NR; next}
    FNR == 1 {for (i = 1; i <= NF; i++) if ($i == "tick") column = i; next}
    {
      hole = $column - last - 1
      if (last) for (s = 1; s <= n; s++) if ($1 >= begin[s] && before <= end[s]) {
        missed[s] += hole; rows[s]++
        if (hole > largest[s]) largest[s] = hole
      }
      last = $column; before = $1
    }
    END {for (s = 1; s <= n; s++) print name[s], missed[s] + 0, largest[s] + 0, rows[s] + 0}
  ' FS=' ' spans FS=, poses.csv
}
of_spans() { # of_spans NAME COLUMN RANK: this rank of the five values
  holes | awk -v name="$1" -v column="$2" '$1 == name {print $column}' | sort -n | sed -n "$3p"
}
check_beat() { # after the daemon's end; status.json was read shortly before
  wait "$follower"
  local published unpublished newest
  newest=$(jq .pose.tick status.json)
  read -r published unpublished < <(awk -F, -v newest="$newest" '
    NR == 1 {for (i = 1; i <= NF; i++) if ($i == "tick") column = i; next}
    $column >= newest {exit}
    {if (!n++) first = $column; last = $column}
    END {print n + 0, last - first + 1 - n}' poses.csv)
  echo "   spans (missed, largest hole, ticks): $(holes | tr '\n' ';')"
  check "link down and up: every tick is published, or counted as missed" \
    "$published published, $unpublished not, $(jq .beat.missed status.json) missed, $(tail -n 1 follow.log)" \
    test "$published" -gt 500 -a "$unpublished" -le "$(jq .beat.missed status.json)"
  check "link down and up: the beat has no hole because of it" "$(holes | tr '\n' ';')" \
    test "$(of_spans switched 3 1)" -lt $(($(of_spans quiet 3 3) + 5))
  check "link down and up: nor does it miss more ticks than at other times" "$(holes | tr '\n' ';')" \
    test "$(of_spans switched 2 1)" -lt $(($(of_spans quiet 2 3) + 10))
}

# Two controllers on one wire -----------------------------------------------------------------------

ip link set can0 type can bitrate 500000 restart-ms 100 berr-reporting on
ip link set can1 type can bitrate 500000 restart-ms 100
ip link set can1 txqueuelen 1000  # canplayer does not wait for the queue
ip link set can0 up
ip link set can1 up
# Includes a bus without a controller and one that does not exist. Requests hardware stamps, which
# the driver lacks.
add_vcan vcan0
awk '/^timestamps/ {next} {print} /^\[can\]/ {print "timestamps = \"hardware\""}' drive/car.toml >drive/hardware.toml
start_daemon drive/hardware.toml --can can0 --can vcan0 --can can7 || not_ok "start" "$(cat odomd.log)"
await 20 state_is error_active
status '.can[0].controller' -c >controller.json
echo "   $(cat controller.json)"
check "bit timing is reported as configured" "$(cat controller.json)" jq -e '.bit_timing ==
  {bitrate: 500000, sample_point: 0.875, tq_ns: 125, prop_seg: 6, phase_seg1: 7, phase_seg2: 2, sjw: 1, brp: 1} and
  .clock_hz == 8000000' controller.json
check "state, error counters and restart-ms are reported" "$(cat controller.json)" jq -e '
  .state == "error_active" and .tx_errors == 0 and .rx_errors == 0 and .restart_ms == 100 and
  .modes == ["bus_error_reporting"] and .bus_offs == 0 and .bus_errors == 0 and .restarts == 0' controller.json
check "as people read it" "$(odom status --socket "$PWD/status.sock")" \
  grep -qE '^can0 +error-active, bus_error_reporting +0 +0 +500000 +0\.875 +100 ms ' <(odom status --socket "$PWD/status.sock")

canplayer -I drive/drive.log can1="$bus"
sleep 0.5
# The emulation transfers frames instantly: if the host stalls the machine, a burst overruns the
# receiver's 64 bytes. The kernel gives odomd exactly the frames that the controller received.
arrived=$(cat /sys/class/net/can0/statistics/rx_packets)
await 20 status ".can[0].received == $arrived" -e
echo "   $arrived of $frames frames arrived, overruns: $(cat /sys/class/net/can0/statistics/rx_over_errors)"
check "frames sent by one controller arrive at the other" "$arrived of $frames" test "$arrived" -gt $((frames / 2))
check "odomd receives and decodes them" "$(status '[.can[0], .frames]' -c) of $arrived" \
  status ".can[0].received == $arrived and .can[0].lost == 0 and .frames.decoded > $((frames / 2))" -e
check "frames without a hardware stamp are counted, and timed by the kernel's" "$(status '.can[0]' -c) $(status .stamps -c)" \
  status ".can[0].hardware_fallbacks == $arrived and .stamps.trusted > 0" -e
check "a pose comes of them" "$(status .pose -c)" status '.pose.x * .pose.x > 0' -e
echo "   pose $(status .pose -c)"

follow
ip link set can0 down
check "the link goes down" "$(status '.can[0]' -c)" await 20 link_is down
check "the controller is stopped" "$(status '.can[0]' -c)" await 20 state_is stopped
check "the journal says how to bring it up" "$(cat odomd.log)" await 20 journal_has 'can0: the bus is down; bring it up: ip link set can0 up'
# The other end sends continuously, and candump shows the first frame after the link came up. odomd
# receives every frame that candump does: none arrives before its socket listens again.
candump -L any,1A0:7FF >any.log &
logger=$!
await 20 grep -q any /proc/net/can/rcvlist_*
cangen can1 -g 2 -I 1A0 -L 8 &
sender=$!
before=$(status '.can[0].received')
ip link set can0 up
up=$(date +%s.%N)
await 20 grep -q ' can0 ' any.log
sleep 1
kill $sender
wait $sender 2>/dev/null
sleep 0.5
kill $logger
wait $logger 2>/dev/null
grep ' can0 ' any.log >heard.log
heard=$(sed -n '1s/(\([0-9.]*\)).*/\1/p' heard.log)
again=$(awk -v up="$up" -v heard="${heard:-1e12}" 'BEGIN {print heard - up}')
await 20 status ".can[0].received == $((before + $(wc -l <heard.log)))" -e
received=$(($(status '.can[0].received') - before))
echo "   first frame $again s after ip had set the link up, then $received"
check "frames are heard again within a second" "$again s" awk -v s="$again" 'BEGIN {exit !(s < 1)}'
check "and none of them is missed" "$received of $(wc -l <heard.log)" test "$received" = "$(wc -l <heard.log)"
check "the controller is reported as healthy again" "$(status '.can[0]' -c)" await 20 state_is error_active
check "the journal says that the bus is up" "$(cat odomd.log)" await 20 journal_has 'can0: the bus is up again'

down_and_up() {
  ip link set can0 down
  sleep 0.2
  ip link set can0 up
}
cangen can1 -g 5 -i -I 1A0 -L 8 &
sender=$!
for ((i = 1; i <= 5; ++i)); do
  await 20 state_is error_active
  span switched down_and_up
  await 20 state_is error_active
  span quiet sleep "$(tail -n 1 spans | awk '{print $3 - $2 - 0.2}')"
done
kill $sender
wait $sender 2>/dev/null

ip link set can0 down
ip link set can0 type can bitrate 250000 restart-ms 0
ip link set can0 up
check "a changed configuration is reported" "$(status '.can[0]' -c)" \
  await 20 status '.can[0].controller | .state == "error_active" and .bit_timing.bitrate == 250000 and .restart_ms == 0' -e
check "vcan has no controller, nor has what is not there" "$(status .can -c)" \
  status '[.can[1, 2].controller] == [null, null]' -e
status . >status.json
stop_daemon
check_beat
check "and nothing is said about it" "$(cat odomd.log)" \
  test "$(grep -cvE '^[0-9:.]+ odomd (info|warning): ' odomd.log)" = 0
check "ends cleanly" "status $daemon_status: $(tail -n 3 odomd.log)" test $daemon_status = 0
check "nothing was sent by the daemon" "$(link_packets can0) packets" test "$(link_packets can0)" = 0
ip link set can0 down
ip link set can1 down

# Error states -------------------------------------------------------------------------------------

mkfifo says
lab_slcan_adapter <says >name &
adapter=$!
exec 5>says
await 20 test -s name
serial=$(cat name)
say() { echo "$1" >&5; }
ip link set "$serial" type can bitrate 500000
ip link set "$serial" up
start_daemon drive/car.toml --can "$serial" 5>&- || not_ok "start on slcan" "$(cat odomd.log)"
await 20 state_is error_active
check "what a driver does not know is null" "$(status '.can[0]' -c)" status '.can[0].controller |
  .bit_timing == {bitrate: 500000, sample_point: null, tq_ns: null, prop_seg: null, phase_seg1: null, phase_seg2: null, sjw: null, brp: null} and
  .clock_hz == null and .tx_errors == null and .restart_ms == 0' -e
say t1A080000000000000000
check "a frame from the serial adapter" "$(status '.can[0]' -c)" await 20 status '.can[0].received == 1' -e
say sw000097
check "error-warning" "$(status '.can[0]' -c)" await 20 state_is error_warning
say sp140000
check "error-passive" "$(status '.can[0]' -c)" await 20 state_is error_passive
check "error-passive is in the journal" "$(cat odomd.log)" await 20 journal_has "$serial: error-passive: .*check bit rate"
say sb255000
check "bus-off" "$(status '.can[0]' -c)" await 20 state_is bus_off
check "bus-off is counted, by error frame and by the driver" "$(status '.can[0]' -c)" \
  await 20 status '.can[0] | .bus_offs == 1 and .error_frames == 3 and .controller.bus_offs == 1 and .controller.error_passives == 1' -e
check "the journal reports bus-off, and how to fix it" "$(cat odomd.log)" \
  await 20 journal_has "$serial: bus-off: .*ip link set $serial type can restart-ms 100"
ip link set "$serial" down
ip link set "$serial" up
check "down and up restart it" "$(status '.can[0]' -c)" await 20 state_is error_active
check "the journal says so" "$(cat odomd.log)" await 20 journal_has "$serial: the controller was restarted after bus-off and is error-active"
say t1A080000000000000000
check "and frames are heard again" "$(status '.can[0]' -c)" await 20 status '.can[0].received == 2' -e
exec 5>&-
wait $adapter
check "the adapter is pulled" "$(status '.can[0]' -c)" await 20 link_is gone
check "a controller that is gone has no state" "$(status '.can[0]' -c)" await 20 status '.can[0].controller == null' -e
stop_daemon
check "ends cleanly after bus-off" "status $daemon_status: $(tail -n 3 odomd.log)" test $daemon_status = 0
sed -n 's/^/   /; /warning\|again\|restarted/p' odomd.log | grep -v "never received\|ticks missed\|overrun"
remove_link vcan0
