# The services of bridge and daemon together: the bridge reads the pose as a dynamic user, survives
# a restart of the daemon, sends topics over DDS and JSON over UDP, and takes camera poses from a
# topic. The loopback is the only network.
bridge=odomd-bridge@$bus.service

begin
ip link set lo up
export CYCLONEDDS_URI="<General><Interfaces><NetworkInterface name='lo'/></Interfaces><AllowMulticast>false\
</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex><Peers><Peer Address='127.0.0.1'/>\
</Peers></Discovery>"
# set_up OPTIONS [LINE]: writes the service's drop-in.
set_up() {
  drop_in $bridge '[Service]' "Environment=\"ODOM_BRIDGE_OPTIONS=--json $1\"" \
    "Environment=\"CYCLONEDDS_URI=$CYCLONEDDS_URI\"" "${2-}"
}
set_up "--ros --udp 127.0.0.1:9870"

# received FILTER: a datagram of the next second, filtered by jq.
received() {
  python3 -c '
import socket
receiver = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
receiver.settimeout(1.0)
receiver.bind(("127.0.0.1", 9870))
print(receiver.recv(65536).decode())' 2>/dev/null | jq -r "$@"
}

says "it is off until somebody enables it" '^disabled' systemctl is-enabled $bridge
does "it starts" systemctl start $bridge
check "it sends what the service publishes" "$(journal $bridge)" await 60 received '.odomd.velocity.x > 0.1' -e
is_nobodys $bridge

pid=$(main_pid $bridge)
instance=$(status .instance)
kill -9 "$(main_pid)"
shows "the daemon is started anew" ".instance != \"$instance\" and .mode != \"initialising\" and .beat.ticks > 50" 60
check "it goes on with the daemon's successor" "$(journal $bridge)" await 60 received '.odomd.velocity.x > 0.1' -e
says "and is the one that was started" "^$pid\$" main_pid $bridge

systemctl stop $bridge
summary() { journalctl --no-pager -o cat -u $bridge | grep '^{' | tail -n 1; }
check "it says what it sent" "$(journal $bridge)" \
  jq -e '.restarts == 1 and (.sinks | length) == 2 and all(.sinks[]; .sent > 0)' <<<"$(summary)"
says "its end is no failure" '^success$' systemctl show -P Result $bridge

lab_pose_publisher &
publisher=$!
# A verdict shows that a pose arrived, even if a slow machine delivered it too late.
judged='any(.sources[]; .name == "camera" and ([.verdicts[]] | add) > 0)'
set_up "--pose-topic /pose --no-publish"
systemctl start $bridge
refused() { journal $bridge | grep 'camera.sock: not allowed'; }
check "poses from a topic need the senders' group, it says" "$(journal $bridge)" await 60 refused
shows "and none gets through" "$judged | not"
set_up "--ros --pose-topic /pose" "SupplementaryGroups=odomd-camera"
systemctl restart $bridge
shows "with it they reach the daemon" "$judged" 60
systemctl stop $bridge
check "and it read the pose as well" "$(journal $bridge)" jq -e '.input.sent > 0 and .ticks > 0' <<<"$(summary)"
kill $publisher
drop_in $bridge
