#!/bin/bash
# The unit tests for 64-bit ARM: cross-built with Debian's compiler, run under qemu-aarch64 in user
# mode. Ends with a dated summary line.
#
# The arm64 libraries are Debian packages, unpacked into build/aarch64/sysroot. apt uses
# separate directories for this, so that this machine's package lists and architectures do not change.
needs=aarch64
. "$(dirname "$0")/common.sh"
root=$PWD/build/aarch64
sysroot=$root/sysroot
libraries=(libc6 libstdc++6 libspdlog-dev libfmt-dev libsystemd-dev libsocketcan-dev libgtest-dev
  libgmock-dev libeigen3-dev libcli11-dev libtomlplusplus-dev nlohmann-json3-dev zlib1g-dev libzstd-dev)
mkdir -p "$root"

# private_apt ARGUMENT...: apt-get for arm64, with an empty list of installed packages.
private_apt() {
  apt-get -q -o APT::Architecture=arm64 -o APT::Architectures=arm64 -o APT::Sandbox::User=root \
    -o Dir::State="$root/apt" -o Dir::State::status="$root/apt/status" -o Dir::Cache="$root/apt" "$@"
}

make_sysroot() {
  mkdir -p "$root/apt/lists/partial" "$root/apt/archives/partial" "$sysroot" && : >"$root/apt/status" &&
    private_apt update &&
    private_apt install -y --download-only --no-install-recommends "${libraries[@]}" || return 1
  local package
  for package in "$root"/apt/archives/*.deb; do
    dpkg -x "$package" "$sysroot" || return 1
  done
  rm -r "$root/apt"
  printf '%s\n' "${libraries[@]}" >"$sysroot/packages"
}

if ! printf '%s\n' "${libraries[@]}" | cmp -s - "$sysroot/packages"; then
  rm -rf "$sysroot"
  make_sysroot >build/logs/aarch64-sysroot.log 2>&1 || { tail -n 5 build/logs/aarch64-sysroot.log; exit 1; }
fi

# The kernel cannot run the programs directly, so tests start them through a script that runs the
# emulator.
wrap_programs() {
  local program
  mkdir -p "$root/programs"
  for program in "$root"/tree/bin/*; do
    printf '#!/bin/sh\nexec qemu-aarch64 -L %s %s "$@"\n' "$sysroot" "$program" \
      >"$root/programs/${program##*/}" && chmod +x "$root/programs/${program##*/}" || return 1
  done
}

# These may fail: a user-mode emulator cannot run them.
not_emulated=(
  # qemu lacks SO_TIMESTAMPING, the kernel's receive stamps
  FrameReceiverTest.StampsFramesOnTheMonotonicClock
  FrameReceiverTest.FallsBackIfAStampIsMissing
  FrameReceiverTest.CarriesOverFramesThatDoNotFit
  FrameReceiverTest.CountsFramesThatTheKernelDropped
  # if a signal kills the program, qemu writes an additional line to its terminal
  WatchCommand.GivesTheTerminalBackOnASignalAndInACrash
)

log=$PWD/build/logs/aarch64.log
junit=$PWD/build/logs/aarch64.xml
failures=$root/tree/Testing/Temporary/LastTestsFailed.log
build() {
  cmake -G Ninja -B "$root/tree" -DCMAKE_BUILD_TYPE=Release -DODOMD_TESTS=ON \
    -DCMAKE_TOOLCHAIN_FILE=cmake/aarch64-linux-gnu.cmake -DODOMD_SYSROOT="$sysroot" \
    -DODOMD_TEST_PROGRAMS="$root/programs" &&
    cmake --build "$root/tree" -j "$(nproc)" && wrap_programs
}
build 2>&1 | tee "$log"
[ "${PIPESTATUS[0]}" = 0 ] || { echo "$(date -u +%F) aarch64: did not build"; exit 1; }
names=$(ctest --test-dir "$root/tree" -N)
for name in "${not_emulated[@]}"; do
  grep -q ": $name\$" <<<"$names" || { echo "aarch64.sh: there is no test $name: correct not_emulated"; exit 1; }
done
rm -f "$failures" "$junit"
# Some tests need a daemon that keeps real time, which may fail under a loaded emulator: repeat them
# up to twice.
ctest --test-dir "$root/tree" --progress --output-on-failure --output-junit "$junit" -j "$(nproc)" \
  --repeat until-pass:3 2>&1 | tee -a "$log"

total=$(sed -n '/<testsuite /,/>/s/.*[ \t]tests="\([0-9]*\)".*/\1/p' "$junit" | head -n 1)
failed=$(sed 's/^[0-9]*://' "$failures" 2>/dev/null | sort)
unexpected=$(comm -23 <(echo "$failed") <(printf '%s\n' "${not_emulated[@]}" | sort) | sed '/^$/d')
excused=$(comm -12 <(echo "$failed") <(printf '%s\n' "${not_emulated[@]}" | sort) | sed '/^$/d' | wc -l)
bad=$(printf '%s' "$unexpected" | grep -c .)
[ -z "$unexpected" ] || sed 's/^/failed: /' <<<"$unexpected"
echo "$(date -u +%F) aarch64: ${total:-0} tests, $bad failed, $excused that user mode cannot run;" \
  "$((SECONDS - begin)) s"
[ "${total:-0}" != 0 ] && [ "$bad" = 0 ]
