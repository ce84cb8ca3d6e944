# A real controller (an emulated SJA1000) under systemd-networkd: the installed example brings can0 up,
# and odomd@can0 reads what a car sends from the other end of the wire.
. "$(dirname "$0")/../guest.sh"
. "$(dirname "$0")/../service.sh"
bus=can0
unit=odomd@$bus.service
run=/run/odomd/$bus

install_product || { not_ok "installs" "see above"; exit; }
check "there is a controller" "$(ip link)" ip link show can0
check "it is down, and has no bit rate" "$(ip -d link show can0)" \
  test -z "$(ip -j -d link show can0 | jq -r '.[0].linkinfo.info_data.bittiming.bitrate // empty')"

mkdir -p /etc/systemd/network
cp /usr/local/lib/systemd/network/80-can0.network.example /etc/systemd/network/80-can0.network
systemctl start systemd-networkd
can0_is() { ip -j -d link show can0 | jq -e ".[0] | $1"; }
check "networkd brings it up" "$(ip -d link show can0)" await 30 can0_is '.flags | index("UP")'
check "with the bit rate of the file" "$(ip -d link show can0)" can0_is '.linkinfo.info_data.bittiming.bitrate == 500000'
check "and its restart time" "$(ip -d link show can0)" can0_is '.linkinfo.info_data.restart_ms == 100'

ip link set can1 type can bitrate 500000
ip link set can1 up
watchdog relaxed
configure can0
systemctl start $unit
drive can1
check "the service reads it" "$(status .can -c; journal)" await 30 status '.can[0] | .name == "can0" and .received > 100' -e
echo "   $(status '.can[0]' -c)"
check "a pose comes of it" "$(status .pose -c)" await 20 odom pose --shm $run/pose --json

systemctl stop $unit systemd-networkd.socket systemd-networkd
kill "$driver"
wait "$driver" 2>/dev/null
rm /etc/systemd/network/80-can0.network
ip link set can0 down
ip link set can1 down
