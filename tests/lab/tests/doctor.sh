# odom doctor and odom init on a live bus: an interface that is missing, down or silent; a sound
# car; a car whose yaw rate has the wrong sign; and a proposal from frames and database only.

# finds CODE ARGUMENT...: whether odom doctor gives this code, with exit status 1.
finds() {
  local code=$1
  shift
  odom doctor --json --config drive/car.toml "$@" >found.json 2>doctor.log
  [ $? = 1 ] && jq -e --arg code "$code" '[.parts[].diagnostics[].code] | index($code)' found.json && return
  cat found.json doctor.log >&2
  return 1
}

simulate --scenario slalom --standstill 3 --duration 15

check "finds a missing interface" "see above" finds W701 --can vcan0 --for 1
ip link add vcan0 type vcan
check "finds an interface that is down" "see above" finds W703 --can vcan0 --for 1
ip link set vcan0 mtu 72 up
check "finds a silent bus" "see above" finds W711 --can vcan0 --for 1

# while_played LOG COMMAND...: runs the command while the log is played on the bus.
while_played() {
  local log=$1 player
  shift
  canplayer -I "$log" &
  player=$!
  "$@"
  local status=$?
  reap $player
  return $status
}

# both: odom init and odom doctor in parallel, on the same frames.
both() {
  odom init --dbc drive/*.dbc --can vcan0 --for 12 --mass 3 --wheelbase 0.26 --track 0.2 \
    --out proposed.toml >init.log 2>&1 &
  local init=$!
  odom doctor --can vcan0 --for 12 --config drive/car.toml >doctor.log 2>&1
  doctor_status=$?
  wait $init
  init_status=$?
}
while_played drive.log both
check "finds nothing on a sound bus" "$(cat doctor.log)" test $doctor_status = 0
check "proposes a configuration from the live bus" "$(cat init.log)" test $init_status = 0
says "the proposal maps the gyro" '^yaw_rate = ' cat proposed.toml
does "odomd takes it" odomd --config proposed.toml --check

odom fault --config drive/car.toml --kind gyro.inverted drive.log -o inverted.log 2>/dev/null
check "finds a yaw rate of the wrong sign" "see above" \
  while_played inverted.log finds W301 --can vcan0 --for 12
check "lists what is on the bus" "$(jq -c .identifiers found.json)" \
  jq -e '.identifiers | length > 3 and all(.frames > 0)' found.json
