#!/usr/bin/env bash
# Measures error against run time on this machine and writes docs/accuracy.md with its figures:
#   bench/accuracy.sh [SCAN...]     real scans beside the made surfaces
# Takes some ten minutes on two cores.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
scans=()
for scan in "$@"; do scans+=("$(realpath -- "$scan")"); done
cd "$root"
cmake --preset release -DMICRO_BENCH=ON >/dev/null
cmake --build --preset release --target error_vs_time >/dev/null
mkdir -p docs/accuracy
build/release/bench/error_vs_time -o docs/accuracy/error_vs_time.csv "${scans[@]}"
/usr/bin/python3 bench/accuracy.py docs/accuracy/error_vs_time.csv docs
