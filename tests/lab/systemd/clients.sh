# Clients in every language continue by themselves after a restart of the service. Each line of their
# output names the daemon whose pose they used.

begin
odom sim --scenario lap --standstill 0 --duration 8 --ideal --out path >/dev/null 2>&1
declare -A clients
start_client() { # LANGUAGE COMMAND...
  "${@:2}" --path path/truth.csv --shm $run/pose >"$1.csv" 2>"$1.err" &
  clients[$1]=$!
}
start_client C "$ODOMD_BIN_DIR/examples/stanley_c"
start_client C++ "$ODOMD_BIN_DIR/examples/stanley_cpp"
start_client Python env PYTHONPATH="$ODOMD_SOURCE_DIR/python" python3 "$ODOMD_SOURCE_DIR/examples/stanley.py"
steers_by_the_service() { tail -n 2 "$1.csv" | grep -q ",$(status .instance)$"; }
all_steer() { # NAME
  local language
  for language in "${!clients[@]}"; do
    check "$language client $1" "$(tail -n 3 "$language".csv "$language".err)" await 30 steers_by_the_service "$language"
  done
}

all_steer "steers by the pose"
await 20 settled
kill -9 "$(main_pid)"
all_steer "has gone on by itself"
for language in "${!clients[@]}"; do
  does "$language client is the one that was started" kill "${clients[$language]}"
done
