#!/bin/bash
# Makes the files of a release from the last commit, for Debian 12.
#
#   tools/release.sh [--arch LIST] [--sign KEY] [--out DIRECTORY] [--index]
#
#   --arch LIST       architectures of the packages: amd64, arm64 or both (default amd64,arm64)
#   --sign KEY        sign the package index with this gpg key (default: unsigned)
#   --out DIRECTORY   folder for the files (default dist); an earlier release there is replaced
#   --index           only index the packages in DIRECTORY, after adding some, or to sign later
#   --help            print this help
#
#   tools/release.sh
#   tools/release.sh --arch arm64 --sign release@example.org --out /srv/odomd
#
# DIRECTORY is also an apt repository. It contains the source (.orig.tar.xz, as committed), the Debian source package, the
# packages, the client as a Python wheel, and SHA256SUMS. The same commit gives the same sums, except for the signature.
#
# The packages are built from the source package in a fresh Debian 12 below $TMPDIR (about 3 GB), with mmdebstrap and
# without changes to this machine; arm64 is cross-built. This needs root or user namespaces, and a Debian mirror.
# A commit without the tag of its version (v0.1.0) gets an earlier version: 0.1.0~202611261713.4d629c15.
# ODOMD_CCACHE=DIRECTORY keeps compiled files there for the next build.
set -euo pipefail
cd "$(dirname "$0")/.."

help() { sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' tools/release.sh; }
wrong() {
  echo "release: $*; see tools/release.sh --help" >&2
  exit 2
}

archs=amd64,arm64 key= out=dist only_index=
while [ $# -gt 0 ]; do
  case $1 in
    --help) help; exit ;;
    --index) only_index=yes; shift; continue ;;
    --arch | --sign | --out) [ -n "${2-}" ] || wrong "$1 needs a value" ;;&
    --arch) archs=$2 ;;
    --sign) key=$2 ;;
    --out) out=$2 ;;
    *) wrong "unknown argument '$1'" ;;
  esac
  shift 2
done
IFS=, read -r -a archs <<<"$archs"
for arch in "${archs[@]}"; do
  case $arch in amd64 | arm64) ;; *) wrong "--arch '$arch': amd64 and arm64 are possible" ;; esac
done
[ -n "$only_index" ] || [ ! -e "$out" ] || [ -f "$out/SHA256SUMS" ] || [ -z "$(ls -A "$out")" ] ||
  wrong "$out has files, but is not a release: name another --out"
tools/dependencies.sh release
[ -z "$key" ] || gpg --list-secret-keys "$key" >/dev/null 2>&1 || wrong "--sign: gpg has no secret key '$key'"
[ -n "$only_index" ] || git diff --quiet HEAD || echo "release: HEAD is released: uncommitted changes are not included" >&2

say() { echo "=== $*"; }

# index DIRECTORY: makes it an apt repository, with the sums of all its files. Dated by SOURCE_DATE_EPOCH.
index() (
  cd "$1"
  rm -f Packages Packages.gz Sources Sources.gz Release InRelease odomd-keyring.gpg SHA256SUMS
  release=$(mktemp)
  trap 'rm -f "$release"' EXIT
  apt-ftparchive -qq packages . >Packages
  apt-ftparchive -qq sources . >Sources
  gzip -9nk Packages Sources
  apt-ftparchive -qq -o APT::FTPArchive::Release::Origin=odomd -o APT::FTPArchive::Release::Suite=bookworm \
    -o APT::FTPArchive::Release::Architectures="amd64 arm64" release . |
    sed "s/^Date: .*/Date: $(date -R -u -d "@$SOURCE_DATE_EPOCH")/" >"$release"
  cat "$release" >Release
  [ -z "$key" ] || {
    gpg --export "$key" >odomd-keyring.gpg
    gpg --batch --yes --local-user "$key" --clearsign --output InRelease Release
  }
  find . -maxdepth 1 -type f -printf '%P\0' | sort -z | xargs -0 sha256sum -- >"$release"
  cat "$release" >SHA256SUMS
)
if [ -n "$only_index" ]; then
  ls "$out"/*.deb >/dev/null 2>&1 || wrong "--index: $out has no packages"
  export SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(date +%s)}
  index "$out"
  say "$out: an apt repository$([ -n "$key" ] || echo ", unsigned")"
  exit
fi

version=$(sed -n 's/^project(odomd VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
[ "$(git tag --points-at HEAD --list "v$version")" ] ||
  version+=$(TZ=UTC git log -1 --abbrev=8 --date=format-local:%Y%m%d%H%M --format=\~%cd.%h)
SOURCE_DATE_EPOCH=$(git log -1 --format=%ct)
export SOURCE_DATE_EPOCH TZ=UTC
native=$(dpkg --print-architecture)

umask 022
mkdir -p "$(dirname "$out")"
new=$(mktemp -d "$out.XXXXXX")
work=$(mktemp -d "${TMPDIR:-/tmp}/odomd-release.XXXXXX")
trap 'rm -rf "$new" "$work"' EXIT
chmod 755 "$new" "$work"

say "source of $version"
source=$work/source
tree=$work/odomd-$version
git archive --prefix="odomd-$version/" HEAD | xz -T1 >"$new/odomd_$version.orig.tar.xz"
tar -C "$work" -xf "$new/odomd_$version.orig.tar.xz"
cat >"$tree/debian/changelog" <<end
odomd ($version-1) bookworm; urgency=medium

  * As committed: CHANGELOG.md says what is new.

 -- odomd developers <odomd@example.org>  $(date -R -d "@$SOURCE_DATE_EPOCH")
end
(cd "$new" && dpkg-source -b "$tree")
mkdir "$source"
cp "$new"/* "$source"

# mmdebstrap calls this script with its root directory. The mount of the cache ends with the script's namespace, so
# removing the root directory does not empty the cache.
cat >"$work/compile" <<'end'
#!/bin/bash
set -e
[ -z "${ODOMD_CCACHE-}" ] || { mkdir -p "$ODOMD_CCACHE" "$1/ccache" && mount --bind "$ODOMD_CCACHE" "$1/ccache"; }
chroot "$1" sh /build/build.sh
end
chmod +x "$work/compile"

# build ARCH: builds the packages in a fresh Debian; the first architecture also builds the packages of `all`.
build() {
  local cross= include=(${ODOMD_CCACHE:+--include=ccache})
  [ "$1" = "$native" ] || { cross="-a $1" && include+=("--include=crossbuild-essential-$1"); }
  cat >"$source/build.sh" <<end
set -e
unset LC_ALL
export LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive DEB_BUILD_OPTIONS="parallel=$(nproc) nocheck"
[ ! -d /ccache ] || export CMAKE_C_COMPILER_LAUNCHER=ccache CMAKE_CXX_COMPILER_LAUNCHER=ccache CCACHE_DIR=/ccache \
  CCACHE_BASEDIR=/build CCACHE_NOHASHDIR=1
apt-get -q build-dep -y --no-install-recommends $cross /build/*.dsc
cd /build
dpkg-source -x ./*.dsc tree
cd tree
dpkg-buildpackage -us -uc $([ "$1" = "${archs[0]}" ] && echo -b || echo -B) $cross
mkdir /build/packages
mv /build/*.deb /build/packages
end
  mmdebstrap --format=null --variant=buildd --dpkgopt=force-unsafe-io --architectures="$(printf '%s\n' "$native" "$1" | uniq | paste -sd,)" \
    "${include[@]}" --customize-hook='mkdir "$1/build"' --customize-hook="sync-in $source /build" \
    --customize-hook="unshare -m $work/compile \"\$1\"" --customize-hook="sync-out /build/packages $new" \
    bookworm /dev/null
}
for arch in "${archs[@]}"; do
  say "packages for $arch"
  build "$arch"
done

say "Python wheel"
/usr/bin/python3 -P -m build --wheel --no-isolation --outdir "$new" "$tree/python"

say "apt repository"
index "$new"

# Removes only those files of an earlier release that its SHA256SUMS lists.
if [ -f "$out/SHA256SUMS" ]; then
  (cd "$out" && sed 's/^[^ ]*  //' SHA256SUMS | xargs -d '\n' rm -f -- SHA256SUMS)
fi
mkdir -p "$out"
mv "$new"/* "$out"
say "$out: $(ls "$out" | wc -l) files$([ -n "$key" ] || echo ", unsigned")"
