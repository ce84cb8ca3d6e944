#!/bin/sh
# odomd must be linked so that the beat never waits for the dynamic linker to look up a function.
#   check_binding.sh ODOMD
set -eu
if ! readelf -d "$1" | grep -qE 'BIND_NOW|FLAGS.* NOW'; then
  echo "$1 is bound lazily: link it with -z now"
  exit 1
fi
