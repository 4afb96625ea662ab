#!/usr/bin/env bash
# Installs the Debian 12 packages of the named sets, as far as they are missing:
#   scripts/install-packages.sh build|test|bench|heavy...
# What is there already is left alone, so a second run needs neither network nor rights.
# docs/dependencies.md says why each package is wanted.
set -euo pipefail

declare -A packages=(
  [build]="g++ cmake ninja-build pkgconf
    libeigen3-dev libfftw3-dev libhdf5-dev libopenexr-dev libpng-dev libssl-dev zlib1g-dev libzip-dev libpugixml-dev libhwy-dev librandom123-dev
    libcli11-dev nlohmann-json3-dev"
  [test]="libgtest-dev libboost-dev python3 python3-h5py python3-matplotlib"
  [bench]="libbenchmark-dev libgwyddion20-dev libglib2.0-dev python3 python3-numpy"
  [heavy]="clang-14 libclang-rt-14-dev libomp-14-dev clang-format-14 clang-tidy-14 slurm-wlm munge"
)

say() { printf '%s: %s\n' "$(basename "$0")" "$*" >&2; }

wanted=()
for set_name in "$@"; do
  [[ -n ${packages[$set_name]:-} ]] || { say "no set of packages is called '$set_name'"; exit 2; }
  read -r -d '' -a names <<<"${packages[$set_name]}" || true
  wanted+=("${names[@]}")
done

missing=()
for name in "${wanted[@]}"; do
  status=$(dpkg-query -W -f '${db:Status-Status}' "$name" 2>/dev/null) || status=
  # A package that exists for several architectures prints its state once for each.
  [[ $status == *installed && $status != *not-installed ]] || missing+=("$name")
done
[[ ${#missing[@]} -gt 0 ]] || exit 0

if ! command -v apt-get >/dev/null; then
  say "this system has no apt-get; install the equivalents of: ${missing[*]}"
  exit 1
fi
if [[ $(id -u) -eq 0 ]]; then
  as_root=(env)
elif command -v sudo >/dev/null; then
  as_root=(sudo)
  # Without a terminal nobody could type a password.
  [[ -t 0 ]] || as_root=(sudo -n)
  if ! "${as_root[@]}" true; then
    say "sudo does not let this user install packages; have an administrator run: apt-get install ${missing[*]}"
    exit 1
  fi
  as_root+=(env)
else
  say "packages are missing and this user is neither root nor has sudo; have an administrator run: apt-get install ${missing[*]}"
  exit 1
fi

apt() {
  "${as_root[@]}" DEBIAN_FRONTEND=noninteractive apt-get -q -o Dpkg::Use-Pty=0 -o DPkg::Lock::Timeout=300 "$@" </dev/null
}
install() { apt install -y --no-install-recommends "${missing[@]}"; }

say "installing ${missing[*]}"
# The package lists may be absent (a fresh container) or name versions that the mirror no longer has.
if ! apt install --simulate --no-install-recommends "${missing[@]}" >/dev/null 2>&1; then
  apt update
  install
else
  install || { say "trying once more with fresh package lists"; apt update; install; }
fi
