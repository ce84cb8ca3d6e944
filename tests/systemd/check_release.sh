#!/bin/sh
# Checks tools/release.sh without its builds (for these see tests/campaign/release.sh): which options
# it refuses, that apt accepts the index only with its signature, and the contents of the source package.
#   check_release.sh SOURCE_DIR
set -eu
source=$1
work=$(mktemp -d)
trap 'gpgconf --kill gpg-agent 2>/dev/null || :; rm -rf "$work"' EXIT
export GNUPGHOME="$work/gnupg" SOURCE_DATE_EPOCH=1700000000
repository="$work/a folder"
mkdir -m 700 "$GNUPGHOME" "$work/mine" "$repository" "$work/empty"
echo kept | tee "$work/mine/file" >"$repository/Packages.old"

fail() {
  echo "$*" >&2
  exit 1
}
release() { "$source/tools/release.sh" "$@" >"$work/said" 2>&1; }
index() { release --index --out "$repository" "$@" || fail "$(cat "$work/said")"; }
# refuses MESSAGE ARGUMENT...: release.sh must say MESSAGE and exit with the status for wrong usage.
refuses() {
  message=$1
  shift
  status=0
  release "$@" || status=$?
  [ $status = 2 ] && grep -qF -- "$message" "$work/said" || fail "release.sh $*: status $status: $(cat "$work/said")"
}

release --help || fail "no help"
for option in arch sign out index help; do grep -q "^  --$option " "$work/said" || fail "--help has no --$option"; done
refuses "--arch 'riscv': amd64 and arm64 are possible" --arch amd64,riscv
refuses "--arch needs a value" --arch
refuses "--out needs a value" --out ""
refuses "unknown argument 'arm64'" arm64
refuses "gpg has no secret key 'nobody'" --sign nobody --out "$work/none"
refuses "has files, but is not a release" --out "$work/mine"
refuses "has no packages" --index --out "$work/mine"

mkdir -p "$work/package/DEBIAN"
for version in 1 2; do
  printf '%s\n' "Package: dummy" "Version: $version" "Architecture: all" "Maintainer: A <a@example.org>" \
    "Description: none" >"$work/package/DEBIAN/control"
  dpkg-deb --root-owner-group -b "$work/package" "$repository" >/dev/null
done
index
cp "$repository/SHA256SUMS" "$work/first"
index
cmp "$repository/SHA256SUMS" "$work/first" || fail "two runs give different sums"
(cd "$repository" && sha256sum --quiet -c SHA256SUMS) || fail "the sums are wrong"
[ "$(cat "$repository/Packages.old" "$work/mine/file")" = "kept
kept" ] || fail "a foreign file was changed"

# apt_takes OPTION: whether apt-get update, with private directories, finds the newer package.
apt_takes() {
  rm -rf "$work/apt"
  mkdir -p "$work/apt/lists/partial" "$work/apt/archives/partial"
  : >"$work/apt/status"
  echo "deb [$1] copy:$work/a%20folder ./" >"$work/sources"
  set -- -o Dir::State="$work/apt" -o Dir::State::status="$work/apt/status" -o Dir::Cache="$work/apt" \
    -o Dir::Etc::sourcelist="$work/sources" -o Dir::Etc::sourceparts="$work/empty" -o APT::Sandbox::User=
  apt-get -q "$@" update >"$work/said" 2>&1 && apt-cache "$@" policy dummy | grep -q 'Candidate: 2'
}
apt_takes trusted=yes || fail "apt refuses the index: $(cat "$work/said")"
gpg --batch --quiet --passphrase '' --quick-generate-key signer default default never 2>/dev/null
index --sign signer
cp "$repository/odomd-keyring.gpg" "$work/key.gpg"
apt_takes "signed-by=$work/key.gpg" || fail "apt refuses the signed index: $(cat "$work/said")"
sed -i 's/^Date: .*/Date: Thu, 01 Jan 2026 00:00:00 +0000/' "$repository/InRelease"
if apt_takes "signed-by=$work/key.gpg"; then fail "apt takes a changed index"; fi
index
if apt_takes "signed-by=$work/key.gpg"; then fail "apt takes an index without a signature"; fi

# The packages that the build needs (build-essential for the compiler), and those that CPack makes.
for package in $(sed -n "/^build='/,/'\$/p" "$source/tools/dependencies.sh" | sed "s/^build=//; s/'//g; s/g++//; s/dpkg-dev//"); do
  sed -n '/^Build-Depends/,/^$/p' "$source/debian/control" | grep -qE " $package(,|\$)" ||
    fail "debian/control: Build-Depends lacks $package"
done
{ echo odomd; sed -n 's/^set(CPACK_DEBIAN_.*_PACKAGE_NAME \(.*\))$/\1/p' "$source/cmake/OdomdPackages.cmake"; } | sort -u >"$work/made"
sed -n 's/^Package: //p' "$source/debian/control" | sort | diff - "$work/made" || fail "debian/control and CPack differ"
