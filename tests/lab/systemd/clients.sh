# Clients in every language continue by themselves after a restart of the service. Each line of their
# output names the daemon whose pose they used.
. "$(dirname "$0")/../guest.sh"
. "$(dirname "$0")/../service.sh"

begin
odom sim --scenario lap --standstill 0 --duration 8 --ideal --out path >/dev/null 2>&1
languages=()
start_client() { # LANGUAGE COMMAND...
  local language=$1
  shift
  languages+=("$language")
  "$@" --path path/truth.csv --shm $run/pose >"$language.csv" 2>"$language.err" &
  clients+=($!)
}
clients=()
start_client C "$ODOMD_BIN_DIR/examples/stanley_c"
start_client C++ "$ODOMD_BIN_DIR/examples/stanley_cpp"
start_client Python env PYTHONPATH="$ODOMD_SOURCE_DIR/python" python3 "$ODOMD_SOURCE_DIR/examples/stanley.py"
steers_by_the_service() { tail -n 2 "$1.csv" | grep -q ",$(status .instance)$"; }
for language in "${languages[@]}"; do
  check "$language client steers by the pose" "$(tail -n 3 "$language".csv "$language".err)" \
    await 30 steers_by_the_service "$language"
done

await 20 settled
kill -9 "$(main_pid)"
for index in "${!languages[@]}"; do
  language=${languages[$index]}
  check "$language client has gone on by itself" "$(tail -n 3 "$language".csv "$language".err)" \
    await 30 steers_by_the_service "$language"
  check "$language client is the one that was started" "pid ${clients[$index]}" kill "${clients[$index]}"
  wait "${clients[$index]}"
done
end
