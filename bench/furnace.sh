#!/usr/bin/env bash
# Takes the filtered NDF and D_K of scans through reciprocity and the white furnace, and writes what they say
# into docs/brdf.md:
#   bench/furnace.sh SCAN...
# Takes a minute on two cores for a dozen scans.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
scans=()
for scan in "$@"; do scans+=("$(realpath -- "$scan")"); done
cd "$root"
cmake --preset release >/dev/null
cmake --build --preset release --target microbrdf >/dev/null
/usr/bin/python3 bench/furnace.py build/release/microbrdf docs/brdf.md "${scans[@]}"
