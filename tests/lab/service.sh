# The installed service. The tests below systemd/ source this after guest.sh. They share one boot;
# the first of them installs the service, like an administrator.

bus=vcan0
unit=odomd@$bus.service
run=/run/odomd/$bus

# The built programs must not load files that the service's sandbox excludes.
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

# is_confined UNIT: checks the unit's hardening.
is_confined() {
  local rights exposure
  rights=$(sed -nE 's/^(CapPrm|CapEff|CapBnd|NoNewPrivs|Seccomp):\t//p' "/proc/$(main_pid "$1")/status" | tr -d '\n')
  exposure=$(systemd-analyze security --no-pager "$1" | sed -n 's/.*exposure level.*: \([0-9.]*\) .*/\1/p')
  check "it has no capability, gains none, and its calls are filtered" "$rights" test "$rights" = "$(printf '%048d' 0)12"
  check "systemd calls it exposed by 2.0 at most" "$exposure" awk "BEGIN {exit !(\"$exposure\" != \"\" && $exposure <= 2.0)}"
}

# journal [UNIT]: prints recent log lines for a failure.
journal() { journalctl --no-pager -o cat -n 10 -u "${1:-$unit}" | tr '\n' ';'; }

install_product() {
  [ ! -e /run/odomd.installed ] || return 0
  cmake --install "${ODOMD_BIN_DIR%/bin}" >install.log 2>&1 || { tail -n 5 install.log; return 1; }
  systemd-sysusers odomd.conf >>install.log 2>&1
  systemd-tmpfiles --create odomd.conf
  /lib/systemd/systemd-sysctl 50-odomd.conf
  udevadm control --reload
  udevadm trigger --settle --name-match=/dev/cpu_dma_latency
  # If another unit wants this unit, systemd keeps this unit's result after its end.
  systemctl add-wants --quiet lab.service "$unit"
  touch /run/odomd.installed
}

# configure BUS: writes the configuration of the simulated car for the service on that bus.
configure() {
  odom sim --config-only --force --out car >/dev/null
  mkdir -p /etc/odomd
  cp car/car.dbc /etc/odomd/
  cp car/car.toml "/etc/odomd/$1.toml"
}

# drive BUS [OPTION...]: starts a live drive of laps; $driver is its process.
drive() {
  local to=$1
  shift
  odom sim --live --can "$to" --laps 1000 --standstill 0.5 --out "drive-$to" --force "$@" \
    >"drive-$to.log" 2>&1 &
  driver=$!
}

# watchdog installed|relaxed: `relaxed` tolerates a machine that pauses for a second; only tests of
# the watchdog use the installed limit.
watchdog() {
  local settings=/run/systemd/system/$unit.d
  rm -rf "$settings"
  if [ "$1" = relaxed ]; then
    mkdir -p "$settings"
    printf '[Service]\nWatchdogSec=30s\n' >"$settings/lab.conf"
  fi
  systemctl daemon-reload
}

# begin [OPTION...]: starts the service, which then reads the driving car.
begin() {
  if ! install_product; then
    not_ok "installs" "see above"
    exit
  fi
  watchdog relaxed
  configure $bus
  add_vcan $bus
  drive $bus "$@"
  systemctl start $unit && await 30 status '.can[0].received > 0' -e ||
    not_ok "starts" "$(journal)"
}

# end: removes everything for the next test.
end() {
  systemctl stop $unit
  kill "$driver" 2>/dev/null
  wait "$driver" 2>/dev/null
  remove_link $bus
}
