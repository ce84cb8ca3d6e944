# The service and its device: the interface may disappear and come back, the service keeps running.
. "$(dirname "$0")/../guest.sh"
. "$(dirname "$0")/../service.sh"

begin
pid=$(main_pid)
restarts=$(systemctl show -P NRestarts $unit)
device=sys-subsystem-net-devices-$bus.device
check "systemd knows the interface" "$(systemctl show -p ActiveState $device)" await 20 is_active $device
check "the service wants it, and comes after it" "$(systemctl show -p Wants,After $unit)" \
  test "$(systemctl show -P Wants -P After $unit | grep -cwF "$device")" = 2

kill "$driver"
wait "$driver" 2>/dev/null
remove_link $bus
check "the interface vanishes" "$(systemctl show -p ActiveState $device)" await 20 eval "! is_active $device"
check "the daemon says so" "$(status .can -c)" await 20 status '.can[0].link == "gone"' -e
ticks=$(status .beat.ticks)
check "the service goes on without it" "$(journal)" await 20 status ".beat.ticks > $ticks + 200 and .pid == $pid" -e
check "and is active" "$(systemctl show -p ActiveState,SubState,Result $unit)" is_active

add_vcan $bus
check "the interface is back" "$(status .can -c)" await 20 status '.can[0].link == "up"' -e
received=$(status '.can[0].received')
drive $bus
check "the same process reads it again" "$(status '[.pid, .can]' -c)" \
  await 30 status ".can[0].received > $received and .pid == $pid" -e
check "it was never restarted" "$(systemctl show -p NRestarts $unit)" \
  test "$(systemctl show -P NRestarts $unit)" = "$restarts"
end
