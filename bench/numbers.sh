#!/usr/bin/env bash
# Measures the README's numbers again on this machine: bench/numbers.sh [FOLDER for 0.5 GB of scans]
# Installs what is missing, builds bench/, makes 400 synthetic scans of 640 × 480 points, times whole runs on them,
# then runs every benchmark ("of bound": 1 is as fast as the machine can).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
scripts/install-packages.sh build bench
benches=(ndf_bench monte_carlo_bench fit_bench texture_bench)
cmake --preset release -DMICRO_TESTS=OFF -DMICRO_BENCH=ON >/dev/null
cmake --build --preset release --target microbrdf kirchhoff_bench "${benches[@]}" >/dev/null
microbrdf=$PWD/build/release/microbrdf
work=${1:-$(mktemp -d)}
[[ $# -gt 0 ]] || trap 'rm -rf "$work"' EXIT
mkdir -p "$work/scans" "$work/few"

for seed in $(seq 400); do
  scan=$work/scans/$(printf %03d "$seed").dat
  [[ -s $scan ]] || "$microbrdf" synth gaussian --rows 480 --cols 640 --pitch 0.11um --rms 0.3um --tau 3um \
    --seed "$seed" -o "$scan" >/dev/null
done
cp "$work"/scans/00[1-9].dat "$work"/scans/01[0-6].dat "$work/few"

timed() {  # timed TITLE COMMAND...: wall seconds and peak memory of the whole process
  local title=$1 report
  shift
  report=$( { /usr/bin/time -f '%e s, %M kB at most' "$@" >/dev/null; } 2>&1 | tail -n 1)
  printf '%s: %s\n' "$title" "$report"
}
cat "$work"/scans/*.dat >/dev/null
timed "filtered NDF of 400 scans, disk to result" "$microbrdf" ndf "$work/scans" -o "$work/filtered.h5" --method filtered
timed "filtered NDF of 16 scans, disk to result" "$microbrdf" ndf "$work/few" -o "$work/filtered16.h5" --method filtered
timed "D_K of 16 scans, the whole disk, tol 1e-3" "$microbrdf" ndf "$work/few" -o "$work/kirchhoff.h5" --method kirchhoff
timed "the same at 41 wavelengths" "$microbrdf" run "$work/few" -o "$work/spectrum" --lambda-q 380nm..780nm/10nm \
  --without naive,filtered,fit,statistics,pictures,report
build/release/bench/kirchhoff_bench
for bench in "${benches[@]}"; do
  "build/release/bench/$bench" --benchmark_min_time=0.5 2>/dev/null
done
# The last line: Gwyddion's unweighted local plane fit.
/usr/bin/python3 tests/gwyddion_statistics.py "$microbrdf" "$work/scans/001.dat" | tail -n 1
