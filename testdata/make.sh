#!/usr/bin/env bash
# Makes the scans in this folder again, byte for byte: testdata/make.sh [MICROBRDF] [FOLDER]
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
microbrdf=${1:-$here/../build/release/microbrdf}
folder=${2:-$here}
size=(--rows 120 --cols 160 --pitch 0.11um)

# Two patches of one brushed sheet and two of one isotropic, rough sheet; a profilometer loses steep points.
"$microbrdf" synth brushed "${size[@]}" --rms 120nm --length 25um --width 1.5um --seed 1 --holes 0.01 -o "$folder/brushed_1.dat"
"$microbrdf" synth brushed "${size[@]}" --rms 120nm --length 25um --width 1.5um --seed 2 --holes 0.02 --hole-radius 0.3um -o "$folder/brushed_2.dat"
"$microbrdf" synth gaussian "${size[@]}" --rms 200nm --tau 2um --seed 3 --holes 0.01 -o "$folder/isotropic_1.dat"
"$microbrdf" synth gaussian "${size[@]}" --rms 200nm --tau 2um --seed 4 --holes 0.02 --hole-radius 0.3um -o "$folder/isotropic_2.dat"
