#!/bin/bash
# Tests the Debian packages on a separate machine, following docs/operations.md: packages.sh [RELEASE]
# Builds the packages, or takes those of tools/release.sh from the directory RELEASE, and boots the
# lab's machine with systemd. It tests apt install; the bus, which systemd-networkd brings up on an
# emulated controller, with a car at the other end of the wire; enabling and starting the service; a
# user who joins the group and reads the pose; the page's settings, except the log file; and reinstallation,
# upgrade with a running service, removal and purge. Ends with a dated summary line.
#
# This takes some minutes, because apt and dpkg read the host's whole database through the machine's
# file system.
set -uo pipefail
here=$(cd "$(dirname "$0")" && pwd)
tree=$(cd "$here/../.." && pwd)
packages=$tree/build/release/packages

if [ "${1-}" != --in-the-machine ]; then
  . "$here/common.sh"
  rm -rf "$packages"
  if [ -n "${1-}" ]; then
    mkdir -p "$packages" && cp "$1"/*_{amd64,all}.deb "$packages" || exit 1
  else
    build all
    cpack --config build/release/CPackConfig.cmake >/dev/null || exit 1
  fi
  # The upgrade: a higher version.
  mkdir "$packages/younger"
  for package in "$packages"/{odomd,odom-web,odom-bridge}_*.deb; do
    unpacked=$(mktemp -d)
    dpkg-deb -R "$package" "$unpacked" && sed -i 's/^Version: .*/&+younger/' "$unpacked/DEBIAN/control" &&
      dpkg-deb -b --root-owner-group "$unpacked" "$packages/younger" >/dev/null || exit 1
    rm -rf "$unpacked"
  done

  log=build/logs/packages.log
  LAB_TIMEOUT=${LAB_TIMEOUT:-1800} tests/lab/lab.sh run --systemd "$here/packages.sh" --in-the-machine | tee $log
  passed=$(grep -c '^ok ' $log)
  failed=$(grep -c '^not ok ' $log)
  verdict=
  [ "$passed" -ge 40 ] && [ "$failed" = 0 ] && tail -n 1 $log | grep -q '^the end' || verdict='FAILED: '
  echo "$(date -u +%F) packages: $verdict$passed passed, $failed failed in $((SECONDS - begin)) s"
  [ -z "$verdict" ]
  exit
fi

# In the machine -----------------------------------------------------------------------------------

LAB_TEST=packages
. "$tree/tests/lab/guest.sh"
PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin
export DEBIAN_FRONTEND=noninteractive
cd "$(mktemp -d)" || exit 1
unit=odomd@can0
names='odomd odom-tools libodom0 libodom-dev python3-odom odom-bridge odom-web odom-track odom-fit'

main_pid() { systemctl show -P MainPID $unit; }
status() { odom status --json | jq -e "$1"; }
as_newcomer() { runuser -l newcomer -c "$1"; }
journal() { journalctl -u $unit --no-pager -o cat "$@"; }

echo "-- install"
useradd -m newcomer
getent passwd odomd >/dev/null && not_ok "the machine knows no odomd yet" "it does"
does "apt installs the packages" apt install -y "$packages"/*.deb
for group in odom odomd-camera; do does "there is a group $group" getent group $group; done
says "there is a user odomd, who cannot log in" ':/usr/sbin/nologin$' getent passwd odomd
says "its unit is there" '^odomd@.service +disabled' systemctl list-unit-files 'odomd@*'
says "the receive buffers may be large" '= 1048576' sysctl net.core.rmem_max
says "odomd may hold the CPUs awake" 'odomd 660' stat -c '%G %a' /dev/cpu_dma_latency
says "a new user sees what is missing" 'no such segment: is odomd running' as_newcomer "odom pose"

echo "-- bring the bus up"
cp /usr/lib/systemd/network/80-can0.network.example /etc/systemd/network/80-can0.network
# networkctl needs D-Bus, which the lab usually masks.
rm -f /etc/systemd/system/dbus.s*
systemctl daemon-reload
systemctl start dbus.socket
does "systemd-networkd is started" systemctl enable --now systemd-networkd
up() { ip -details link show can0 | grep -A2 ERROR-ACTIVE | tr '\n' ' ' | grep 'restart-ms 100.*bitrate 500000'; }
does "it brings can0 up as the example says" await 30 up
does "a changed file is taken" sh -c 'networkctl reload && networkctl reconfigure can0'
does "can0 is up after that" await 30 up

echo "-- describe the car, start"
does "the configuration that lies there is usable" odomd --config /etc/odomd/can0.toml --check
does "the service is enabled and started" systemctl enable --now $unit
says "it is active" '^active' systemctl is-active $unit
says "it is enabled" '^enabled' systemctl is-enabled $unit
ip link set can1 up type can bitrate 500000
odom sim --live --can can1 --laps 1000 --standstill 0.5 --out car --force >car.log 2>&1 &
driver=$!
does "it hears the car on the bus" await 30 status '.can[0].received > 200 and .frames.decoded > 200'
does "and knows where it is" await 30 status '.mode == "dead_reckoning" and .pose.x * .pose.x > 0.01'

echo "-- look at it, who may do what"
says "a user outside the group gets that message" 'refused: untrusted owner|not allowed' as_newcomer "odom pose"
does "a user joins the group" usermod -aG odom newcomer
does "and sees the pose" as_newcomer "odom pose"
does "and the status" as_newcomer "odom status"
does "follows it" as_newcomer "timeout --preserve-status 1 odom pose --follow"
says "reads it in Python" 'Pose' as_newcomer "python3 -c 'import odom; print(odom.Client().latest())'"
says "real time is granted, as the page promises" 'SCHED_FIFO 45, memory locked, cpu_dma_latency held' odom status
says "sends no camera pose" 'no such socket|not allowed' as_newcomer "odom camera send --pose 1.20,0.35,1.57"
says "the journal has what it says" 'model full, can0 into /run/odomd/can0/pose' journal

echo "-- a camera"
printf '\n[camera]\n' >>/etc/odomd/can0.toml
does "the service is restarted with a [camera] table" systemctl restart $unit
says "a user who may not send gets that message" 'camera.sock: not allowed; join the group' \
  as_newcomer "odom camera send --pose 1.20,0.35,1.57"
does "a user joins the senders" usermod -aG odomd-camera newcomer
does "and sends" as_newcomer "odom camera send --pose 1.20,0.35,1.57"
does "the pose begins there" await 20 status '.pose.x > 0.5 and .mode != "initialising"'
says "camera.sock is the senders'" 'odomd odomd-camera 660' stat -c '%U %G %a' /run/odomd/can0/camera.sock

echo "-- settings of the service"
# edits UNIT LINE...: `systemctl edit`, on a terminal, with an editor that writes these lines.
edits() {
  local edited=$1
  shift
  printf '%s\n' "$@" >lines
  script -qec "SYSTEMD_EDITOR='cp $PWD/lines' systemctl edit $edited" /dev/null </dev/null && systemctl restart $unit
}
goes_on() { await 20 status '.beat.ticks > 0'; }
does "a second bus" edits $unit '[Unit]' 'Wants=sys-subsystem-net-devices-can1.device' \
  'After=sys-subsystem-net-devices-can1.device' '[Service]' 'Environment="ODOMD_OPTIONS=--can can1"'
does "it reads both" await 20 status '[.can[].name] == ["can0", "can1"]'
does "more in the log, for all interfaces" edits odomd@.service '[Service]' 'Environment="ODOMD_OPTIONS=--log-level debug"'
systemctl revert $unit
does "a priority above 49" edits $unit '[Service]' 'LimitRTPRIO=80'
sed -i '$a [realtime]\npriority = 60' /etc/odomd/can0.toml
does "it is granted" sh -c "systemctl restart $unit"
does "and in use" await 20 status '.realtime.priority == 60'
systemctl revert $unit
systemctl restart $unit
says "without that limit the journal says what is missing" 'SCHED_FIFO 60.: Operation not permitted; set LimitRTPRIO=60' journal
sed -i '/^\[realtime\]$/,$d' /etc/odomd/can0.toml
does "other groups" edits $unit '[Service]' 'Environment=ODOMD_READERS=video ODOMD_CAMERA_SENDERS=video' \
  'SupplementaryGroups=video'
says "the pose is theirs" '^video' stat -c %G /run/odomd/can0/pose
cp /etc/odomd/can0.toml /etc/odomd/elsewhere.toml
does "a configuration elsewhere" edits $unit '[Service]' 'ExecStart=' "$(systemctl cat odomd@can0 |
  sed -n '/^ExecStart=.*--config/,/[^\\]$/p' | sed 's/--config [^ ]*/--config \/etc\/odomd\/elsewhere.toml/')"
says "it reads that" '/etc/odomd/elsewhere.toml' odom status
systemctl revert odomd@.service $unit
does "back to what was installed" systemctl restart $unit

echo "-- upgrade"
does "it runs" goes_on
before=$(main_pid)
printf '# mine\n' >>/etc/odomd/can0.toml
does "the same package once more" apt install -y --reinstall "$packages"/odomd_*.deb
says "my configuration is kept" '^# mine$' tail -n 1 /etc/odomd/can0.toml
does "what ran, runs" goes_on
[ "$(main_pid)" != "$before" ] && ok "as another process" || not_ok "as another process" "pid $before"
before=$(main_pid)
does "a younger package" dpkg -i "$packages"/younger/odomd_*.deb
does "what ran goes on" goes_on
says "from the last pose" "resuming from the last pose" journal "_PID=$(main_pid)"
[ "$(main_pid)" != "$before" ] && ok "as another process again" || not_ok "as another process again" "pid $before"
others='odomd-web@can0 odomd-bridge@can0'
does "page and bridge are enabled and started" systemctl enable --now $others
before=$(systemctl show -P MainPID $others)
does "younger ones" dpkg -i "$packages"/younger/odom-{web,bridge}_*.deb
says "both run, as other processes" '^4$' \
  sh -c "printf '%s\\n' $(echo $before) \$(systemctl show -P MainPID $others) | grep -vx 0 | sort -u | wc -l"
does "the page has the pose" await 20 sh -c "curl -s http://127.0.0.1:9880/metrics | grep '^odom_up.* 1\$'"
says "my configuration is kept again" '^# mine$' tail -n 1 /etc/odomd/can0.toml

echo "-- removal"
dpkg -L $names | sort -u | while read -r path; do [ -d "$path" ] || echo "$path"; done >files
does "apt removes the daemon" apt remove -y odomd
says "it is stopped" '^inactive' systemctl is-active $unit
says "as are page and bridge, which need it" '^inactive inactive $' sh -c "systemctl is-active $others | tr '\\n' ' '"
[ ! -e /run/odomd/can0 ] && ok "its directory is gone" || not_ok "its directory is gone" "$(ls -l /run/odomd)"
says "the configuration stays" '^# mine$' tail -n 1 /etc/odomd/can0.toml
rm /etc/odomd/elsewhere.toml
install -D /dev/null /var/log/odomd/can0.log  # as of a daemon with [log] file
does "apt purges everything" apt purge -y $names
left=$(while read -r path; do [ ! -e "$path" ] || echo "$path"; done <files
  find /etc /run /var/lib /var/log /usr/lib/systemd /usr/share/odomd /usr/share/doc -maxdepth 5 -xdev -iname '*odom*' 2>/dev/null |
    grep -vE '^/run/lab|/var/lib/dpkg/|/systemd/units/|/apt/')
[ -z "$left" ] && ok "nothing of it is left" || not_ok "nothing of it is left" "$(echo $left)"
says "nor is it known to systemd" '^0 unit files' systemctl list-unit-files 'odomd@*'
does "but the user and the groups" getent group odom odomd-camera odomd

kill $driver
echo "the end"
[ $test_failed = 0 ]
