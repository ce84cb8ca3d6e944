# The commands for the service in docs/dev/security.md, for this machine's bus instead of can0.

begin
# Three users: one in no group of the service, one in the readers' group, one in the camera's.
for user in user reader camera; do systemd-sysusers --inline "u $user - - -" 2>/dev/null; done
systemd-sysusers --inline "m reader odom" "m camera odomd-camera"
check "has a pose to show" "$(status .mode)" await 20 settled

sed "s/can0/$bus/g" "$ODOMD_SOURCE_DIR/docs/dev/security.md" >security.md
"$ODOMD_SOURCE_DIR/tests/docs/shown_commands.py" security.md service || test_failed=1
