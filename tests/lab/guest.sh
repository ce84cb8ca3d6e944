# Functions of the lab's tests. run-tests.sh sources this before each of them; packages.sh and release.sh
# in tests/campaign, and full_traffic.sh in tests/daemon/discipline, use it, too.

set -u
PATH=${ODOMD_BIN_DIR:+$ODOMD_BIN_DIR:}$PATH
test_failed=0
trap 'exit $test_failed' EXIT

ok() { echo "ok $LAB_TEST: $*"; }
not_ok() { # not_ok NAME REASON
  echo "not ok $LAB_TEST: $1: $2"
  test_failed=1
}

# check NAME REASON COMMAND...: ok if the command succeeds.
check() {
  local name=$1 reason=$2
  shift 2
  if "$@" >/dev/null; then ok "$name"; else not_ok "$name" "$reason"; fi
}

# does NAME COMMAND...: the command must succeed; if it fails, its output is printed.
does() {
  local name=$1 said
  shift
  said=$("$@" 2>&1 </dev/null) && ok "$name" || not_ok "$name" "$(tail -n 3 <<<"$said" | tr '\n' ';')"
}
says() { # says NAME PATTERN COMMAND...: the output must match; any exit status
  local name=$1 pattern=$2 said
  shift 2
  said=$("$@" 2>&1 </dev/null)
  grep -qE -- "$pattern" <<<"$said" && ok "$name" || not_ok "$name" "$(tail -n 3 <<<"$said" | tr '\n' ';')"
}

# await SECONDS COMMAND...: whether the command succeeds within that time.
await() {
  local end=$((SECONDS + $1))
  shift
  until "$@" >/dev/null 2>&1; do
    [ $SECONDS -lt $end ] || return 1
    sleep 0.05
  done
}

# reap PROCESS...: ends processes of this shell.
reap() {
  kill "$@" 2>/dev/null
  wait "$@" 2>/dev/null
}

# Buses --------------------------------------------------------------------------------------------

# add_vcan NAME...: brings up virtual buses that carry CAN FD. run-tests.sh removes what a test leaves.
add_vcan() {
  local bus
  for bus; do
    ip link add "$bus" type vcan
    ip link set "$bus" mtu 72 up
  done
}

# listen BUS FILE: starts candump, which writes received frames to the file; $logger is its process.
listen() {
  candump -L "$1" >"$2" &
  logger=$!
  await 5 grep -qE "^ +$1 " /proc/net/can/rcvlist_all
}

# link_packets NAME: how many packets were sent on a link. On vcan each of them is also received.
link_packets() { cat "/sys/class/net/$1/statistics/tx_packets"; }

# simulate OPTION...: a drive in drive/; drive.log is its log on vcan0, with $frames lines.
simulate() {
  odom sim "$@" --out drive --force >/dev/null 2>&1
  sed 's/ can[0-9]* / vcan0 /' drive/drive.log >drive.log
  frames=$(wc -l <drive.log)
}

# The daemon ---------------------------------------------------------------------------------------

# start_daemon CONFIG ARGUMENT...: starts odomd with a separate segment and sockets, and waits until
# it is ready.
start_daemon() {
  local config=$1
  shift
  odomd --config "$config" --shm /lab --status-socket "$PWD/status.sock" \
    --camera-socket "$PWD/camera.sock" "$@" 2>odomd.log &
  daemon=$!
  await 20 test -S status.sock && await 20 status '.beat.ticks > 0' -e || not_ok "start" "$(cat odomd.log)"
}

# stop_daemon [NAME]: stops it; it must end cleanly.
stop_daemon() {
  kill "$daemon" 2>/dev/null
  wait "$daemon"
  local result=$?
  check "${1:+$1: }ends cleanly" "status $result: $(tail -n 3 odomd.log)" test $result = 0
}

# status FILTER [JQ-OPTION...]: a value of the running daemon's status.
status() {
  local filter=$1
  shift
  odom status --json --socket "${run:-$PWD}/status.sock" | jq -r "$@" "$filter"
}
state_of_daemon() { status 'del(.messages, .sources, .calibrations)' -c; tail -n 3 odomd.log; }

# shows NAME FILTER [SECONDS]: the status fulfils the filter, immediately or within that time.
shows() { await "${3:-0}" status "$2" -e && ok "$1" || not_ok "$1" "$(state_of_daemon)"; }
# logs NAME PATTERN: odomd says this within 20 s.
logs() { await 20 grep -q -- "$2" odomd.log && ok "$1" || not_ok "$1" "$(cat odomd.log)"; }
