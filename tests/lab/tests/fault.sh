# odom fault between two buses and between a camera and the daemon, live: the selected frames fail as
# they do in a log, all others pass unchanged, and the daemon reports the fault.

# start_fault ARGUMENT...: odom fault, ready on vcan0.
start_fault() {
  odom fault --config drive/car.toml --from vcan0 --to vcan1 --kind gyro.zero "$@" 2>fault.txt &
  fault=$!
  await 20 grep -q 'handing on' fault.txt || not_ok "start" "$(cat fault.txt)"
}
stop_fault() {
  kill -INT $fault
  wait $fault && ok "odom fault ends cleanly" || not_ok "odom fault ends cleanly" "$(tail -n 3 fault.txt)"
}

simulate --scenario slalom --standstill 1 --duration 8
odom fault --config drive/car.toml --kind gyro.zero drive.log -o faulty.log 2>/dev/null
add_vcan vcan0 vcan1

# Other frames pass too: an extended identifier, a remote frame, CAN FD.
others='18DAF110#0210 321#R 123##1000102030405060708090A0B'
listen vcan1 received.log
start_fault
canplayer -I drive.log
for other in $others; do cansend vcan0 "$other"; done
await 10 test "$(wc -l <received.log)" -ge $((frames + 3))
sleep 0.2
stop_fault
reap $logger
# The receiver adds flags to CAN FD, and a length to the remote frame.
payloads() { cut -d' ' -f3 "$1" | sed 's/##./##1/; s/#R.*/#R/'; }
check "every frame is handed on, as it fails in a log, in order" "$(wc -l <received.log), $(tail -n 3 received.log)" \
  cmp <(payloads faulty.log; printf '%s\n' $others) <(payloads received.log)
check "the gyro's frames did change" "none differs" \
  test "$(cmp -s <(payloads drive.log) <(payloads faulty.log); echo $?)" = 1
echo "   $(tail -n 2 fault.txt | tr '\n' ' ')"

# A daemon on vcan1, whose camera is routed through the fault, too.
start_daemon drive/car.toml --can vcan1
start_fault --camera-from "$PWD/fault.sock" --camera-to "$PWD/camera.sock" --fault camera.moved
canplayer -I drive.log &
player=$!
odom camera send --socket "$PWD/fault.sock" --from-now --log drive/camera.csv >camera.txt 2>&1 &
camera=$!
# Checks the log: on a slow machine a flag may come and go between two reads of the status.
logs "the daemon reports the gyro" 'yaw_rate.*\[W313\]'
wait $player $camera
shows "the daemon heard the camera" '.camera.messages > 20'
stop_fault
stop_daemon
says "the camera's poses failed on the way" 'camera.moved: [0-9]{2,} camera poses' cat fault.txt

says "a missing interface is named" '^odom fault: vcan7: no such CAN interface' \
  odom fault --config drive/car.toml --kind gyro.zero --from vcan7 --to vcan1
