#!/bin/sh
# Builds the Debian packages and checks names, contents, dependencies and configuration files.
#   check_packages.sh BUILD_DIR
set -eu
build=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

fail() {
  echo "$*" >&2
  exit 1
}

cpack --config "$build/CPackConfig.cmake" -B "$work/packages" >"$work/log" 2>&1 || fail "$(cat "$work/log")"

# package NAME: prints its file.
package() { ls "$work/packages/$1"_*.deb; }
# has NAME PATH...: the package must contain these paths.
has() {
  name=$1
  shift
  dpkg-deb -c "$(package "$name")" | awk '{print $6}' >"$work/contents"
  for path; do grep -qx "\./$path" "$work/contents" || fail "$name: no $path"; done
}
# depends NAME PACKAGE: NAME must depend on PACKAGE.
depends() { dpkg-deb -f "$(package "$1")" Depends | grep -qw "$2" || fail "$1 does not depend on $2"; }
has_sound_scripts() {
  for script in postinst prerm postrm; do
    dpkg-deb -I "$(package "$1")" "$script" | sh -n || fail "$1: $script: no shell script"
  done
}

has odomd usr/bin/odomd usr/lib/systemd/system/odomd@.service etc/odomd/can0.toml \
  usr/lib/sysusers.d/odomd.conf usr/share/odomd/odomd.dbc usr/share/doc/odomd/copyright
has libodom0 usr/lib/libodom.so.0 usr/share/doc/libodom0/copyright
has libodom-dev usr/include/odom/odom.h usr/lib/libodom.so usr/lib/pkgconfig/odom.pc
has odom-tools usr/bin/odom usr/share/odomd/foxglove-layout.json
has python3-odom usr/lib/python3/dist-packages/odom/__init__.py
# Optional programs, if built: NAME LIBRARY PACKAGE PATH...; those that need odomd are services.
while read -r name library needed paths; do
  [ -x "$build/bin/$name" ] || continue
  has "$name" "usr/bin/$name" $paths
  depends "$name" "$library"
  depends "$name" "$needed"
  [ "$needed" != odomd ] || has_sound_scripts "$name"
done <<end
odom-bridge libddsc0debian odomd usr/lib/systemd/system/odomd-bridge@.service usr/share/man/man1/odom-bridge.1
odom-web libcpp-httplib0.11 odomd usr/lib/systemd/system/odomd-web@.service usr/share/man/man1/odom-web.1
odom-track libopencv odom-tools
odom-fit liblapack3 odom-tools
end
for name in odomd odom-tools libodom0; do
  if dpkg-deb -f "$(package $name)" Depends | grep -qE "ddsc|opencv|ceres|httplib"; then fail "$name depends on DDS, OpenCV, Ceres or HTTP"; fi
done
depends odomd libsystemd0
depends odomd systemd
depends libodom-dev libodom0
depends python3-odom libodom0
depends libodom0 libc6
[ "$(dpkg-deb -f "$(package libodom0)" Depends | tr ',' '\n' | wc -l)" = 1 ] || fail "libodom0 needs more than libc"

# The unit starts the packaged program, and the user's file is kept.
dpkg-deb --fsys-tarfile "$(package odomd)" | tar -xO ./usr/lib/systemd/system/odomd@.service |
  grep -q '^ExecStart=/usr/bin/odomd ' || fail "the unit starts another program"
dpkg-deb -I "$(package odomd)" conffiles | grep -qx /etc/odomd/can0.toml || fail "can0.toml is no conffile"
has_sound_scripts odomd

# Every installed file is in exactly one package.
DESTDIR=$work/all cmake --install "$build" --prefix /usr >"$work/log"
(cd "$work/all" && find . ! -type d | sort) >"$work/installed"
for file in "$work"/packages/*.deb; do dpkg-deb -c "$file" | awk '!/^d/ {print $6}'; done | sort >"$work/packaged"
diff "$work/installed" "$work/packaged" || fail "installed (<) and packaged (>) differ"
