# The real-time rules of the beat on real buses with a real-time kernel: 8,000 frames/s of mapped
# identifiers are received without loss; all its system calls are those of the design; and a reader
# that preempts the writer of a segment on its own CPU does not wait for it.
. "$(dirname "$0")/../guest.sh"

odom sim --scenario lap --duration 6 --out car >/dev/null
add_vcan vcan0 vcan1
# Each of the car's 500 frames/s is sent sixteen times, on two buses.
awk '{bus = $3 ~ /^1A[01]/ ? "vcan0" : "vcan1"; for (i = 0; i < 16; i++) print $1, bus, $3}' \
  car/drive.log >full.log
frames=$(wc -l <full.log)
start_daemon car/car.toml --can vcan0 --can vcan1 || not_ok "start" "$(cat odomd.log)"
check "real time is granted" "$(status .realtime -c)" status '.realtime | .priority == 45 and .memory_locked' -e

# play: the log with its camera, and two waiting clients; prints the duration.
play() {
  local begin=$SECONDS camera
  odom camera send --log car/camera.csv --from-now --socket "$PWD/camera.sock" >/dev/null 2>&1 &
  camera=$!
  canplayer -I full.log
  took=$((SECONDS - begin))
  kill $camera 2>/dev/null
  wait $camera
}
odom pose --shm /lab --follow --csv --until-stale --out /dev/null 2>/dev/null &
odom pose --shm /lab --follow --csv --until-stale --out /dev/null 2>/dev/null &
play
await 20 status "[.can[].received] | add == $frames" -e
echo "   $frames frames in $took s: $(status '.can[] | {name, received, lost, carried_over}' -c | tr '\n' ' ')"
check "8,000 frames/s: all received" "$(status .can -c) of $frames" \
  status "[.can[].received] | add == $frames" -e
check "8,000 frames/s: none lost" "$(status .can -c)" status '[.can[].lost] | add == 0' -e

# Traces every system call of the beat's thread while the log is played again.
daemon_pid=$(status .pid)
for task in "/proc/$daemon_pid/task/"*; do
  [ "$(cat "$task/comm")" != odomd-beat ] || beat=${task##*/}
done
strace -qq -s 1 -o beat.trace -p "$beat" &
tracer=$!
await 20 test -s beat.trace
play
await 60 test "$(grep -c clock_nanosleep beat.trace)" -ge 300
kill $tracer
wait $tracer
case $(cat /sys/devices/system/clocksource/clocksource0/current_clocksource) in
  tsc | kvm-clock) clock_is_a_call=0 ;;
  *) clock_is_a_call=1 ;;
esac
census=$(awk -v buses=2 -v cameras=2 -v clock_is_a_call=$clock_is_a_call \
  -f "$ODOMD_SOURCE_DIR/tests/daemon/discipline/census.awk" beat.trace)
clean=$?
echo "   $census"
check "the beat's system calls are those of the design" "$census" test $clean = 0
check "they were seen under traffic" "$census" grep -q 'recvmmsg' <<<"$census"
stop_daemon
check "ends cleanly" "status $daemon_status: $(tail -n 3 odomd.log)" test $daemon_status = 0
remove_link vcan0
remove_link vcan1

# Without the kernel's throttling, a writer that a real-time reader waits for would never run.
throttling=$(cat /proc/sys/kernel/sched_rt_runtime_us)
echo -1 >/proc/sys/kernel/sched_rt_runtime_us
preemption=$(timeout 60 "$ODOMD_BIN_DIR/shm_preemption" 2000 2>&1)
clean=$?
echo "$throttling" >/proc/sys/kernel/sched_rt_runtime_us
echo "   $preemption"
check "a reader that preempts the writer on its CPU does not wait for it" "$preemption" test $clean = 0
