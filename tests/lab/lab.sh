#!/bin/bash
# A real CAN bus and a real real-time kernel on any machine: runs a script in a virtual machine.
#
#   lab.sh run [--systemd] SCRIPT [ARGUMENT...]   run it in the machine; output and exit status are
#                                                 those of SCRIPT
#   lab.sh test [TEST...]                         run tests (default: all), and count them
#
# The machine has two flavours: plain, which runs only the script, and systemd, with systemd as
# init. Tests below tests/ run in the plain one, those below systemd/ in the other, each in one boot.
#
# The machine is QEMU with Debian's PREEMPT_RT kernel and two CAN controllers, can0 and can1, on one
# wire (SJA1000; down, without a bit rate). It sees the host's files under the host's paths (writes
# stay in the machine), and the script runs there as root. It finds the tree in $ODOMD_SOURCE_DIR and
# the programs under test in $ODOMD_BIN_DIR; what it leaves in $LAB_SHARED is kept if LAB_KEEP is
# set.
#
# Environment: LAB_TIMEOUT=SECONDS for each machine (default 600), LAB_KEEP=DIRECTORY keeps the
# shared files there, ODOMD_BIN_DIR (default build/release/bin).
# If a machine does not start, panics, hangs or is too slow, the run fails with exit status 125; in
# `test` it counts as an additional failure.
set -euo pipefail

here=$(cd "$(dirname "$0")" && pwd)
tree=$(cd "$here/../.." && pwd)
cache=$tree/build/lab
bin_dir=${ODOMD_BIN_DIR:-$tree/build/release/bin}
time_limit=${LAB_TIMEOUT:-600}
lab_failed=125

usage() {
  sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "$0" >&2
  exit 2
}

# Whether this host's KVM boots the kernel, tested once per boot of the host: in some clouds
# /dev/kvm exists, but no guest ever starts.
accelerator() {
  local boot answer
  boot=$(cat /proc/sys/kernel/random/boot_id)
  answer=$cache/accelerator.$boot
  if [ ! -f "$answer" ]; then
    rm -f "$cache"/accelerator.*
    if [ -w /dev/kvm ] && timeout -k 1 10 qemu-system-x86_64 -accel kvm -cpu host -m 256 -nographic \
      -nic none -no-reboot -kernel "$cache/vmlinuz" -initrd "$cache/initramfs.gz" \
      -append "console=ttyS0 panic=-1 quiet lab.probe" </dev/null 2>&1 | grep -q 'lab: booted'; then
      echo "kvm -cpu host" >"$answer"
    else
      echo "tcg,thread=multi -cpu max" >"$answer"
    fi
  fi
  cat "$answer"
}

keep=${LAB_KEEP-}
shared= qemu= follower=
clean_up() {
  [ -z "$follower" ] || kill "$follower" 2>/dev/null || true
  [ -z "$qemu" ] || kill "$qemu" 2>/dev/null || true
  [ -z "$shared" ] || [ -n "$keep" ] || rm -rf "$shared"
  shared= qemu= follower=
}
trap clean_up EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

not_run() {
  echo "lab: $*" >&2
  if [ -s "$shared/console" ]; then
    echo "lab: the end of the machine's console:" >&2
    tail -n 60 "$shared/console" | tr -d '\033\r' | sed 's/^/  | /' >&2
  fi
  return $lab_failed
}

# share SCRIPT [ARGUMENT...]: prepares the directory that the machine and the host share.
share() {
  clean_up
  if [ -n "$keep" ]; then
    mkdir -p "$keep"
    shared=$(cd "$keep" && pwd)
    rm -f "$shared"/{status,counts}
  else
    mkdir -p "$cache"
    shared=$(mktemp -d "$cache/run.XXXXXX")
  fi
  : >"$shared/output"
  : >"$shared/console"
  {
    printf 'cd %q\n' "$PWD"
    printf 'export LAB_SHARED=/run/lab ODOMD_SOURCE_DIR=%q ODOMD_BIN_DIR=%q\n' "$tree" "$bin_dir"
    printf 'exec'
    printf ' %q' "$@"
    echo
  } >"$shared/job"
}

# boot FLAVOUR: runs the machine to its end; returns the exit status of qemu.
boot() {
  # Other work on the host must not cause missed ticks in the machine, so root raises QEMU's priority;
  # the machine's two processors are idle most of the time, which leaves enough for the host.
  local ahead=()
  chrt -r 1 true 2>/dev/null && ahead=(chrt -r 1)
  timeout -k 2 "$time_limit" "${ahead[@]}" qemu-system-x86_64 -accel $(accelerator) -smp 2 -m 1024 -nographic \
    -nic none -no-reboot -kernel "$cache/vmlinuz" -initrd "$cache/initramfs.gz" \
    -append "console=ttyS0 panic=-1 quiet lab.$1" \
    -object can-bus,id=wire -device kvaser_pci,canbus=wire -device kvaser_pci,canbus=wire \
    -virtfs local,path=/,mount_tag=host,security_model=none,readonly=on,multidevs=remap \
    -virtfs "local,path=$shared,mount_tag=lab,security_model=none" \
    </dev/null >"$shared/console" 2>&1 &
  qemu=$!
  tail -n +1 -s 0.2 -f "$shared/output" --pid=$qemu &
  follower=$!
  local status=0
  wait $qemu || status=$?
  qemu=
  wait $follower || true
  follower=
  return $status
}

# run_in_machine FLAVOUR SCRIPT [ARGUMENT...]: returns the script's exit status.
run_in_machine() {
  local flavour=$1 status=0
  shift
  share "$@"
  case $tree/ in
    /run/* | /dev/*)
      not_run "the tree must not lie under ${tree%"${tree#/*/}"}: the machine has its own"
      return
      ;;
  esac
  "$here/kernel.sh" "$cache" || return $lab_failed

  boot "$flavour" || status=$?
  # A fault of QEMU before 8.1 (see guest-init.sh), not of the tests: run the machine again.
  for _ in 1 2 3; do
    grep -aq 'Oops: int3' "$shared/console" || break
    echo "-- the machine ran into code that its kernel was patching; once more"
    share "$@"
    status=0
    boot "$flavour" || status=$?
  done
  case $status in
    0) ;;
    124) not_run "no end after $time_limit s"; return ;;
    *) not_run "qemu ended with status $status"; return ;;
  esac
  [ -f "$shared/status" ] || { not_run "the machine ended without a result"; return; }
  return "$(cat "$shared/status")"
}

# run_tests FLAVOUR TEST...: adds their results to the sums. A machine that fails is an additional failure.
passed=0
failed=0
run_tests() {
  local flavour=$1 status=0 ok bad
  keep=${LAB_KEEP:+$LAB_KEEP/$flavour}
  shift
  [ $# -gt 0 ] || return 0
  run_in_machine "$flavour" "$here/run-tests.sh" "$@" || status=$?
  if [ -s "$shared/counts" ]; then
    read -r ok bad <"$shared/counts"
  else
    echo "not ok machine: the $flavour machine ended with status $status before its tests did"
    ok=$(grep -c '^ok ' "$shared/output") || true
    bad=$(($(grep -c '^not ok ' "$shared/output") + 1)) || true
  fi
  passed=$((passed + ok))
  failed=$((failed + bad))
}

case ${1-} in
  run)
    shift
    flavour=plain
    [ "${1-}" != --systemd ] || { flavour=systemd; shift; }
    [ $# -ge 1 ] || usage
    run_in_machine "$flavour" "$@"
    ;;
  test)
    shift
    [ $# -gt 0 ] || set -- "$here"/{tests,systemd}/*.sh
    plain=() systemd=()
    for test in "$@"; do
      test=$(realpath "$test")
      case $test in
        */systemd/*) systemd+=("$test") ;;
        *) plain+=("$test") ;;
      esac
    done
    run_tests plain "${plain[@]}"
    run_tests systemd "${systemd[@]}"
    echo "lab: $passed passed, $failed failed"
    [ $failed = 0 ]
    ;;
  *) usage ;;
esac
