#!/usr/bin/env bash
# The recipe in testdata makes its scans again, byte for byte: testdata_recipe.sh MICROBRDF TESTDATA
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$2/make.sh" "$1" "$folder" >/dev/null
for scan in "$2"/*.dat; do
  cmp "$scan" "$folder/$(basename "$scan")"
done
