# CAN controllers: bit timing, state, error counters and restart-ms as configured, on two emulated
# SJA1000 on one wire; a link that goes down and up while the beat continues; and error states,
# which the emulation lacks, on a serial adapter (slcan) that the test emulates.

simulate --scenario lap --standstill 1 --duration 3 --ideal

# state_is STATE: whether the controller is in this state.
state_is() { status ".can[0].controller.state == \"$1\"" -e; }
shows_state() { shows "$1" ".can[0].controller.state == \"$2\"" 20; }

# The beat, as a client sees it, while the link goes down and up. The machine itself misses ticks, so
# each of five spans with a down and up is followed by an equally long span without a change. A link
# that blocks the beat does so every time, so that even the best of the five spans has a gap at least
# 25 ms larger than usual, or at least ten more missed ticks.
span() { # span NAME COMMAND: runs the command and waits 0.2 s
  local begin
  read -r begin _ </proc/uptime
  "${@:2}"
  sleep 0.2
  echo "$1 $begin $(cut -d' ' -f1 /proc/uptime)" >>spans
}
# holes: prints NAME MISSED LARGEST ROWS of each span, in ticks
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
start_daemon drive/hardware.toml --can can0 --can vcan0 --can can7
shows "the controller is reported as configured" '.can[0].controller | .bit_timing ==
  {bitrate: 500000, sample_point: 0.875, tq_ns: 125, prop_seg: 6, phase_seg1: 7, phase_seg2: 2, sjw: 1, brp: 1} and
  .clock_hz == 8000000 and .state == "error_active" and .tx_errors == 0 and .rx_errors == 0 and .restart_ms == 100 and
  .modes == ["bus_error_reporting"] and .bus_offs == 0 and .bus_errors == 0 and .restarts == 0' 20
says "as people read it" '^    controller error-active, bus_error_reporting, tx 0 rx 0, 500 kbit/s at 87\.5 %, restart-ms 100' \
  odom status --socket "$PWD/status.sock"

canplayer -I drive.log can1=vcan0
sleep 0.5
# The emulation transfers frames instantly: if the host stalls the machine, a burst overruns the
# receiver's 64 bytes. The kernel gives odomd exactly the frames that the controller received.
arrived=$(cat /sys/class/net/can0/statistics/rx_packets)
echo "   $arrived of $frames frames arrived, overruns: $(cat /sys/class/net/can0/statistics/rx_over_errors)"
check "frames sent by one controller arrive at the other" "$arrived of $frames" test "$arrived" -gt $((frames / 2))
shows "odomd receives and decodes them" \
  ".can[0].received == $arrived and .can[0].lost == 0 and .frames.decoded > $((frames / 2))" 20
shows "frames without a hardware stamp are counted, and timed by the kernel's" \
  ".can[0].hardware_fallbacks == $arrived and .stamps.trusted > 0"
shows "a pose comes of them" '.pose.x * .pose.x > 0'

odom pose --shm /lab --follow --csv --until-stale >poses.csv 2>follow.log &
follower=$!
ip link set can0 down
shows "the link goes down" '.can[0].link == "down"' 20
shows_state "the controller is stopped" stopped
logs "the journal says how to bring it up" 'can0: the bus is down; bring it up: ip link set can0 up'
# The other end sends continuously, and candump shows the first frame after the link came up. odomd
# receives every frame that candump does: no frame arrives before odomd's socket listens again.
listen any any.log
cangen can1 -g 2 -I 1A0 -L 8 &
sender=$!
before=$(status '.can[0].received')
ip link set can0 up
up=$(date +%s.%N)
await 20 grep -q ' can0 ' any.log
sleep 1
reap $sender
sleep 0.5
reap $logger
heard=$(grep -c ' can0 ' any.log)
again=$(awk -v up="$up" '$2 == "can0" {print substr($1, 2) - up; exit}' any.log)
echo "   first frame $again s after ip had set the link up, then $heard"
check "frames are heard again within a second" "$again s" awk -v s="${again:-9}" 'BEGIN {exit !(s < 1)}'
shows "and none of them is missed" ".can[0].received == $((before + heard))" 20
shows_state "the controller is reported as healthy again" error_active
logs "the journal says that the bus is up" 'can0: the bus is up again'

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
reap $sender

ip link set can0 down
ip link set can0 type can bitrate 250000 restart-ms 0
ip link set can0 up
shows "a changed configuration is reported" \
  '.can[0].controller | .state == "error_active" and .bit_timing.bitrate == 250000 and .restart_ms == 0' 20
shows "vcan has no controller, nor has what is not there" '[.can[1, 2].controller] == [null, null]'
stop_daemon "SJA1000"
wait $follower
echo "   spans (missed, largest hole, ticks): $(holes | tr '\n' ';')"
check "link down and up: the beat has no hole because of it" "$(holes | tr '\n' ';')" \
  test "$(of_spans switched 3 1)" -lt $(($(of_spans quiet 3 3) + 5))
check "link down and up: nor does it miss more ticks than at other times" "$(holes | tr '\n' ';')" \
  test "$(of_spans switched 2 1)" -lt $(($(of_spans quiet 2 3) + 10))
check "and nothing is said about it" "$(cat odomd.log)" \
  test "$(grep -cvE '^[0-9:.]+ odomd (info|warning): ' odomd.log)" = 0
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
start_daemon drive/car.toml --can "$serial" 5>&-
shows "what a driver does not know is null" '.can[0].controller | .state == "error_active" and .bit_timing ==
  {bitrate: 500000, sample_point: null, tq_ns: null, prop_seg: null, phase_seg1: null, phase_seg2: null, sjw: null, brp: null} and
  .clock_hz == null and .tx_errors == null and .restart_ms == 0' 20
say t1A080000000000000000
shows "a frame from the serial adapter" '.can[0].received == 1' 20
say sw000097
shows_state "error-warning" error_warning
say sp140000
shows_state "error-passive" error_passive
logs "error-passive is in the journal" "$serial: error-passive: .*check bit rate"
say sb255000
shows_state "bus-off" bus_off
shows "bus-off is counted, by error frame and by the driver" \
  '.can[0] | .bus_offs == 1 and .error_frames == 3 and .controller.bus_offs == 1 and .controller.error_passives == 1' 20
logs "the journal reports bus-off, and how to fix it" "$serial: bus-off: .*ip link set $serial type can restart-ms 100"
ip link set "$serial" down
ip link set "$serial" up
shows_state "down and up restart it" error_active
logs "the journal says so" "$serial: the controller was restarted after bus-off and is error-active"
say t1A080000000000000000
shows "and frames are heard again" '.can[0].received == 2' 20
exec 5>&-
wait $adapter
shows "the adapter is pulled, and has no state" '.can[0] | .link == "gone" and .controller == null' 20
stop_daemon "after bus-off"
