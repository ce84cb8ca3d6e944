# The machine itself: it has a real-time kernel, and can-utils transfer a log over a virtual bus
# without loss. If this fails, no other result of the lab is meaningful.
. "$(dirname "$0")/../guest.sh"

check "kernel is PREEMPT_RT" "$(uname -v)" grep -qw PREEMPT_RT /proc/version
check "kernel says it is real time" "no /sys/kernel/realtime" grep -qx 1 /sys/kernel/realtime

add_vcan vcan0 vcan1
check "vcan0 is up" "$(ip link show vcan0)" grep -q 'UP' <(ip link show vcan0)

# cangen makes the traffic, candump logs it, canplayer plays the log on the other bus: 1,000 frames.
candump -L vcan0 >made.log &
logger=$!
await 5 grep -q vcan0 /proc/net/can/rcvlist_all
cangen vcan0 -g 1 -n 1000
await 5 test "$(link_packets vcan0)" = 1000
sleep 0.2
kill $logger; wait $logger 2>/dev/null
check "cangen to candump" "$(wc -l <made.log) of 1000 frames" test "$(wc -l <made.log)" = 1000

candump -L vcan1 >played.log &
logger=$!
await 5 grep -q vcan1 /proc/net/can/rcvlist_all
canplayer -I made.log vcan1=vcan0
sleep 0.2
kill $logger; wait $logger 2>/dev/null
frames() { cut -d' ' -f3 "$1"; }
check "canplayer to candump" "$(wc -l <played.log) of 1000 frames, or others" \
  cmp -s <(frames made.log) <(frames played.log)

# The same with CAN FD.
candump -L -n 1 vcan0 >fd.log &
logger=$!
await 5 grep -q vcan0 /proc/net/can/rcvlist_all
cansend vcan0 123##1000102030405060708090A0B0C0D0E0F
await 5 test -s fd.log
kill $logger 2>/dev/null; wait $logger 2>/dev/null
check "CAN FD frame of 16 bytes" "$(cat fd.log)" grep -qE '123##[0-9A-F]000102030405060708090A0B0C0D0E0F$' fd.log

remove_link vcan0
remove_link vcan1
