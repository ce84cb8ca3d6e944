#!/bin/sh
# Installs the service into a directory and checks the result: units that systemd accepts, with a
# low exposure, a configuration that odomd accepts, and unchanged user files.
#   check_installed.sh BUILD_DIR
set -eu
build=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
root=$work/root
unit=$root/usr/lib/systemd/system/odomd@.service

fail() {
  echo "$*" >&2
  exit 1
}
# is_sound UNIT: systemd's own checks of a unit. Exposure in tenths: at most 2.0.
is_sound() {
  systemd-analyze verify --man=no "$1" >"$work/verify" 2>&1 && [ ! -s "$work/verify" ] ||
    fail "systemd-analyze verify: $(cat "$work/verify")"
  systemd-analyze security --offline=true --threshold=20 --no-pager "$1" >"$work/security" 2>&1 ||
    fail "$(cat "$work/security")"
  tail -n 1 "$work/security"
}
installed() { DESTDIR=$root cmake --install "$build" --prefix /usr --component daemon >"$work/log"; }

installed
for file in etc/odomd/can0.toml usr/bin/odomd usr/share/odomd/odomd.dbc \
  usr/lib/systemd/system/odomd@.service usr/lib/sysusers.d/odomd.conf usr/lib/tmpfiles.d/odomd.conf \
  usr/lib/sysctl.d/50-odomd.conf usr/lib/udev/rules.d/60-odomd.rules \
  usr/lib/systemd/network/80-can0.network.example \
  usr/lib/systemd/network/80-can0-fd.network.example; do
  [ -f "$root/$file" ] || fail "$file is not installed"
done
grep -q '^ExecStart=/usr/bin/odomd --config /etc/odomd/%i.toml ' "$unit" || fail "unit: other paths"
if grep -E '@[A-Za-z_]+@' "$unit" "$root/etc/odomd/can0.toml"; then fail "a path was not filled in"; fi

# The user's file is kept.
echo '# mine' >>"$root/etc/odomd/can0.toml"
installed
grep -qx '# mine' "$root/etc/odomd/can0.toml" || fail "an installation overwrote can0.toml"

# With another prefix, all files lie below it, and the unit refers to it.
cmake --install "$build" --prefix "$work/opt" --component daemon >"$work/log"
[ -f "$work/opt/etc/odomd/can0.toml" ] || fail "prefix: no can0.toml"
own=$work/opt/lib/systemd/system/odomd@.service
grep -q "^ExecStart=$work/opt/bin/odomd --config $work/opt/etc/odomd/%i.toml " "$own" ||
  fail "prefix: the unit names other paths"
"$work/opt/bin/odomd" --config "$work/opt/etc/odomd/can0.toml" --check >"$work/check" ||
  fail "odomd does not take its example"
if grep -q '^warnings' "$work/check"; then fail "$(cat "$work/check")"; fi

is_sound "$own"

# The bridge and the page, if built.
for part in bridge web; do
  [ -x "$build/bin/odom-$part" ] || continue
  cmake --install "$build" --prefix "$work/opt" --component $part >"$work/log"
  own=$work/opt/lib/systemd/system/odomd-$part@.service
  grep -q "^ExecStart=$work/opt/bin/odom-$part .*--shm %t/odomd/%i/pose " "$own" ||
    fail "the unit of odom-$part names other paths"
  is_sound "$own"
done

# Creates the user and the groups in the directory.
mkdir -p "$root/etc"
systemd-sysusers --root="$root" "$root/usr/lib/sysusers.d/odomd.conf" >"$work/log" 2>&1 ||
  fail "systemd-sysusers: $(cat "$work/log")"
grep -q '^odomd:' "$root/etc/passwd" || fail "no user odomd"
for group in odomd odom odomd-camera; do
  grep -q "^$group:" "$root/etc/group" || fail "no group $group"
done
