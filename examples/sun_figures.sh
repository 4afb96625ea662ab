#!/usr/bin/env bash
# Figures of [Sun02] and [SunGlossy] by the program: examples/sun_figures.sh MICROBRDF FOLDER [PROFILES]
#   shadowing_fig5_free_travel.png   [Sun02 Fig. 5] = [SunGlossy Fig. 4]: shadowing over the angle, for smoothness s
#   copper.h5, enamelled.h5, CSV     [SunGlossy Fig. 5]: copper at s = 1 over viewing angle and wavelength, light at
#                                    45 degrees; bare, and under a coat of n = 1.5. coat_fig5_*.png draw it.
# docs/sun.md says where the papers and the program differ.
set -euo pipefail
microbrdf=$1 folder=$2 profiles=${3:-512}
mkdir -p "$folder"
"$microbrdf" study shadowing --profiles "$profiles" -o "$folder"
"$microbrdf" study coat -o "$folder"
copper=(--model sun --smoothness 1 --material Cu --wi 45deg --lambda 400nm..700nm/10nm)
"$microbrdf" brdf "${copper[@]}" -o "$folder/copper.h5"
"$microbrdf" brdf "${copper[@]}" --coat 1.5 --coat-smoothness 50 -o "$folder/enamelled.h5"
"$microbrdf" brdf "${copper[@]}" --form printed -o "$folder/copper_as_printed.h5"
"$microbrdf" brdf "${copper[@]}" --coat 1.5 --coat-smoothness 50 --form printed -o "$folder/enamelled_as_printed.h5"
