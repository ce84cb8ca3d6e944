# A live recording on a real bus with a real-time kernel, with camera poses over the socket: its
# replay gives the published bits, twice.

# holds FOLDER TICKS: whether the disk has more than this many ticks.
holds() { test "$(cat "$1/beat.csv" 2>/dev/null | wc -l)" -gt "$2"; }

simulate --scenario slalom --standstill 1 --duration 12
add_vcan vcan0
start_daemon drive/car.toml --can vcan0

# For comparison: a client that reads every pose from the shared memory.
odom pose --shm /lab --follow --csv --until-stale >witness.csv 2>witness.txt &
witness=$!
odom record --socket "$PWD/record.sock" --out whole --once 2>whole.txt &
whole=$!
await 20 holds whole 1

canplayer -I drive.log &
player=$!
odom camera send --socket "$PWD/camera.sock" --from-now --log drive/camera.csv >camera.txt 2>&1 &
camera=$!
wait $player $camera
await 10 status ".can[0].received == $frames" -e
sleep 0.5
stop_daemon
wait $whole $witness
says "the recorder ends with it" 'odomd has ended' cat whole.txt
echo "   $(tail -n 1 whole.txt)"

check "the recorded frames are those that were played" "$(wc -l <whole/can.log) of $frames, or others" \
  cmp -s <(cut -d' ' -f3 drive.log) <(cut -d' ' -f3 whole/can.log)
check "camera poses are recorded" "$(wc -l <whole/camera.csv) rows" test "$(wc -l <whole/camera.csv)" -gt 100
check "camera poses are fused" "$(cut -d, -f11 whole/pose.csv | sort | uniq -c | tr '\n' ' ')" \
  grep -q ',tracking,' whole/pose.csv
check "several hundred ticks" "$(wc -l <whole/pose.csv) rows" test "$(wc -l <whole/pose.csv)" -gt 500
for nth in first second; do # every tick must be bit-identical
  says "bit-identical, the $nth time" '^bit-identical' odom replay --recording whole --verify --out replayed.csv
  check "the same pose file, the $nth time" "they differ" cmp -s replayed.csv whole/pose.csv
done

# The recorded poses equal those of the shared memory: compares all columns that a client read, tick
# by tick, except the time, which is on another clock.
check "the poses are those that a client read" "$(cat compared.txt 2>/dev/null)" awk -F, '
  FNR == 1 {file++; next}
  {tick = $12; sub(/^[^,]*,/, "")}
  file == 1 {published[tick] = $0}
  file == 2 && (tick in published) {n++; if (index($0 ",", published[tick] ",") != 1) {print "tick " tick " differs" >"compared.txt"; bad = 1}}
  END {exit bad || n < 500}' witness.csv whole/pose.csv

# A full disk is reported, and the data written until then is kept.
start_daemon drive/car.toml --can vcan0
canplayer -I drive.log &
player=$!
await 20 status '.can[0].received > 300' -e
mkdir disk
mount -t tmpfs -o size=1400k tmpfs disk
timeout 60 odom record --socket "$PWD/record.sock" --out disk/full 2>full.txt
echo "status $?" >>full.txt
says "a full disk ends the recording with status 1" '^kept; status 1$' \
  sed -n '/the disk is full; what was recorded until now is kept/{N;s/.*kept.*\n/kept; /p}' full.txt
says "what there was room for replays" '^bit-identical' odom replay --recording disk/full --verify
umount disk
reap $player
stop_daemon "the last daemon"
