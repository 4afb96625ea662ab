#!/usr/bin/env bash
# Measures error against run time on this machine and writes docs/accuracy.md with its figures:
#   bench/accuracy.sh [SCAN...]     real scans beside the made surfaces
#   bench/accuracy.sh --part brdf   only this part anew (kirchhoff, fit, brdf, texture, recipes), the others as they stand
# Takes some ten minutes on two cores, the parts brdf and recipes a minute on one.
set -euo pipefail
part=
if [[ ${1:-} == --part ]]; then
  part=$2
  shift 2
fi
. "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
build error_vs_time
mkdir -p docs/accuracy
csv=docs/accuracy/error_vs_time.csv
if [[ -z $part ]]; then
  build/release/bench/error_vs_time -o "$csv" "${scans[@]}"
else
  fresh=$(mktemp)
  trap 'rm -f "$fresh" "$csv.part"' EXIT
  build/release/bench/error_vs_time --part "$part" -o "$fresh" "${scans[@]}"
  { grep -v "^$part," "$csv"; tail -n +2 "$fresh"; } >"$csv.part"
  mv "$csv.part" "$csv"
fi
/usr/bin/python3 bench/accuracy.py "$csv" docs
