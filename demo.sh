#!/usr/bin/env bash
# Installs what is missing (Debian 12, apt), builds microbrdf and runs the main job on the small scans in testdata/.
# Leaves demo-out/ with result.h5, OpenEXR pictures and a PNG contact sheet.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

scripts/install-packages.sh build
# Tests are not part of a demonstration, nor are the packages they need.
cmake --preset release -DMICRO_TESTS=OFF </dev/null
cmake --build --preset release --target microbrdf -j "$(nproc)" </dev/null

echo
build/release/microbrdf run testdata -o demo-out </dev/null
echo
echo "demo-out holds:"
ls -l demo-out
