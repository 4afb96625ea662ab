#!/usr/bin/env bash
# Takes the filtered NDF and D_K of scans through reciprocity and the white furnace, and writes what they say
# into docs/brdf.md:
#   bench/furnace.sh SCAN...
# Takes some ten minutes for fifteen scans.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
build microbrdf
/usr/bin/python3 bench/furnace.py "$microbrdf" docs/brdf.md "${scans[@]}"
