# The services of page and daemon together, with the whole sandbox: the page shows the daemon's
# poses, cannot write to its segment, survives a restart of the daemon, requires the token from
# other machines, and ends cleanly.
web=odomd-web@$bus.service

begin
: >events
ip link set lo up
# page PATH [HEADER]: prints the whole answer; from a stream, the data of three seconds.
page() {
  exec 3<>/dev/tcp/127.0.0.1/9880 || return
  printf 'GET %s HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n%s\r\n' "$1" "${2:+$2$'\r\n'}" >&3
  timeout 3 cat <&3 | tr -d '\r'
  exec 3>&-
}
has() { grep -q -- "$1" <<<"$(page "${@:2}")"; }
# live: whether the stream has poses of the running daemon.
live() {
  page /events >events
  sed -n 's/^data: \({"n".*\)/\1/p' events | tail -n 1 | jq -e '.live and .row[5] > 0.1'
}

says "it is off until somebody enables it" '^disabled' systemctl is-enabled $web
does "it starts" systemctl start $web
check "it serves the page" "$(journal $web)" await 30 has '<title>' /
check "with the pose" "$(journal $web; tail -c 300 events)" await 60 live
check "and the metrics" "$(journal $web)" await 30 has '^odom_up.* 1$' /metrics

pid=$(main_pid $web)
rights=$(awk -v file="$run/pose" '$NF == file {print $2}' "/proc/$pid/maps" | sort -u)
check "it maps the segment, and only to read" "$rights" test "$rights" = r--s
is_nobodys $web

systemctl stop $unit
check "without the daemon it says so" "$(journal $web)" await 30 has '^odom_up.* 0$' /metrics
systemctl start $unit
check "it goes on with the next one" "$(journal; journal $web; tail -c 300 events)" await 60 live
kill -9 "$(main_pid)"
await 60 settled
check "and with the one after a crash" "$(journal $web; tail -c 300 events)" await 60 live
says "and is the one that was started" "^$pid\$" main_pid $web

# For access from a phone, as in docs/web.md.
token=0123456789abcdef-lab
(umask 077; echo $token >/etc/odomd/web-token)
drop_in $web "$(sed -n '/^As a service/,/^    sudo systemctl enable/s/^      //p' "$ODOMD_SOURCE_DIR/docs/web.md")"
systemctl restart $web
check "another machine needs the token" "$(journal $web)" await 30 has '^HTTP/1.1 401' /
check "and is served with it" "$(journal $web)" await 30 has '^HTTP/1.1 200' /metrics "Authorization: Bearer $token"
check "which nobody sees in its arguments" "$(journal $web)" \
  test -z "$(grep -la "$token" "/proc/$(main_pid $web)/"{cmdline,environ})"

exec 4<>/dev/tcp/127.0.0.1/9880
printf 'GET /events HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer %s\r\n\r\n' "$token" >&4
check "a viewer looks on" "$(journal $web)" grep -q -m1 '^data' <&4
systemctl stop $web
says "its end is no failure, nor waits for the viewer" '^success$' systemctl show -P Result $web
drop_in $web
