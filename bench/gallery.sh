#!/usr/bin/env bash
# Fits every surface of the gallery again and writes docs/gallery.md with its figures:
#   bench/gallery.sh [SCAN...]     real scans beside the made ones
# Real scans are read where they are; only a figure of some of them goes into docs/gallery/.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
scans=()
for scan in "$@"; do scans+=("$(realpath -- "$scan")"); done
cd "$root"
cmake --preset release >/dev/null
cmake --build --preset release --target microbrdf >/dev/null
microbrdf=$root/build/release/microbrdf
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

made() {  # made NAME KIND OPTION...: four patches of one surface
  local name=$1 seed
  shift
  mkdir -p "$work/scans/$name"
  for seed in 1 2 3 4; do
    "$microbrdf" synth "$@" --seed "$seed" -o "$work/scans/$name/$seed.dat" >/dev/null
  done
}
fitted() {  # fitted KIND NAME PATH: its NDFs and their fits; what cannot be done is told in the table
  local folder=$work/out/$2
  mkdir -p "$folder"
  echo "$1" >"$folder/kind"
  "$microbrdf" run "$3" -o "$folder" --size 513 --extent auto --without report >/dev/null 2>"$folder/stderr" || true
  [[ ! -s $folder/result.h5 ]] || "$microbrdf" fit --json --no-figure "$folder/result.h5" >"$folder/fits.json"
}

made gaussian gaussian --rms 0.3um --tau 3um
made anisotropic gaussian --rms 0.3um --tau-x 12um --tau-y 3um --orientation 20deg
made multiscale multiscale
made brushed brushed
for name in gaussian anisotropic multiscale brushed; do fitted made "$name" "$work/scans/$name"; done
for scan in "${scans[@]}"; do fitted real "$(basename "$scan")" "$scan"; done
textured() {  # textured NAME KIND OPTION...: a strip across, cut into texels, and the texture made from it
  local name=$1
  shift
  "$microbrdf" synth "$@" --rows 960 --cols 4800 --pitch 0.25um -o "$work/$name.dat" >/dev/null
  "$microbrdf" texture "$work/$name.dat" -o "$work/$name" --texel 15um --size 256 >/dev/null
  cp "$work/$name/texture.png" "docs/gallery/texture_$name.png"
}
mkdir -p docs/gallery
textured brushed brushed --length 300um --width 3um --orientation 90deg --rms 0.2um --coverage 4 --spread 0.05
textured isotropic multiscale --tau-max 60um
/usr/bin/python3 bench/gallery.py "$work/out" docs
