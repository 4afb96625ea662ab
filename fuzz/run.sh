#!/usr/bin/env bash
# Fuzzes the readers of scans with libFuzzer, AddressSanitizer and UndefinedBehaviorSanitizer:
#   fuzz/run.sh [-t SECONDS] [-n EXECUTIONS] [-p PROGRAM] [FORMAT…]
# runs each FORMAT (default: all) until one of the limits is reached (default: the executions in fuzz/formats.txt), and
# prints executions, coverage and findings: all, most of which a library dies of (it costs the program its child process),
# and those that are ours. With -p PROGRAM (microbrdf) that is tried: it reads every finding in 2 GiB and 20 s.
#   fuzz/run.sh -c [FORMAT…]
# measures what of each reader its corpus and seeds reach (llvm-cov), and fuzzes nothing.
# Corpora grow in build/fuzz/corpus/FORMAT; they start from small scans that the tests make and, where it is there, from
# the heads of the real ones in ../shared/scans. What is found goes to build/fuzz/found/FORMAT: mend it, and give it to
# fuzz/findings/FORMAT, whose files the tests read again.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

seconds=3600 most='' program='' coverage='' failures=0
while getopts t:n:p:c option; do
  case $option in
    t) seconds=$OPTARG ;;
    n) most=$OPTARG ;;
    p) program=$(realpath "$OPTARG") ;;
    c) coverage=yes ;;
    *) sed -n '2,12s/^# \{0,1\}//p' "$0" >&2; exit 2 ;;
  esac
done
shift $((OPTIND - 1))

build=build/fuzz options=()
if [[ $coverage ]]; then
  build=build/fuzz-coverage
  options=(-DMICRO_SANITIZE=fuzzer-no-link "-DCMAKE_CXX_FLAGS=-fprofile-instr-generate -fcoverage-mapping")
fi
[[ -f $build/build.ninja ]] || cmake --preset fuzz -B "$build" "${options[@]}"
cmake --build "$build" -j "${MICRO_JOBS:-$(nproc)}"
source=$PWD
cd "$build"
TMPDIR=$(mktemp -d)  # of the inputs, one after the other
export TMPDIR
trap 'rm -rf "$TMPDIR"' EXIT

folders_of() {  # folders_of FORMAT: where its inputs stand
  local folder
  for folder in "$source/build/fuzz/corpus/$1" "$source/build/fuzz/seeds/$1" "$source/fuzz/findings/$1" "$source/../shared/scans"; do
    [[ ! -d $folder ]] || echo "$folder"
  done
}

# Findings that are our own parsers' or, beside a library, whose innermost frame is ours, the C library's and the
# sanitizer's left out.
ours() {  # ours FORMAT SECONDS
  local report
  if [[ $2 -ge 20 ]]; then find "found/$1" -type f -name '*-*' | wc -l; return; fi
  for report in "found/$1"/report.*; do
    [[ ! -f $report ]] ||
      grep -m 1 -oE '#[0-9]+ .*(/lib(hdf5|zip|z|OpenEXR|Ilm|Iex|Imath|pugixml)[^/ ]*\.so|/libmicro/|/scan_fuzzer\.cpp)' "$report" || true
  done | grep -vc '\.so$' || true
}

# A finding in our own parsers ends libFuzzer's run; the next one goes on with what is left. Where a library reads,
# runs are processes of their own that may end as they like.
fuzz() {  # fuzz FORMAT EXECUTIONS MEGABYTES SECONDS BYTES
  local format=$1 executions=$2 log=$1.log end=$((SECONDS + seconds)) total=0 ran survive=() folders own
  mapfile -t folders < <(folders_of "$format")
  [[ $4 -ge 20 ]] || survive=(-fork=1 -ignore_crashes=1 -ignore_timeouts=1 -ignore_ooms=1)
  mkdir -p "found/$format"
  export ASAN_OPTIONS=allocator_may_return_null=1:max_allocation_size_mb=$3:alloc_dealloc_mismatch=0:detect_leaks=0:log_path=found/$format/report
  while [[ $SECONDS -lt $end && $total -lt $executions ]]; do
    "./fuzz_$format" "${folders[@]}" -max_len="$5" -timeout="$4" -rss_limit_mb=4096 \
      -max_total_time=$((end - SECONDS)) -runs=$((executions - total)) -print_final_stats=1 -report_slow_units="$4" \
      -artifact_prefix="found/$format/" "${survive[@]}" >"$log" 2>&1 || true
    ran=$(sed -n -e 's/^stat::number_of_executed_units: *//p' -e 's/^#\([0-9]*\): cov: .*/\1/p' "$log" | tail -n 1)
    [[ ${ran:-0} -gt 0 ]] || { tail -n 20 "$log" >&2; exit 1; }
    total=$((total + ran))
  done
  own=$(ours "$format" "$4")
  failures=$((failures + own))
  # Of each kind, the last number that libFuzzer told.
  printf '%-16s %12d %9s %9s %9d %9d\n' "$format" "$total" "$(sed -n 's/.* cov: \([0-9]*\).*/\1/p' "$log" | tail -n 1)" \
    "$(sed -n 's/.* ft: \([0-9]*\).*/\1/p' "$log" | tail -n 1)" \
    "$(find "found/$format" -type f -name '*-*' | wc -l)" "$own"
}

# The program may refuse what was found; a signal or 20 s are a fault.
read_by_program() {  # read_by_program FORMAT
  local file code
  for file in "found/$1"/*-*; do
    [[ -f $file ]] || continue
    code=0
    (ulimit -v 2097152; exec timeout -s KILL 20 "$program" info --pitch 0.25 "$file" >/dev/null 2>&1) || code=$?
    [[ $code -le 3 ]] || { echo "FAILED: $file: exit code $code"; failures=$((failures + 1)); }
  done
}

measure() {  # measure FORMAT FILE,FILE…
  local folders profile
  mapfile -t folders < <(folders_of "$1" | grep -v /findings/)  # what takes gigabytes is not needed here
  profile=$TMPDIR/$1
  # 2 GiB of address space: what asks for more gets none.
  (ulimit -v 2097152; LLVM_PROFILE_FILE=$profile.raw exec "./fuzz_$1" "${folders[@]}" -runs=0 -max_len=20000 -rss_limit_mb=0) \
    >"$1.log" 2>&1 || { tail -n 5 "$1.log" >&2; exit 1; }
  llvm-profdata-14 merge -sparse "$profile.raw" -o "$profile.data"
  llvm-cov-14 report scan_fuzzer -instr-profile="$profile.data" | awk -v format="$1" -v files="/(${2//,/|})[.]cpp$" \
    '$1 ~ files {printf "%-16s %-20s regions %4d of %4d (%s), lines %4d of %4d (%s)\n", format, $1, $2 - $3, $2, $4, $8 - $9, $8, $10}'
}

[[ $coverage ]] || printf '%-16s %12s %9s %9s %9s %9s\n' format executions edges features findings ours
while read -r format executions megabytes limit bytes files; do
  [[ $format != "#"* && (" $* " == *" $format "* || $# -eq 0) ]] || continue
  if [[ $coverage ]]; then
    measure "$format" "$files"
  else
    fuzz "$format" "${most:-$executions}" "$megabytes" "$limit" "$bytes"
    [[ -z $program ]] || read_by_program "$format"
  fi
done <"$source/fuzz/formats.txt"
[[ $failures -eq 0 ]]
