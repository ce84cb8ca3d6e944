# The installed service. run-tests.sh sources this after guest.sh, before the tests below systemd/. They
# share one boot; the first of them installs the service, like an administrator.

# on_bus BUS: the names of the service on that bus.
on_bus() { bus=$1 unit=odomd@$1.service run=/run/odomd/$1; }
on_bus vcan0

# The built programs must not load files that the service's sandbox excludes.
PATH=/usr/local/sbin:/usr/local/bin:$PATH
export LD_LIBRARY_PATH=/usr/local/lib

main_pid() { systemctl show -P MainPID "${1:-$unit}"; }
is_active() { systemctl is-active --quiet "${1:-$unit}"; }
settled() { status '.mode != "initialising" and .beat.ticks > 50' -e; }

# is_confined UNIT: checks the unit's hardening.
is_confined() {
  local rights exposure
  rights=$(sed -nE 's/^(CapPrm|CapEff|CapBnd|NoNewPrivs|Seccomp):\t//p' "/proc/$(main_pid "$1")/status" | tr -d '\n')
  exposure=$(systemd-analyze security --no-pager "$1" | sed -n 's/.*exposure level.*: \([0-9.]*\) .*/\1/p')
  check "it has no capability, gains none, and its calls are filtered" "$rights" test "$rights" = "$(printf '%048d' 0)12"
  check "systemd calls it exposed by 2.0 at most" "$exposure" awk "BEGIN {exit !(\"$exposure\" != \"\" && $exposure <= 2.0)}"
}

# is_nobodys UNIT: like is_confined, for a service without a user of its own.
is_nobodys() {
  local user
  user=$(ps -o user:32= -p "$(main_pid "$1")")
  check "it is nobody's user" "$user" test "$user" != root -a "$user" != odomd
  is_confined "$1"
}

# journal [UNIT]: prints recent log lines for a failure.
journal() { journalctl --no-pager -o cat -n 10 -u "${1:-$unit}" | tr '\n' ';'; }
state_of_daemon() { status 'del(.messages, .sources, .calibrations)' -c; journal; }

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

# drop_in UNIT [LINE...]: the only settings that the unit has besides the installed ones; without lines, none.
drop_in() {
  local settings=/run/systemd/system/$1.d
  shift
  rm -rf "$settings"
  if [ $# -gt 0 ]; then
    mkdir -p "$settings"
    printf '%s\n' "$@" >"$settings/lab.conf"
  fi
  systemctl daemon-reload
}

# drive BUS [OPTION...]: starts a live drive of laps; $driver is its process.
drive() {
  odom sim --live --can "$1" --laps 1000 --standstill 0.5 --out "drive-$1" --force "${@:2}" >"drive-$1.log" 2>&1 &
  driver=$!
}

# Tolerates a machine that pauses for a second; only tests of the watchdog use the installed limit.
relaxed='WatchdogSec=30s'

# begin [BUS [OPTION...]]: installs the product, and starts the service, which then reads the car that drives on
# this bus. At the end of the test all of it is removed.
begin() {
  local to=${1:-$bus}
  install_product || { not_ok "installs" "see above"; exit; }
  drop_in $unit '[Service]' $relaxed
  odom sim --config-only --force --out car >/dev/null
  mkdir -p /etc/odomd
  cp car/car.dbc /etc/odomd/
  cp car/car.toml /etc/odomd/$bus.toml
  [ -e "/sys/class/net/$to" ] || add_vcan "$to"
  trap 'end; exit $test_failed' EXIT
  drive "$to" "${@:2}"
  systemctl start $unit
  shows "starts, and reads its bus" '.can[0].received > 0' 30
}

end() {
  systemctl stop $unit
  reap $driver
}
