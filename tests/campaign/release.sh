#!/bin/bash
# Tests the output of tools/release.sh as users see it: release.sh [--twice] [DIRECTORY]
#
# On a minimal Debian 12 (mmdebstrap; arm64 under qemu): the README's steps from the packages to a
# pose in odom watch, timed; a lap; the signed apt repository; the wheel; upgrade from an older version
# and purge. The Containerfile, with podman, on a base image made here. --twice makes the release a
# second time, which must give the same checksums.
# packages.sh tests the running service with systemd. Without DIRECTORY the script makes the release
# itself, with its own signing key. Ends with a dated summary line.
set -uo pipefail
here=$(cd "$(dirname "$0")" && pwd)

# In the minimal Debian -------------------------------------------------------------------------------

listing() { find / -xdev \( -path /dev -o -path /proc -o -path /sys -o -path /tmp -o -path /dist -o -path /older \) -prune -o -print | sort; }
# Users, groups, and records of apt and dpkg remain, as usual in Debian.
left() { listing | comm -3 /tmp/before - | grep -vE '/(var/(lib/(apt|dpkg)|cache|log)|etc/(passwd|group|g?shadow|sub[ug]id)-)'; }
named() { find / -xdev -name '*odom*' ! -path '/dist/*' ! -path '/older/*' ! -path '/var/lib/dpkg/*'; }
# source_is OPTION FOLDER: makes this folder the only package source.
source_is() { echo "deb [$1] file:$2 ./" >/etc/apt/sources.list && apt-get -q update; }
as_newcomer() { runuser -u newcomer -- env HOME=/home/newcomer XDG_RUNTIME_DIR=/home/newcomer/run "$@"; }
bare() {
  export DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8 HOME=/root
  local begin seconds driver
  says "there is no compiler" '^$' sh -c 'command -v cc g++ clang'
  # Prints README's steps.
  readme() { sed -n '/^\*\*Try it now/,/^Or build/s/^    //p' /tmp/README.md; }
  useradd -m newcomer
  cd /home/newcomer && install -dm 700 -o newcomer run || return
  echo 'APT::Get::Assume-Yes "true";' >/etc/apt/apt.conf.d/yes
  begin=$SECONDS
  does "apt update" apt-get -q update
  does "README's first step installs the packages" bash -c "cd /dist; sudo() { \"\$@\"; }; $(readme | head -n 1)"
  as_newcomer bash -c "$(readme | sed '1d; /^odom watch/d')"$'\nwait' >drive.log 2>&1 &
  driver=$!
  watch_shows() {
    as_newcomer script -qec 'stty cols 100 rows 40; timeout 2 odom watch' /dev/null </dev/null >watched 2>&1
    grep -qaE "$1" watched
  }
  does "a pose in odom watch" await 120 watch_shows '[1-9][0-9]* ticks'
  seconds=$((SECONDS - begin))
  [ "$arch" != amd64 ] || [ $seconds -lt 120 ] && ok "$seconds s after the first step" || not_ok "in under two minutes" "$seconds s"
  says "odom status has it too" '^  x +-?[0-9]' as_newcomer odom status
  wait $driver && ok "the lap ends" || not_ok "the lap ends" "$(tail -n 3 ./*.log | tr '\n' ';')"
  does "it replays" odom replay --config car/car.toml --can car/drive.log --camera car/camera.csv --out pose.csv
  says "to 1 cm" 'position rms \[m\] +0\.00' odom evaluate --reference car/truth.csv --pose pose.csv --align none
  does "odomd takes the configuration that is installed" odomd --config /etc/odomd/can0.toml --check
  does "the wheel's needs" apt-get -q install --no-install-recommends python3 "/dist/libodom0_"*"_$arch.deb"
  says "the wheel finds libodom" 'StaleError|no such segment' as_newcomer env PYTHONPATH="$(echo /dist/*.whl)" \
    python3 -c 'import odom; odom.Client().latest()'

  # The folder as a repository, without network: the dependencies stay installed.
  does "purge" apt-get -q purge odomd odom-tools odom-web libodom0
  userdel -r newcomer 2>/dev/null
  says "nothing of that name is left" '^$' named
  listing >/tmp/before
  mv /etc/apt/sources.list /etc/apt/sources.list.d /tmp
  does "apt takes an older index that is trusted" source_is trusted=yes /older
  does "an older version installs" apt-get -q install odomd odom-tools libodom0
  does "apt takes the signed index" source_is signed-by=/dist/odomd-keyring.gpg /dist
  does "upgrade" apt-get -q upgrade
  says "to this version" "$(dpkg-deb -f "/dist/odomd_"*"_$arch.deb" Version)" dpkg-query -W odomd
  does "purge of everything" apt-get -q purge odomd odom-tools odom-web libodom0
  rm -f /etc/apt/sources.list
  mv /tmp/sources.list /tmp/sources.list.d /etc/apt 2>/dev/null
  says "no file is left" '^$' left
  says "nothing of that name is left" '^$' named
  echo "$arch: the end"
}
if [ "${1-}" = --in-the-bare-debian ]; then
  arch=$(dpkg --print-architecture)
  LAB_TEST="bare $arch"
  . /tmp/guest.sh
  bare
  exit
fi

# Here ---------------------------------------------------------------------------------------------
twice=
[ "${1-}" != --twice ] || { twice=yes; shift; }
dist=${1-}
. "$here/common.sh"
LAB_TEST=release
. tests/lab/guest.sh
work=$(mktemp -d "${TMPDIR:-/tmp}/odomd-release-test.XXXXXX")
chmod 755 "$work"
registered=
clean_up() {
  [ -z "$registered" ] || echo -1 >"/proc/sys/fs/binfmt_misc/qemu-aarch64"
  gpgconf --kill gpg-agent
  rm -rf "$work"
}
trap clean_up EXIT

if [ -z "$dist" ]; then
  dist=$work/dist
  export GNUPGHOME=$work/gnupg
  mkdir -m 700 "$GNUPGHOME"
  gpg --batch --quiet --passphrase '' --quick-generate-key release-test default default never 2>/dev/null
  nice tools/release.sh --sign release-test --out "$dist" >build/logs/release.log 2>&1 || { tail -n 5 build/logs/release.log; exit 1; }
  if [ -n "$twice" ]; then
    nice tools/release.sh --sign release-test --out "$work/again" >build/logs/release-again.log 2>&1
    # Signatures contain their time.
    says "the same commit gives the same sums" '^$' diff <(grep -v InRelease "$dist/SHA256SUMS") <(grep -v InRelease "$work/again/SHA256SUMS")
  fi
fi
# The older version contains the same programs.
mkdir "$work/older"
for package in "$dist"/{odomd,odom-tools,libodom0}_*.deb; do
  dpkg-deb -R "$package" "$work/unpacked" && sed -i "s/^Version: .*/Version: 0.0.9-1/" "$work/unpacked/DEBIAN/control" &&
    dpkg-deb -Zgzip -z1 -b --root-owner-group "$work/unpacked" "$work/older" >/dev/null || exit 1
  rm -r "$work/unpacked"
done
tools/release.sh --index --out "$work/older" >/dev/null || exit 1

# Makes the kernel run arm64 programs with qemu.
if [ "$(uname -m)" != aarch64 ]; then
  mountpoint -q /proc/sys/fs/binfmt_misc || mount -t binfmt_misc none /proc/sys/fs/binfmt_misc
  [ -e /proc/sys/fs/binfmt_misc/qemu-aarch64 ] ||
    { cat /usr/lib/binfmt.d/qemu-aarch64.conf >/proc/sys/fs/binfmt_misc/register && registered=yes; }
fi
on_bare_debian() { # on_bare_debian ARCH; its output comes from the hook's standard error
  mmdebstrap --quiet --format=null --variant=minbase --architectures="$1" \
    --customize-hook='mkdir "$1/dist" "$1/older"' --customize-hook="sync-in $dist /dist" \
    --customize-hook="sync-in $work/older /older" --customize-hook="copy-in $here/release.sh $PWD/tests/lab/guest.sh $PWD/README.md /tmp" \
    --customize-hook='chroot "$1" bash /tmp/release.sh --in-the-bare-debian' bookworm /dev/null 2>&1
}
container() {
  LAB_TEST=container
  # The same image as on Docker Hub, made from Debian's packages.
  podman image exists docker.io/library/debian:bookworm-slim ||
    mmdebstrap --quiet --variant=minbase bookworm - | podman import --quiet - docker.io/library/debian:bookworm-slim >/dev/null
  mkdir -p "$work/context" && cp -r "$dist" "$work/context/dist"
  local build=(podman build --isolation=chroot --pull=never --quiet -f Containerfile)
  does "the tools are built" "${build[@]}" --target tools --tag odom-test "$work/context"
  does "the daemon is built" "${build[@]}" --tag odomd-test "$work/context"
  # Limits that any host can set. runc, if installed, also works on hosts with both versions of
  # control groups.
  local run=(podman run --rm --interactive --network host --ipc host --user 1234 --ulimit nofile=1024:1024
    --ulimit nproc=1024:1024 --volume "$work/car:/etc/odomd" --volume "$work/run:/run/odomd")
  ! command -v runc >/dev/null || run+=(--runtime runc)
  mkdir "$work/car" "$work/run" && chown 1234 "$work/car" "$work/run"
  local sim=("${run[@]}" odom-test sim --laps 1 --can - --camera-socket /run/odomd/camera.sock --out /etc/odomd --force)
  does "odom sim writes the configuration" "${sim[@]}" --config-only
  cp "$work/car/car.toml" "$work/car/can0.toml"
  does "odomd takes it" "${run[@]}" odomd-test --check
  "${sim[@]}" --live 2>"$work/sim.log" </dev/null | "${run[@]}" odomd-test --can - --shm /odom-$$ --exit-at-end 2>"$work/odomd.log" &
  says "a pose in another container" 'x +-?[0-9]' "${run[@]}" odom-test pose --wait 60 --shm /odom-$$
  says "and its status" '^  x +-?[0-9]' "${run[@]}" odom-test status
  wait $! && ok "the lap ends" || not_ok "the lap ends" "$(tail -n 3 "$work/sim.log" "$work/odomd.log" | tr '\n' ';')"
  does "with camera poses" grep -q 'a camera process connected' "$work/odomd.log"
  podman rmi --force odom-test odomd-test >/dev/null 2>&1
}

log=build/logs/release-test.log
{
  does "the sums are right" sh -c "cd '$dist' && sha256sum --quiet -c SHA256SUMS"
  for arch in amd64 arm64; do
    ! ls "$dist"/odomd_*_$arch.deb >/dev/null 2>&1 || on_bare_debian $arch
  done
  container
} | tee "$log"
passed=$(grep -c '^ok ' $log)
failed=$(grep -c '^not ok ' $log)
echo "$(date -u +%F) release: $passed passed, $failed failed in $((SECONDS - begin)) s"
[ "$passed" -ge 30 ] && [ "$failed" = 0 ] && [ "$(grep -c ': the end$' "$log")" = "$(ls "$dist"/odomd_*.deb | wc -l)" ]
