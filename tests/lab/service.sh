# The installed service. Sourced after guest.sh by the tests below systemd/, which share one boot: the
# first of them installs, as an administrator does.

bus=vcan0
unit=odomd@$bus.service
run=/run/odomd/$bus

# What the service's sandbox is to keep out must not come in by the tree's own programs.
PATH=/usr/local/sbin:/usr/local/bin:$PATH
export LD_LIBRARY_PATH=/usr/local/lib

# status FILTER [JQ-OPTION...]: a value of the service's status.
status() {
  local filter=$1
  shift
  odom status --json --socket "$run/status.sock" | jq -r "$@" "$filter"
}

main_pid() { systemctl show -P MainPID "${1:-$unit}"; }
is_active() { systemctl is-active --quiet "${1:-$unit}"; }
publishes() { status '.beat.ticks > 0' -e; }
settled() { status '.mode != "initialising" and .beat.ticks > 50' -e; }

# What to know where something went wrong.
journal() { journalctl --no-pager -o cat -n "${1:-10}" -u "$unit" | tr '\n' ';'; }

install_product() {
  [ ! -e /run/odomd.installed ] || return 0
  cmake --install "${ODOMD_BIN_DIR%/bin}" >install.log 2>&1 || { tail -n 5 install.log; return 1; }
  systemd-sysusers odomd.conf >>install.log 2>&1
  systemd-tmpfiles --create odomd.conf
  /lib/systemd/systemd-sysctl 50-odomd.conf
  udevadm control --reload
  udevadm trigger --settle --name-match=/dev/cpu_dma_latency
  # Wanted by a unit that is there, it is remembered after its end, with its result.
  systemctl add-wants --quiet lab.service "$unit"
  touch /run/odomd.installed
}

# configure BUS: the simulated car, whose service on that bus is to read it.
configure() {
  odom sim --config-only --force --out car >/dev/null
  mkdir -p /etc/odomd
  cp car/car.dbc /etc/odomd/
  cp car/car.toml "/etc/odomd/$1.toml"
}

# drive BUS [OPTION...]: the car drives round and round, live; $driver is its process.
drive() {
  local to=$1
  shift
  odom sim --live --can "$to" --laps 1000 --standstill 0.5 --out "drive-$to" --force "$@" \
    >"drive-$to.log" 2>&1 &
  driver=$!
}

# watchdog installed|patient: a machine that is paused for a second must not look like a daemon that
# hangs, but where that is the question.
watchdog() {
  local settings=/run/systemd/system/$unit.d
  rm -rf "$settings"
  if [ "$1" = patient ]; then
    mkdir -p "$settings"
    printf '[Service]\nWatchdogSec=30s\n' >"$settings/lab.conf"
  fi
  systemctl daemon-reload
}

# begin [OPTION...]: the service runs, and reads the driving car.
begin() {
  if ! install_product; then
    not_ok "installs" "see above"
    exit
  fi
  watchdog patient
  configure $bus
  add_vcan $bus
  drive $bus "$@"
  systemctl start $unit && await 30 status '.can[0].received > 0' -e ||
    not_ok "starts" "$(journal)"
}

# end: nothing of it is left for the next test.
end() {
  systemctl stop $unit
  kill "$driver" 2>/dev/null
  wait "$driver" 2>/dev/null
  remove_link $bus
}
