#!/bin/sh
# The beat must not be the first to call a function that the dynamic linker has yet to look up.
#   check_binding.sh ODOMD
set -eu
if ! readelf -d "$1" | grep -qE 'BIND_NOW|FLAGS.* NOW'; then
  echo "$1 is bound lazily: link it with -z now"
  exit 1
fi
