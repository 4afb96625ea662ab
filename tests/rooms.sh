#!/usr/bin/env bash
# Holds the sources to the rooms of docs/design.md: rooms.sh [ROOT] prints each violation as file:line: fact.
# Tests (*_test.cpp), libmicro/testing, bench/ and tests/ may include any room.
set -euo pipefail
cd "${1:-.}"

# A room, and the rooms whose headers it may include besides its own. A room names only rooms above it, so the
# graph has no cycles.
rooms='
core          :
height        : core
distribution  : core
ndf           : core height distribution
kirchhoff     : core height distribution
io            : core height distribution
fit           : core distribution
texture       : core distribution
brdf          : core distribution
gonio         : core height distribution brdf
render        : core distribution texture brdf
pipelines     : core height distribution ndf kirchhoff io fit texture brdf gonio render
tools         : core height distribution ndf kirchhoff io fit texture brdf gonio render pipelines
'

# What only one file may touch: a pattern of lines, the files that may, and what to say of the others.
private=(
  '#[[:space:]]*include[[:space:]]*[<"]fftw3|libmicro/core/fft\.(h|cpp)|FFTW is included by core/fft alone'
  '#[[:space:]]*pragma[[:space:]]+omp|libmicro/core/parallel\.(h|cpp)|OpenMP pragmas stand in core/parallel alone'
  '#[[:space:]]*include[[:space:]]*[<"]omp\.h|libmicro/core/parallel\.(h|cpp)|omp.h is included by core/parallel alone'
)

# NaN means "missing", and the program runs on other machines than the one that built it.
forbidden_flags='-ffast-math|-Ofast|-funsafe-math-optimizations|-ffinite-math-only|-march=|-mcpu=|-mtune=native'

sources() {
  local folders=()
  for folder in libmicro pipelines tools bench tests; do [[ ! -d $folder ]] || folders+=("$folder"); done
  find "${folders[@]}" -type f \( -name '*.h' -o -name '*.cpp' -o -name '*.c' \) | LC_ALL=C sort
}

build_files() {
  find . -path ./build -prune -o -path ./.git -prune -o -type f \
    \( -name CMakeLists.txt -o -name '*.cmake' -o -name 'CMakePresets.json' \) -print | LC_ALL=C sort
}

mapfile -t files < <(sources)
[[ ${#files[@]} -gt 0 ]] || { echo "no sources found in $PWD"; exit 1; }

violations=$(
  ROOMS=$rooms awk '
    function room_of(path,    part) {
      split(path, part, "/")
      return part[1] == "libmicro" ? part[2] : part[1]
    }
    BEGIN {
      rows = split(ENVIRON["ROOMS"], line, "\n")
      for (r = 1; r <= rows; ++r) {
        n = split(line[r], word, " ")
        if (n < 2) continue
        for (w = 3; w <= n; ++w) {
          if (!(word[w] in known)) print "tests/rooms.sh: room " word[1] " names " word[w] ", which is not above it"
          allowed[word[1], word[w]] = 1
        }
        allowed[word[1], word[1]] = 1
        known[word[1]] = 1
      }
      known["testing"] = free["testing"] = free["bench"] = free["tests"] = 1
    }
    FNR == 1 {
      here = room_of(FILENAME)
      anything = (here in free) || FILENAME ~ /_test\.cpp$/
      if (!(here in known) && !(here in free)) print FILENAME ":1: room " here " is not in the table"
    }
    /^[[:space:]]*#[[:space:]]*include[[:space:]]*"/ {
      split($0, quoted, "\"")
      target = quoted[2]
      there = target
      sub("/.*", "", there)
      if (index(target, "/") == 0 || !(there in known))
        { if (here != "tests" && here != "bench") print FILENAME ":" FNR ": \"" target "\" does not start with a room" }
      else if (!anything && !((here, there) in allowed))
        print FILENAME ":" FNR ": " here " includes " there " (\"" target "\")"
    }
    /^[[:space:]]*#[[:space:]]*include[[:space:]]*</ {
      there = $0
      sub(/^[^<]*</, "", there)
      sub(/\/.*/, "", there)
      if (there in known) print FILENAME ":" FNR ": headers of rooms are included with quotes"
    }
  ' "${files[@]}"

  for rule in "${private[@]}"; do
    # The pattern has no |, so the three parts split at the first and the last one.
    pattern=${rule%%|*} rest=${rule#*|}
    may=${rest%|*} fact=${rest##*|}
    grep -nHE "$pattern" "${files[@]}" | grep -vE "^($may):" | sed -E "s/^([^:]*:[0-9]+):.*/\1: $(sed 's,/,\\/,g' <<<"$fact")/" || true
  done

  mapfile -t build < <(build_files)
  grep -nHE -e "$forbidden_flags" "${build[@]}" | sed 's/^\.\///' || true
)

if [[ -n $violations ]]; then
  printf '%s\n' "$violations"
  exit 1
fi
echo "${#files[@]} files keep to their rooms"
