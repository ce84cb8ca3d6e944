#!/bin/sh
# Installs the Debian packages that odomd needs: dependencies.sh build | test | campaign | bench |
# aarch64 | release
#
#   build     to compile and install the programs, except odom-track (libopencv-dev) and
#             odom-fit (libceres-dev)
#   test      build, and for the test command (GoogleTest, can-utils, the lab's machine)
#   campaign  test, and for the campaigns (clang, clang-tidy)
#   bench     build, and for the benchmarks and their comparison (cyclictest, iceoryx)
#   aarch64   test, and the cross compiler and emulator for 64-bit ARM
#   release   for tools/release.sh, which installs build dependencies in a separate root directory
#
# If everything is installed, it prints nothing and needs neither network nor root.
set -eu

build='g++ cmake ninja-build pkg-config libeigen3-dev libspdlog-dev libtomlplusplus-dev libcli11-dev
  libsystemd-dev libsocketcan-dev file dpkg-dev nlohmann-json3-dev librsvg2-bin
  zlib1g-dev libzstd-dev cyclonedds-dev cyclonedds-tools libcpp-httplib-dev'
release='apt-utils dpkg-dev git gpg gpg-agent mmdebstrap python3-build python3-setuptools python3-wheel util-linux
  xz-utils'
test="$build $release libopencv-dev libceres-dev libapriltag-dev libgtest-dev libgmock-dev clang-format can-utils mandoc
  iproute2 openssl rt-tests systemd udev jq strace python3 qemu-system-x86 busybox-static cpio kmod v4l-utils"
campaign="$test clang-16 clang-tidy-16 libclang-rt-16-dev libbenchmark-dev jq mypy dbus libfastrtps-dev chromium
  fonts-dejavu-core imagemagick python3-pil python3-prometheus-client python3-pyte python3-websocket qemu-user-static
  podman runc"
bench="$build libbenchmark-dev rt-tests libiceoryx-posh-dev iceoryx python3"
aarch64="$test g++-aarch64-linux-gnu qemu-user"

case ${1-} in
  build) wanted=$build ;;
  test) wanted=$test ;;
  campaign) wanted=$campaign ;;
  bench) wanted=$bench ;;
  aarch64) wanted=$aarch64 ;;
  release) wanted=$release ;;
  *) echo "usage: dependencies.sh build | test | campaign | bench | aarch64 | release" >&2; exit 2 ;;
esac

if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
  echo "dependencies.sh: this is not Debian (no dpkg and apt-get): install by hand what matches" \
    $wanted >&2
  exit 1
fi

missing=
for package in $wanted; do
  state=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null) || state=
  [ "$state" = installed ] || missing="$missing $package"
done
[ -n "$missing" ] || exit 0

as_root=
if [ "$(id -u)" != 0 ]; then
  as_root=sudo
  command -v sudo >/dev/null || {
    echo "dependencies.sh: neither root nor sudo; as root run: apt-get install$missing" >&2
    exit 1
  }
fi

echo "installing$missing"
export DEBIAN_FRONTEND=noninteractive
# If the mirror cannot be reached, the existing package lists may be sufficient.
$as_root apt-get -q update || echo "dependencies.sh: apt-get update failed, continuing" >&2
$as_root env DEBIAN_FRONTEND=noninteractive \
  apt-get -q install -y --no-install-recommends $missing </dev/null || {
  echo "dependencies.sh: apt-get could not install$missing" >&2
  exit 1
}
