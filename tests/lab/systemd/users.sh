# Permissions of the installed service: readers can read, camera senders can send, and other users
# can do neither, nor disturb the service.
. "$(dirname "$0")/../guest.sh"
. "$(dirname "$0")/../service.sh"

begin
pid=$(main_pid)

for user in reader sender outsider; do systemd-sysusers --inline "u lab-$user - - -" 2>/dev/null; done
systemd-sysusers --inline "m lab-reader odom" "m lab-sender odomd-camera"

# as USER COMMAND...: with that user's groups and without root privileges.
as() {
  local user=lab-$1
  shift
  (cd / && setpriv --reuid="$user" --regid="$user" --init-groups --inh-caps=-all "$@" 2>&1 </dev/null)
}
can() { # USER WHAT COMMAND...
  local user=$1 what=$2 said
  shift 2
  said=$(as "$user" "$@") && ok "a $user can $what" || not_ok "a $user can $what" "$(tail -n 2 <<<"$said")"
}
cannot() { # USER WHAT COMMAND...
  local user=$1 what=$2 said
  shift 2
  said=$(as "$user" "$@") && not_ok "a $user cannot $what" "$(tail -n 2 <<<"$said")" || ok "a $user cannot $what"
}

send="odom camera send --socket $run/camera.sock --sigma 2,2,1 --pose"
can reader "read the pose" odom pose --shm $run/pose
can reader "find it without being given its path" odom pose
can reader "ask for the status" odom status --json --socket $run/status.sock
cannot reader "send a camera pose" $send 5,5,1

# A camera pose a metre away, with a large sigma. A pose that a slow machine delays for too long is
# not fused, so more are sent.
can sender "send a camera pose" $send 0,0,0
fused() {
  as sender $send "$(status '.pose | "\(.x + 1),\(.y),\(.yaw)"')"
  status 'any(.sources[]; .name == "camera" and .verdicts.fused > 0)' -e
}
check "what it sends is fused" "$(status '.pose, .camera' -c)" await 20 fused
cannot sender "read the pose" odom pose --shm $run/pose
cannot sender "write the pose" dd if=/dev/zero of=$run/pose bs=8 count=1 conv=notrunc

cannot outsider "read the pose" odom pose --shm $run/pose
cannot outsider "open the segment" cat $run/pose
cannot outsider "ask for the status" odom status --json --socket $run/status.sock
cannot outsider "send a camera pose" $send 5,5,1

# No other user can disturb the service: not through its files, its directory, its lock or a signal.
cat >/tmp/attacks <<end
rm -f $run/pose
rm -f $run/camera.sock
rm -f $run/status.sock
rm -f $run/pose.lock
mv $run/pose $run/other
mv $run /run/odomd/other
touch $run/pose.tmp
touch $run/other
ln -s /dev/null /run/odomd/vcan1
truncate -s 0 $run/pose
chmod 666 $run/pose
flock -n $run/pose.lock true
kill -9 $pid
kill -STOP $pid
renice 19 $pid
chrt -o -p 0 $pid
taskset -p 1 $pid
cat /proc/$pid/environ
touch /etc/odomd/$bus.toml
end
for user in reader sender outsider; do
  as $user sh -c 'while read -r attack; do $attack >/dev/null 2>&1 && echo "HOLE $attack"; done </tmp/attacks; echo "all tried"' >attacked
  check "a $user cannot disturb it" "$(cat attacked)" test "$(cat attacked)" = "all tried"
done

ticks=$(status .beat.ticks)
check "it was not disturbed" "$(journal)" \
  await 20 status ".beat.ticks > $ticks + 50 and .pid == $pid and .can[0].link == \"up\"" -e
check "nor restarted" "$(systemctl show -p NRestarts $unit)" test "$(main_pid)" = "$pid"

# Another user who waits for the abstract name of the writer's lock gets it before the daemon's
# successor.
cat >/tmp/squat.py <<end
import os, socket, time
directory = os.stat("$run")
name = f"\\0odomd-writer:{directory.st_dev}:{directory.st_ino}:pose"
squatter = socket.socket(socket.AF_UNIX)
while True:
  try:
    squatter.bind(name)
    break
  except OSError:
    pass
print("taken", flush=True)
time.sleep(30)
end
as outsider python3 /tmp/squat.py >squat &
squatter=$!
sleep 3
kill -9 "$pid"
check "another user takes the name of the writer's lock" "$(cat squat)" await 20 grep -q taken squat
check "but keeps no successor out" "$(journal)" await 20 status ".pid != $pid and .beat.ticks > 50" -e
wait $squatter
end
