# The installed unit with its whole sandbox: it becomes ready, reads its bus, publishes in real
# time, and ends cleanly.

begin
does "becomes ready" is_active
shows "reads its bus, and loses nothing" '.can[0] | .received > 0 and .lost == 0'
does "publishes a pose" odom pose --shm $run/pose --json
does "is found by a client without arguments" odom pose --json
shows "is granted real time, and refused nothing" \
  '.realtime | .priority == 45 and .memory_locked and .dma_latency_held and .refusals == []'

pid=$(main_pid)
beat=$(grep -lx odomd-beat /proc/"$pid"/task/*/comm | cut -d/ -f5)
says "its beat is SCHED_FIFO 45" 'priority: 45$' chrt -p "$beat"
of_process() { sed -n "s/^$1:[ \t]*//p" "/proc/$pid/status"; }
check "its memory is locked" "VmLck $(of_process VmLck)" test "$(of_process VmLck | cut -d' ' -f1)" -gt 1000
check "it is not root" "Uid $(of_process Uid)" test "$(of_process Uid | cut -f1)" = "$(id -u odomd)"
is_confined $unit

mount_of() { awk -v at="$1" '$5 == at {found = $6} END {print found}' "/proc/$pid/mountinfo"; }
check "it sees no kernel settings, and cannot write to devices' or the system's" "$(mount_of /sys), $(mount_of /)" \
  test ! -e "/proc/$pid/root/proc/sys" -a "$(mount_of /sys | cut -d, -f1)$(mount_of / | cut -d, -f1)" = roro
check "nor home directories" "$(ls -A "/proc/$pid/root/root" 2>&1)" test -z "$(ls -A "/proc/$pid/root/root" 2>/dev/null)"

ticks=$(status .beat.ticks)
does "is reloaded" systemctl reload $unit
shows "goes on after that" ".beat.ticks > $ticks + 100 and .pid == $pid" 20

journalctl -o cat --no-pager -u $unit >journal.log
says "the journal says what it does" "model full, $bus into $run/pose" cat journal.log
says "in plain lines" '^$' grep -P '[^[:print:]]' journal.log

# A log file, set up as in docs/operations.md: renamed, as by logrotate, and opened again by a
# reload.
drop_in $unit '[Service]' $relaxed LogsDirectory=odomd
log=/var/log/odomd/$bus.log
printf '\n[log]\nfile = "%s"\n' $log >>/etc/odomd/$bus.toml
systemctl restart $unit
await 20 status '.beat.ticks > 0' -e
pid=$(main_pid)
check "logs into a file of its own" "$(ls -l /var/log/odomd 2>&1; journal)" await 20 grep -q "into $run/pose" $log
mv $log $log.1
systemctl reload $unit
check "a reload opens the file anew after it was moved away" "$(ls -l /var/log/odomd; journal)" \
  await 20 grep -q "the log was reopened" $log
ip link set $bus down
check "goes on in that one" "$(cat $log)" await 20 grep -q "$bus: the bus is down" $log
ip link set $bus up
says "and no longer in the old one" '^$' grep -E 'log was reopened|bus is down' $log.1
says "which are its own, and nobody else's" '^odomd odomd 600$' stat -c '%U %G %a' $log
says "without being started anew" "^$pid\$" main_pid

systemctl stop $unit
ended() { systemctl show -p ActiveState,Result,ExecMainCode,ExecMainStatus $unit | sort | tr '\n' ' '; }
says "ends cleanly when it is stopped" '^ActiveState=inactive ExecMainCode=1 ExecMainStatus=0 Result=success $' ended
check "and leaves nothing behind" "$(ls -l $run 2>&1)" test ! -e $run/pose
