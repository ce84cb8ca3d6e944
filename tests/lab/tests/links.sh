# A bus that goes down, comes up, disappears and comes back: the daemon reports it, survives it and
# listens again. It never transmits.

simulate --scenario lap --standstill 1 --duration 1 --ideal
add_vcan vcan0
start_daemon drive/car.toml --can vcan0

listen vcan0 heard.log
sleep 3
check "alone with the daemon, the bus is silent" "$(head -n 3 heard.log), $(link_packets vcan0) packets" \
  test ! -s heard.log -a "$(link_packets vcan0)" = 0
reap $logger

# hears NAME: plays the frames; all must be received.
hears() {
  local before
  before=$(status '.can[0].received')
  canplayer -I drive.log
  shows "$1" ".can[0].received == $((before + frames))" 5
}

hears "hears the bus"
ip link set vcan0 down
shows "sees the link go down" '.can[0].link == "down"' 5
shows "the pose says that the bus is down" '.conditions | contains(["bus_down"])' 5
ip link set vcan0 up
shows "sees the link come up" '.can[0].link == "up"' 5
hears "hears the bus after down and up"
index=$(cat /sys/class/net/vcan0/ifindex)
ip link del vcan0
shows "sees the interface vanish" '.can[0].link == "gone"' 5
# Another interface is created first, so that this one gets a new index.
add_vcan vcan9 vcan0
check "the index is another one" "$index" test "$(cat /sys/class/net/vcan0/ifindex)" -gt "$index"
shows "sees it come back" '.can[0].link == "up"' 5
hears "hears the bus after it came back"
shows "the pose says that the bus is back" '.conditions | contains(["bus_down"]) | not' 5
shows "counts how often the link was lost" '.can[0].link_downs >= 2'
check "nothing but what was played is on the bus" "$(link_packets vcan0) of $frames" \
  test "$(link_packets vcan0)" = "$frames"
stop_daemon
