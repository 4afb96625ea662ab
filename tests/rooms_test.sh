#!/usr/bin/env bash
# Plants one violation at a time in a small tree and sees that rooms.sh names it: rooms_test.sh ROOMS_SH
set -euo pipefail
rooms=$(realpath "$1")
tree=$(mktemp -d)
trap 'rm -rf "$tree"' EXIT
cd "$tree"
wrong=0

fresh() {
  rm -rf "${tree:?}"/*
  mkdir -p libmicro/{core,height,ndf,kirchhoff,testing} pipelines tools
  echo '#include <vector>' >libmicro/core/grid.h
  printf '#pragma once\n#include "core/grid.h"\n' >libmicro/height/field.h
  printf '#include "height/field.h"\n#include "ndf/naive.h"\n' >libmicro/ndf/naive.cpp
  printf '#include "kirchhoff/exact.h"\n' >libmicro/ndf/naive_test.cpp
  printf '#include "ndf/naive.h"\n' >libmicro/testing/oracle.h
  printf '#include <fftw3.h>\n' >libmicro/core/fft.cpp
  printf '#include <omp.h>\n#pragma omp parallel\n' >libmicro/core/parallel.cpp
  printf 'project(x)\n' >CMakeLists.txt
}

expect() {  # expect PATTERN: the check fails and says this
  local said
  if said=$(bash "$rooms" "$tree" 2>&1); then
    echo "not seen: $1"
    wrong=1
  elif ! grep -qE "$1" <<<"$said"; then
    printf 'expected: %s\nsaid: %s\n' "$1" "$said"
    wrong=1
  fi
}

plant() {  # plant FILE LINE PATTERN
  fresh
  mkdir -p "$(dirname "$1")"
  printf '%s\n' "$2" >>"$1"
  expect "$3"
}

fresh
bash "$rooms" "$tree" >/dev/null || { echo "a good tree is refused"; wrong=1; }

plant libmicro/core/grid.h '#include "height/field.h"' '^libmicro/core/grid.h:2: core includes height'
plant libmicro/ndf/naive.cpp '#include "kirchhoff/exact.h"' '^libmicro/ndf/naive.cpp:3: ndf includes kirchhoff'
plant libmicro/ndf/naive.cpp '  # include "pipelines/run.h"' '^libmicro/ndf/naive.cpp:3: ndf includes pipelines'
plant pipelines/run.cpp '#include "tools/units.h"' '^pipelines/run.cpp:1: pipelines includes tools'
plant tools/run.cpp '#include "testing/oracle.h"' '^tools/run.cpp:1: tools includes testing'
plant libmicro/ndf/naive.cpp '#include "naive.h"' '^libmicro/ndf/naive.cpp:3: "naive.h" does not start with a room'
plant libmicro/ndf/naive.cpp '#include <height/field.h>' '^libmicro/ndf/naive.cpp:3: .*quotes'
plant libmicro/utils/misc.h '#pragma once' '^libmicro/utils/misc.h:1: room utils is not in the table'
plant libmicro/ndf/naive.cpp '#include <fftw3.h>' '^libmicro/ndf/naive.cpp:3: FFTW'
plant libmicro/ndf/naive.cpp '#pragma omp simd' '^libmicro/ndf/naive.cpp:3: OpenMP'
plant libmicro/ndf/naive_test.cpp '#include <omp.h>' '^libmicro/ndf/naive_test.cpp:2: omp.h'
plant CMakeLists.txt 'add_compile_options(-ffast-math)' '^CMakeLists.txt:2:.*-ffast-math'
plant cmake/flags.cmake 'add_compile_options(-march=native)' '^cmake/flags.cmake:1:.*-march=native'

exit $wrong
