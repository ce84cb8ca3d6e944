# The service and its device: if the interface disappears and comes back, the service keeps running.

begin
pid=$(main_pid)
restarts=$(systemctl show -P NRestarts $unit)
device=sys-subsystem-net-devices-$bus.device
check "systemd knows the interface" "$(systemctl show -p ActiveState $device)" await 20 is_active $device
check "the service wants it, and comes after it" "$(systemctl show -p Wants,After $unit)" \
  test "$(systemctl show -P Wants -P After $unit | grep -cwF "$device")" = 2

reap $driver
ip link del $bus
check "the interface vanishes" "$(systemctl show -p ActiveState $device)" await 20 eval "! is_active $device"
shows "the daemon says so, and the pose" '.can[0].link == "gone" and (.conditions | contains(["bus_down"]))' 20
ticks=$(status .beat.ticks)
shows "the service goes on without it" ".beat.ticks > $ticks + 200 and .pid == $pid" 20
does "and is active" is_active

add_vcan $bus
shows "the interface is back" '.can[0].link == "up" and (.conditions | contains(["bus_down"]) | not)' 20
received=$(status '.can[0].received')
drive $bus
shows "the same process reads it again" ".can[0].received > $received and .pid == $pid" 30
says "it was never restarted" "^$restarts\$" systemctl show -P NRestarts $unit
