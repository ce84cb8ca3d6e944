# Permissions of the installed service: readers can read, camera senders can send, and other users
# can do neither, nor disturb the service.

begin
pid=$(main_pid)

for user in reader sender outsider; do systemd-sysusers --inline "u lab-$user - - -" 2>/dev/null; done
systemd-sysusers --inline "m lab-reader odom" "m lab-sender odomd-camera"

# as USER COMMAND...: with that user's groups and without root privileges.
as() {
  (cd / && setpriv --reuid="lab-$1" --regid="lab-$1" --init-groups --inh-caps=-all "${@:2}" 2>&1 </dev/null)
}
can() { does "a $1 can $2" as "$1" "${@:3}"; } # USER WHAT COMMAND...
fails() { ! "$@"; }
cannot() { does "a $1 cannot $2" fails as "$1" "${@:3}"; }

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
shows "it was not disturbed, nor restarted" ".beat.ticks > $ticks + 50 and .pid == $pid and .can[0].link == \"up\"" 20

# Another user who waits for the abstract name of the writer's lock gets it before the daemon's
# successor.
cat >/tmp/squat.py <<end
import contextlib, os, socket, time
directory = os.stat("$run")
name = f"\\0odomd-writer:{directory.st_dev}:{directory.st_ino}:pose"
squatter = socket.socket(socket.AF_UNIX)
while not squatter.getsockname():
  with contextlib.suppress(OSError):
    squatter.bind(name)
print("taken", flush=True)
time.sleep(30)
end
as outsider python3 /tmp/squat.py >squat &
squatter=$!
sleep 3
kill -9 "$pid"
check "another user takes the name of the writer's lock" "$(cat squat)" await 20 grep -q taken squat
shows "but keeps no successor out" ".pid != $pid and .beat.ticks > 50" 20
wait $squatter
