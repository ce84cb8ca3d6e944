#!/bin/sh
# The shared client library: it depends on libc and libm only, its soname is libodom.so.0, and it
# exports exactly the functions of odom.h.
#   check_library.sh LIBODOM.SO ODOM.H
set -eu
library=$1 header=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

readelf -d "$library" >"$work/dynamic"
grep -q 'SONAME.*\[libodom\.so\.0\]' "$work/dynamic"
if grep NEEDED "$work/dynamic" | grep -vE '\[(libc|libm)\.so\.6\]'; then
  echo "$library needs more than libc and libm"
  exit 1
fi

nm -D --defined-only "$library" | awk '$2 == "T" { sub(/@.*/, "", $3); print $3 }' | sort >"$work/exported"
sed -n 's/^[a-z].*[ *]\(odom_[a-z_]*\)(.*/\1/p' "$header" | grep -v odom_view_ |
  grep -vx odom_validate | sort >"$work/declared"
diff "$work/declared" "$work/exported"
