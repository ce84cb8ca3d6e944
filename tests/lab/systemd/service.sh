# The installed unit with its whole sandbox: it becomes ready, reads its bus, publishes in real
# time, and ends cleanly.
. "$(dirname "$0")/../guest.sh"
. "$(dirname "$0")/../service.sh"

begin
check "becomes ready" "$(systemctl show -p ActiveState,SubState,Result $unit)" is_active
check "reads its bus, and loses nothing" "$(status .can -c)" status '.can[0] | .received > 0 and .lost == 0' -e
check "publishes a pose" "$(odom pose --shm $run/pose 2>&1)" odom pose --shm $run/pose --json
check "is found by a client without arguments" "$(odom pose 2>&1)" odom pose --json
check "is granted real time, and refused nothing" "$(status .realtime -c)" \
  status '.realtime | .priority == 45 and .memory_locked and .dma_latency_held and .refusals == []' -e

pid=$(main_pid)
beat=$(grep -lx odomd-beat /proc/"$pid"/task/*/comm | cut -d/ -f5)
check "its beat is SCHED_FIFO 45" "$(chrt -p "$beat")" grep -q '45$' <(chrt -p "$beat" | tail -n 1)
of_process() { sed -n "s/^$1:[ \t]*//p" "/proc/$pid/status"; }
check "its memory is locked" "VmLck $(of_process VmLck)" test "$(of_process VmLck | cut -d' ' -f1)" -gt 1000
check "it is not root" "Uid $(of_process Uid)" test "$(of_process Uid | cut -f1)" = "$(id -u odomd)"
is_confined $unit

mount_of() { awk -v at="$1" '$5 == at {found = $6} END {print found}' "/proc/$pid/mountinfo"; }
check "it sees no kernel settings, and cannot write to devices' or the system's" "$(mount_of /sys), $(mount_of /)" \
  test ! -e "/proc/$pid/root/proc/sys" -a "$(mount_of /sys | cut -d, -f1)$(mount_of / | cut -d, -f1)" = roro
check "nor home directories" "$(ls -A "/proc/$pid/root/root" 2>&1)" test -z "$(ls -A "/proc/$pid/root/root" 2>/dev/null)"

ticks=$(status .beat.ticks)
check "is reloaded" "$(journal)" systemctl reload $unit
check "goes on after that" "$(journal)" await 20 status ".beat.ticks > $ticks + 100 and .pid == $pid" -e

journalctl -o cat --no-pager -u $unit >journal.log
sed 's/^/   /' journal.log | head -n 12
check "the journal says what it does" "$(head -n 5 journal.log)" grep -q "model full, $bus into $run/pose" journal.log
check "in plain lines" "$(grep -nP '[^\x20-\x7E\t]' journal.log | head -n 3)" \
  test -z "$(grep -P '[^[:print:]]' journal.log)"

# A log file, set up as in docs/operations.md: renamed, as by logrotate, and opened again by a
# reload.
mkdir -p /run/systemd/system/$unit.d
printf '[Service]\nLogsDirectory=odomd\n' >/run/systemd/system/$unit.d/log.conf
systemctl daemon-reload
log=/var/log/odomd/$bus.log
printf '\n[log]\nfile = "%s"\n' $log >>/etc/odomd/$bus.toml
systemctl restart $unit
await 20 publishes
pid=$(main_pid)
check "logs into a file of its own" "$(ls -l /var/log/odomd 2>&1; journal)" await 20 grep -q "into $run/pose" $log
mv $log $log.1
systemctl reload $unit
check "a reload opens the file anew after it was moved away" "$(ls -l /var/log/odomd; journal)" \
  await 20 grep -q "the log was reopened" $log
ip link set $bus down
check "goes on in that one" "$(cat $log)" await 20 grep -q "$bus: the bus is down" $log
ip link set $bus up
check "and no longer in the old one" "$(cat $log.1)" test -z "$(grep -E 'log was reopened|bus is down' $log.1)"
check "which are its own, and nobody else's" "$(stat -c '%U %G %a' $log)" test "$(stat -c '%U %G %a' $log)" = "odomd odomd 600"
check "without being started anew" "$pid, $(main_pid)" test "$pid" = "$(main_pid)"
rm /run/systemd/system/$unit.d/log.conf
systemctl daemon-reload

systemctl stop $unit
ended=$(systemctl show -p ActiveState,Result,ExecMainCode,ExecMainStatus $unit | sort | tr '\n' ' ')
check "ends cleanly when it is stopped" "$ended" \
  test "$ended" = "ActiveState=inactive ExecMainCode=1 ExecMainStatus=0 Result=success "
check "and leaves nothing behind" "$(ls -l $run 2>&1)" test ! -e $run/pose
end
