#!/usr/bin/env bash
# Fuzzes the readers of scans with libFuzzer, AddressSanitizer and UndefinedBehaviorSanitizer:
#   fuzz/run.sh [-t SECONDS] [-n EXECUTIONS] [FORMAT…]
# runs each FORMAT (default: all) until one of the limits is reached (default: the executions in fuzz/formats.txt), and
# prints executions, coverage and findings. Corpora grow in build/fuzz/corpus/FORMAT; they start from small scans that
# the tests make and, where it is there, from the heads of the real ones in ../shared/scans. What is found goes to
# build/fuzz/found/FORMAT: mend it, and give it to fuzz/findings/FORMAT, whose files the tests read again.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

seconds=3600 most=
while getopts t:n: option; do
  case $option in
    t) seconds=$OPTARG ;;
    n) most=$OPTARG ;;
    *) sed -n '2,7s/^# \{0,1\}//p' "$0" >&2; exit 2 ;;
  esac
done
shift $((OPTIND - 1))

[[ -f build/fuzz/build.ninja ]] || cmake --preset fuzz
cmake --build --preset fuzz -j "${MICRO_JOBS:-$(nproc)}"
cd build/fuzz

# A finding ends libFuzzer's run; the next one goes on with what is left.
fuzz() {  # fuzz FORMAT EXECUTIONS MEGABYTES
  local format=$1 executions=$2 log=$1.log end=$((SECONDS + seconds)) total=0 ran folders=("corpus/$1" "seeds/$1")
  for folder in ../../fuzz/findings/$format ../../../shared/scans; do
    [[ ! -d $folder ]] || folders+=("$folder")
  done
  mkdir -p "found/$format"
  export ASAN_OPTIONS=allocator_may_return_null=1:max_allocation_size_mb=$3:alloc_dealloc_mismatch=0:detect_leaks=0
  while [[ $SECONDS -lt $end && $total -lt $executions ]]; do
    "./fuzz_$format" "${folders[@]}" -max_len=8192 -timeout=20 -rss_limit_mb=4096 \
      -max_total_time=$((end - SECONDS)) -runs=$((executions - total)) -print_final_stats=1 \
      -artifact_prefix="found/$format/" >"$log" 2>&1 || true
    ran=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
    [[ ${ran:-0} -gt 0 ]] || { tail -n 20 "$log" >&2; exit 1; }
    total=$((total + ran))
  done
  # Of each kind, the last number that libFuzzer told.
  printf '%-16s %12d %9s %9s %9d\n' "$format" "$total" "$(sed -n 's/.* cov: \([0-9]*\).*/\1/p' "$log" | tail -n 1)" \
    "$(sed -n 's/.* ft: \([0-9]*\).*/\1/p' "$log" | tail -n 1)" "$(find "found/$format" -type f | wc -l)"
}

printf '%-16s %12s %9s %9s %9s\n' format executions edges features findings
while read -r format executions megabytes; do
  [[ $format != "#"* && (" $* " == *" $format "* || $# -eq 0) ]] || continue
  fuzz "$format" "${most:-$executions}" "$megabytes"
done <../../fuzz/formats.txt
