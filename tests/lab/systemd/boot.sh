# The machine itself, with systemd as init: it has booted without a failed unit, keeps a journal, and
# has a device unit for a bus. If this fails, no other result here is meaningful.
. "$(dirname "$0")/../guest.sh"

check "systemd is the first process" "$(cat /proc/1/comm)" grep -qx systemd /proc/1/comm
check "kernel is PREEMPT_RT" "$(uname -v)" grep -qw PREEMPT_RT /proc/version
check "no unit failed" "$(systemctl --failed --no-legend)" test -z "$(systemctl --failed --no-legend)"

logger -t lab "the journal keeps this"
check "the journal keeps what is said" "$(journalctl -t lab)" \
  await 20 sh -c 'journalctl -o cat -t lab | grep -qx "the journal keeps this"'

add_vcan vcan0
check "a bus is a device unit" "$(systemctl status sys-subsystem-net-devices-vcan0.device)" \
  await 20 systemctl is-active sys-subsystem-net-devices-vcan0.device
remove_link vcan0
check "and is none when it is gone" "$(systemctl status sys-subsystem-net-devices-vcan0.device)" \
  await 20 sh -c '! systemctl is-active sys-subsystem-net-devices-vcan0.device'
