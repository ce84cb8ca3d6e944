# The SocketCAN source on virtual buses: each GoogleTest case is a separate result.
. "$(dirname "$0")/../guest.sh"

program=test_socketcan_lab
if ! command -v $program >/dev/null; then
  not_ok "socketcan" "$program is not built; cmake --build --preset release"
  exit
fi
$program >output 2>&1
status=$?
sed -n 's/^\[       OK \] SocketCan\.\([A-Za-z]*\).*/\1/p' output | while read -r name; do ok "$name"; done
failures=$(sed -n 's/^\[  FAILED  \] SocketCan\.\([A-Za-z]*\) (.*/\1/p' output)
for name in $failures; do not_ok "$name" "see below"; done
[ $status = 0 ] || { cat output; [ -n "$failures" ] || not_ok "$program" "ended with status $status"; }
