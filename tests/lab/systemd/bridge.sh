# The bridge's service together with the daemon's: it reads the pose as a dynamic user, survives a
# restart of the daemon, and sends topics by DDS and JSON by UDP. There is no network but the
# loopback.
. "$(dirname "$0")/../guest.sh"
. "$(dirname "$0")/../service.sh"
bridge=odomd-bridge@$bus.service

begin
ip link set lo up
mkdir -p /run/systemd/system/$bridge.d
cat >/run/systemd/system/$bridge.d/lab.conf <<'end'
[Service]
Environment="ODOM_BRIDGE_OPTIONS=--udp 127.0.0.1:9870 --json"
Environment="CYCLONEDDS_URI=<General><Interfaces><NetworkInterface name='lo'/></Interfaces><AllowMulticast>false</AllowMulticast></General>"
end
systemctl daemon-reload

# received FILTER: a datagram that comes within a second, by jq.
received() {
  python3 -c '
import socket
receiver = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
receiver.settimeout(1.0)
receiver.bind(("127.0.0.1", 9870))
print(receiver.recv(65536).decode())' 2>/dev/null | jq -r "$@"
}
said() { journalctl --no-pager -o cat -n 10 -u $bridge | tr '\n' ';'; }

check "it is off until somebody enables it" "$(systemctl is-enabled $bridge)" \
  test "$(systemctl is-enabled $bridge)" = disabled
check "it starts" "$(said)" systemctl start $bridge
check "it sends what the service publishes" "$(said)" await 60 received '.odomd.velocity.x > 0.1' -e
user=$(ps -o user:32= -p "$(main_pid $bridge)")
check "it is nobody's user" "$user" test "$user" != root -a "$user" != odomd

pid=$(main_pid $bridge)
instance=$(status .instance)
kill -9 "$(main_pid)"
succeeded() { [ "$(status .instance)" != "$instance" ] && settled; }
check "the daemon is started anew" "$(journal)" await 60 succeeded
check "it goes on with the daemon's successor" "$(said)" await 60 received '.odomd.velocity.x > 0.1' -e
check "and is the one that was started" "$(main_pid $bridge)" test "$(main_pid $bridge)" = "$pid"

systemctl stop $bridge
summary=$(journalctl --no-pager -o cat -u $bridge | grep '^{')
check "it says what it sent" "$(said)" jq -e '.restarts == 1 and all(.sinks[]; .sent > 0)' <<<"$summary"
check "its end is no failure" "$(systemctl show -p Result $bridge)" \
  test "$(systemctl show -P Result $bridge)" = success
rm -r /run/systemd/system/$bridge.d
end
