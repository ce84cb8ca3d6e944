# odom fault between two buses and between a camera and the daemon, live: the selected frames fail as
# they do in a log, all others pass unchanged, and the daemon reports the fault.
. "$(dirname "$0")/../guest.sh"

payloads() { cut -d' ' -f3 "$1"; }

# start_fault ARGUMENT...: odom fault, ready on vcan0.
start_fault() {
  odom fault --config drive/car.toml --from vcan0 --to vcan1 "$@" 2>fault.txt &
  fault=$!
  await 20 grep -q 'handing on' fault.txt
}
stop_fault() {
  kill -INT $fault
  wait $fault
  fault_status=$?
}

odom sim --scenario slalom --standstill 1 --duration 8 --out drive >/dev/null
sed 's/ can[0-9]* / vcan0 /' drive/drive.log >drive.log
frames=$(wc -l <drive.log)
odom fault --config drive/car.toml --kind gyro.zero drive.log -o faulty.log 2>/dev/null
add_vcan vcan0 vcan1

# Other frames pass too: extended identifiers, remote frames, CAN FD.
candump -L vcan1 >received.log &
logger=$!
await 5 grep -q vcan1 /proc/net/can/rcvlist_all
start_fault --kind gyro.zero || not_ok "start" "$(cat fault.txt)"
canplayer -I drive.log
for other in 18DAF110#0210 321#R 123##1000102030405060708090A0B; do cansend vcan0 "$other"; done
await 10 test "$(wc -l <received.log)" -ge $((frames + 3))
sleep 0.2
stop_fault
kill $logger; wait $logger 2>/dev/null
check "ends cleanly" "status $fault_status: $(tail -n 3 fault.txt)" test $fault_status = 0
check "every frame is handed on" "$(wc -l <received.log) of $((frames + 3))" \
  test "$(wc -l <received.log)" = $((frames + 3))
check "frames fail as they do in a log, in their order" "they differ" \
  cmp -s <(payloads faulty.log) <(payloads received.log | head -n "$frames")
check "the gyro's frames did change" "none differs" \
  test "$(cmp -s <(payloads drive.log) <(payloads faulty.log); echo $?)" = 1
check "an extended identifier passes" "$(tail -n 3 received.log)" grep -q ' 18DAF110#0210$' received.log
check "a remote frame passes" "$(tail -n 3 received.log)" grep -q ' 321#R' received.log
check "a CAN FD frame passes" "$(tail -n 3 received.log)" \
  grep -qE ' 123##[0-9A-F]000102030405060708090A0B$' received.log
echo "   $(tail -n 2 fault.txt | tr '\n' ' ')"

# A daemon on vcan1, its camera routed through the fault, too.
start_daemon drive/car.toml --can vcan1 || not_ok "start" "$(cat odomd.log)"
start_fault --kind gyro.zero --camera-from "$PWD/fault.sock" --camera-to "$PWD/camera.sock" \
  --fault camera.moved || not_ok "start" "$(cat fault.txt)"
canplayer -I drive.log &
player=$!
odom camera send --socket "$PWD/fault.sock" --from-now --log drive/camera.csv >camera.txt 2>&1 &
camera=$!
# Checks the log: on a slow machine a flag may come and go between two reads of the status.
check "the daemon reports the gyro" "$(cat odomd.log)" await 30 grep -q 'yaw_rate.*\[W313\]' odomd.log
wait $player
wait $camera
status . >status.json
check "the daemon heard the camera" "$(cat camera.txt)" \
  test "$(jq .camera.messages status.json)" -gt 20
stop_fault
stop_daemon
check "the camera's poses failed on the way" "$(cat fault.txt)" \
  grep -qE 'camera.moved: [0-9]{2,} camera poses' fault.txt

# The error names an interface that does not exist.
odom fault --config drive/car.toml --kind gyro.zero --from vcan7 --to vcan1 2>missing.txt
check "a missing interface is named" "$(cat missing.txt)" grep -q '^odom fault: vcan7: no such CAN interface' missing.txt
remove_link vcan0
remove_link vcan1
