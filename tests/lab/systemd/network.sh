# A real controller (an emulated SJA1000) under systemd-networkd: the installed example brings can0 up,
# and odomd@can0 reads what a car sends from the other end of the wire.
on_bus can0

install_product || { not_ok "installs" "see above"; exit; }
can0_is() { ip -j -d link show can0 | jq -e ".[0] | $1"; }
check "there is a controller, down and without a bit rate" "$(ip -d link show can0)" \
  can0_is '(.flags | index("UP") | not) and (.linkinfo.info_data.bittiming.bitrate | not)'

mkdir -p /etc/systemd/network
cp /usr/local/lib/systemd/network/80-can0.network.example /etc/systemd/network/80-can0.network
systemctl start systemd-networkd
check "networkd brings it up" "$(ip -d link show can0)" await 30 can0_is '.flags | index("UP")'
check "with the bit rate and restart time of the file" "$(ip -d link show can0)" \
  can0_is '.linkinfo.info_data | .bittiming.bitrate == 500000 and .restart_ms == 100'

ip link set can1 up type can bitrate 500000
begin can1
shows "the service reads it" '.can[0] | .name == "can0" and .received > 100' 30
check "a pose comes of it" "$(status .pose -c)" await 20 odom pose --shm $run/pose --json

systemctl stop $unit systemd-networkd.socket systemd-networkd
rm /etc/systemd/network/80-can0.network
ip link set can0 down
ip link set can1 down
