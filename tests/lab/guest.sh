# Functions of the lab's tests. Each of tests/*.sh sources this in the machine, and so does
# tests/campaign/release.sh.

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

# add_vcan NAME...: brings up virtual buses that carry CAN FD.
add_vcan() {
  local bus
  for bus; do
    ip link add "$bus" type vcan
    ip link set "$bus" mtu 72 up
  done
}

remove_link() { ip link del "$1" 2>/dev/null; }

# link_packets NAME: how many packets were sent on a link. On vcan each of them is also received.
link_packets() { cat "/sys/class/net/$1/statistics/tx_packets"; }

# The daemon ---------------------------------------------------------------------------------------

# start_daemon CONFIG ARGUMENT...: starts odomd with a separate segment and sockets, and waits until
# it is ready.
start_daemon() {
  local config=$1
  shift
  odomd --config "$config" --shm /lab --status-socket "$PWD/status.sock" \
    --camera-socket "$PWD/camera.sock" "$@" 2>odomd.log &
  daemon=$!
  await 20 test -S status.sock && await 20 status '.beat.ticks > 0' -e
}

# stop_daemon: stops it; its exit status is in $daemon_status.
stop_daemon() {
  kill "$daemon" 2>/dev/null
  wait "$daemon"
  daemon_status=$?
}

# status FILTER [JQ-OPTION...]: a value of the running daemon's status.
status() {
  local filter=$1
  shift
  odom status --json --socket "$PWD/status.sock" | jq -r "$@" "$filter"
}
