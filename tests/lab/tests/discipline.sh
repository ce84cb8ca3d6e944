# The real-time rules of the beat on real buses with a real-time kernel: 8,000 frames/s of mapped
# identifiers are received without loss, and all system calls of the beat are those of the design.

check "kernel is PREEMPT_RT" "$(uname -v)" grep -qx 1 /sys/kernel/realtime
simulate --scenario lap --duration 6
add_vcan vcan0 vcan1
# Each of the car's 500 frames/s is sent sixteen times, on two buses.
awk '{bus = $3 ~ /^1A[01]/ ? "vcan0" : "vcan1"; for (i = 0; i < 16; i++) print $1, bus, $3}' \
  drive.log >full.log
frames=$(wc -l <full.log)
start_daemon drive/car.toml --can vcan0 --can vcan1
shows "real time is granted" '.realtime | .priority == 45 and .memory_locked'

# play: the log with its camera, and two waiting clients; prints the duration.
play() {
  local begin=$SECONDS camera
  odom camera send --log drive/camera.csv --from-now --socket "$PWD/camera.sock" >/dev/null 2>&1 &
  camera=$!
  canplayer -I full.log
  took=$((SECONDS - begin))
  reap $camera
}
odom pose --shm /lab --follow --csv --until-stale >/dev/null 2>/dev/null &
odom pose --shm /lab --follow --csv --until-stale >/dev/null 2>/dev/null &
play
shows "8,000 frames/s: all received" "[.can[].received] | add == $frames" 20
shows "8,000 frames/s: none lost" '[.can[].lost] | add == 0'
echo "   $frames frames in $took s"

# Traces every system call of the beat's thread while the log is played again.
beat=$(grep -lx odomd-beat /proc/$daemon/task/*/comm | cut -d/ -f5)
strace -qq -s 1 -o beat.trace -p "$beat" &
tracer=$!
await 20 test -s beat.trace
play
traced() { test "$(grep -c clock_nanosleep beat.trace)" -ge 300; }
await 60 traced || not_ok "300 ticks are traced" "$(wc -l <beat.trace) lines"
reap $tracer
case $(cat /sys/devices/system/clocksource/clocksource0/current_clocksource) in
  tsc | kvm-clock) clock_is_a_call=0 ;;
  *) clock_is_a_call=1 ;;
esac
census_of() { # BUSES
  awk -v buses="$1" -v cameras=2 -v clock_is_a_call=$clock_is_a_call -f "$ODOMD_SOURCE_DIR/tests/lab/census.awk" beat.trace
}
census=$(census_of 2)
check "the beat's system calls are those of the design" "$census" test $? = 0
check "and not those of a beat with one bus: the check can fail" "$census" eval '! census_of 1'
check "they were seen under traffic" "$census" grep -q 'recvmmsg' <<<"$census"
check "and with a camera" "$census" grep -q 'recvmsg' <<<"$census"
echo "   $census"
stop_daemon
