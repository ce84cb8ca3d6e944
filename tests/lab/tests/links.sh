# A bus that goes down, comes up, disappears and comes back: the daemon reports it, survives it and
# listens again. It never transmits.
. "$(dirname "$0")/../guest.sh"

odom sim --scenario lap --standstill 1 --duration 1 --ideal --out stand >/dev/null 2>&1
bus=$(awk '{print $2; exit}' stand/drive.log)
frames=$(wc -l <stand/drive.log)
add_vcan vcan0
start_daemon stand/car.toml --can vcan0 || not_ok "start" "$(cat odomd.log)"

candump -L vcan0 >heard.log &
logger=$!
sleep 3
check "alone with the daemon, the bus is silent" "$(head -n 3 heard.log), $(link_packets vcan0) packets" \
  test ! -s heard.log -a "$(link_packets vcan0)" = 0
kill $logger
wait $logger 2>/dev/null

link_is() { status ".can[0].link == \"$1\"" -e; }
bus_down() { status ".conditions | contains([\"bus_down\"]) == $1" -e; }

# hears EXPECTED: plays the frames, and waits until all are received.
hears() {
  local before
  before=$(status '.can[0].received')
  canplayer -I stand/drive.log vcan0="$bus"
  await 5 status ".can[0].received == $((before + frames))" -e
}

check "hears the bus" "$(status .can -c)" hears
ip link set vcan0 down
check "sees the link go down" "$(status .can -c)" await 5 link_is down
check "the pose says that the bus is down" "$(status .conditions -c)" await 5 bus_down true
ip link set vcan0 up
check "sees the link come up" "$(status .can -c)" await 5 link_is up
check "hears the bus after down and up" "$(status .can -c)" hears
index=$(cat /sys/class/net/vcan0/ifindex)
ip link del vcan0
check "sees the interface vanish" "$(status .can -c)" await 5 link_is gone
# Another interface is created first, so that this one gets a new index.
add_vcan vcan9 vcan0
check "the index is another one" "$index" test "$(cat /sys/class/net/vcan0/ifindex)" -gt "$index"
check "sees it come back" "$(status .can -c)" await 5 link_is up
check "hears the bus after it came back" "$(status .can -c)" hears
check "the pose says that the bus is back" "$(status .conditions -c)" await 5 bus_down false
check "counts how often the link was lost" "$(status .can -c)" status '.can[0].link_downs >= 2' -e
check "nothing but what was played is on the bus" "$(link_packets vcan0) of $frames" \
  test "$(link_packets vcan0)" = "$frames"
stop_daemon
check "ends cleanly" "status $daemon_status: $(tail -n 3 odomd.log)" test $daemon_status = 0

remove_link vcan9
remove_link vcan0
