#!/usr/bin/env bash
# Fits every surface of the gallery again and writes docs/gallery.md with its figures:
#   bench/gallery.sh [SCAN...]     real scans beside the made ones
# Real scans are read where they are; only a figure of some of them goes into docs/gallery/.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
build microbrdf
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
textured() {  # textured NAME KIND OPTION...: strips along and across of one surface, and the texture made from them
  local name=$1 place seed=0 strips size
  shift
  strips=$work/strips/$name
  mkdir -p "$strips"
  # Columns 1 to 3 of the layout, so that no strip across continues one along.
  for place in r0_c0 r1_c0 r2_c0 r3_c1 r3_c2 r3_c3; do
    seed=$((seed + 1))
    size=(--rows 15360 --cols 240)
    [[ $place != *_c0 ]] || size=(--rows 240 --cols 15360)
    "$microbrdf" synth "$@" "${size[@]}" --pitch 0.25um --seed "$seed" -o "$strips/$place.dat" >/dev/null
  done
  "$microbrdf" texture "$strips" --layout "r{row}_c{col}" --texel 60um --size 256 -o "$work/texture_$name" >/dev/null
  cp "$work/texture_$name/texture.png" "docs/gallery/texture_$name.png"
}
mkdir -p docs/gallery
textured brushed brushed --length 2000um --width 3um --orientation 90deg --rms 0.2um --coverage 4 --spread 0.05
textured isotropic multiscale --tau-max 300um
/usr/bin/python3 bench/gallery.py "$work/out" docs
