#!/bin/sh
# Fetches Debian's PREEMPT_RT kernel and builds its initramfs, once: kernel.sh DIRECTORY
#
# The package is downloaded and unpacked, not installed. DIRECTORY then contains `vmlinuz`,
# `initramfs.gz` and `release` (the kernel's version).
set -eu

here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$1"
directory=$(cd "$1" && pwd)
export PATH="$PATH:/usr/sbin:/sbin"

# The modules that the guest loads; modprobe resolves their dependencies.
modules='9pnet_virtio 9p overlay
  can can-raw can-bcm can-gw can-dev vcan vxcan slcan sja1000 kvaser_pci'

fail() {
  echo "lab: $*" >&2
  exit 1
}

# The package that the metapackage depends on: linux-image-6.12-rt-amd64 ->
# linux-image-6.12.117+deb12-rt-amd64
kernel_package() {
  for meta in linux-image-6.12-rt-amd64 linux-image-rt-amd64; do
    package=$(apt-cache depends "$meta" 2>/dev/null | sed -n 's/^ *Depends: \(linux-image-.*\)/\1/p')
    [ -z "$package" ] || { echo "$package"; return; }
  done
}

download() {
  rm -f ./*.deb
  package=$(kernel_package)
  [ -n "$package" ] && apt-get -q -o APT::Sandbox::User=root download "$package" >&2 && ls ./*.deb
}

fetch_kernel() {
  [ "$(dpkg --print-architecture)" = amd64 ] ||
    fail "the lab's machine is an amd64 one, and runs the programs of an amd64 host only"
  cd "$directory"
  # Missing or old package lists contain no package, or one that the mirror has replaced.
  if ! package_file=$(download); then
    as_root=; [ "$(id -u)" = 0 ] || as_root=sudo
    $as_root apt-get -q update >&2 || true
    package_file=$(download) || fail "cannot download Debian's PREEMPT_RT kernel; see above"
  fi
  rm -rf unpacked
  dpkg -x "$package_file" unpacked
  rm -f ./*.deb
  # Debian 12 keeps the modules under /lib; busybox and depmod look there as well.
  [ -d unpacked/lib/modules ] || ln -s usr/lib unpacked/lib
  release=$(ls unpacked/lib/modules)
  cp "unpacked/boot/vmlinuz-$release" vmlinuz
  depmod -b unpacked "$release"
  echo "$release" >release.tmp && mv release.tmp release
}

build_initramfs() {
  cd "$directory"
  release=$(cat release)
  rm -rf initramfs && mkdir -p initramfs/bin initramfs/modules
  cp "$(command -v busybox)" initramfs/bin/busybox
  cp "$here/guest-init.sh" initramfs/init
  cp "$here/guest-systemd.sh" initramfs/systemd.sh
  chmod 755 initramfs/init
  for module in $modules; do
    modprobe -d unpacked -S "$release" --show-depends "$module" || fail "no module $module in $release"
  done | awk '$1 == "insmod" && !seen[$2]++ {print $2}' | while read -r path; do
    name=$(basename "$path")
    case $name in
      *.xz) xz -dc "$path" >"initramfs/modules/${name%.xz}" ;;
      *) cp "$path" initramfs/modules/ ;;
    esac
    echo "${name%.xz}" >>initramfs/modules/order
  done
  (cd initramfs && find . | cpio -o -H newc -R 0:0 --quiet) | gzip -1 >initramfs.tmp
  mv initramfs.tmp initramfs.gz
  rm -rf initramfs
}

# Two concurrent runs share one cache.
exec 9>"$directory/lock"
flock 9
[ -f "$directory/release" ] || fetch_kernel
stamp=$(cat "$directory/release" "$0" "$here/guest-init.sh" "$here/guest-systemd.sh" | cksum)
if [ ! -f "$directory/initramfs.gz" ] || [ "$(cat "$directory/stamp" 2>/dev/null)" != "$stamp" ]; then
  build_initramfs
  echo "$stamp" >"$directory/stamp"
fi
