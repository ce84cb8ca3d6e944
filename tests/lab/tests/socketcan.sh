# The SocketCAN source on virtual buses: each GoogleTest case is a separate result.

test_socketcan_lab >output 2>&1
status=$?
sed -nE 's/^\[ +OK \] SocketCan\.([A-Za-z]*).*/\1/p' output | while read -r name; do ok "$name"; done
for name in $(sed -n 's/^\[  FAILED  \] SocketCan\.\([A-Za-z]*\) (.*/\1/p' output); do not_ok "$name" "see below"; done
[ $status = 0 ] || { cat output; [ $test_failed = 1 ] || not_ok "test_socketcan_lab" "ended with status $status"; }
