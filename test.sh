#!/usr/bin/env bash
# Installs what is missing (Debian 12, apt), builds, and runs the tests:
#   ./test.sh         the `release` build and all its tests
#   ./test.sh --all   also what needs heavy guests: other compilers, sanitizers, Gwyddion, clang-format, clang-tidy
# The last line is the count: N passed, N failed, N skipped.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

case "$*" in
  "") all=0 ;;
  --all) all=1 ;;
  *) echo "usage: ./test.sh [--all]" >&2; exit 2 ;;
esac

jobs=$(nproc)
passed=0 failed=0 skipped=0
failures=()

count() {  # count RESULT NAME
  if [[ $1 -eq 0 ]]; then passed=$((passed + 1)); else failed=$((failed + 1)); failures+=("$2"); fi
}

attribute() {  # attribute NAME FILE: a number in the head of ctest's JUnit report
  sed -n "s/^[[:space:]]*$1=\"\([0-9]*\)\".*/\1/p" "$2" | head -n 1
}

# Builds one preset and runs its tests. A build that fails counts as one failed test.
run_preset() {  # run_preset NAME [CMAKE_ARGUMENT...]
  local preset=$1 report=build/$1/tests.xml wrapper=() total bad off
  shift
  printf '\n== %s ==\n' "$preset"
  if ! { cmake --preset "$preset" "$@" && cmake --build --preset "$preset" -j "$jobs"; } </dev/null; then
    count 1 "$preset: build"
    return
  fi
  # ThreadSanitizer's fixed address layout does not survive strong address randomisation.
  if [[ $preset == tsan ]] && setarch -R true 2>/dev/null; then wrapper=(setarch -R); fi
  rm -f "$report"
  "${wrapper[@]}" ctest --preset "$preset" -j "$jobs" --output-junit "$PWD/$report" </dev/null ||
    failures+=("$preset: ctest")
  if [[ ! -s $report ]]; then
    count 1 "$preset: ctest wrote no report"
    return
  fi
  total=$(attribute tests "$report") bad=$(attribute failures "$report")
  off=$(($(attribute skipped "$report") + $(attribute disabled "$report")))
  passed=$((passed + total - bad - off)) failed=$((failed + bad)) skipped=$((skipped + off))
  [[ $total -gt 0 ]] || count 1 "$preset: no tests found"
}

# Runs one command as one test.
check() {  # check NAME COMMAND...
  local name=$1 result=0
  shift
  printf '\n== %s ==\n' "$name"
  "$@" </dev/null || result=$?
  count "$result" "$name"
}

sources() { find libmicro pipelines tools bench tests fuzz -name '*.h' -o -name '*.cpp' -o -name '*.c'; }

if [[ $all -eq 0 ]]; then
  scripts/install-packages.sh build test
  run_preset release
else
  scripts/install-packages.sh build test bench heavy
  run_preset release -DMICRO_HEAVY=ON
  run_preset dev
  run_preset dev-clang
  run_preset no-openmp
  run_preset asan-ubsan
  run_preset tsan
  run_preset fuzz
  mapfile -t files < <(sources | sort)
  check clang-format clang-format-14 --dry-run -Werror "${files[@]}"
  # Tests are left out: GoogleTest's macros cost most of the time and raise most of the false alarms.
  check clang-tidy run-clang-tidy-14 -quiet -p build/dev-clang -j "$jobs" '(?<!_test)\.cpp$'
fi

echo
for failure in "${failures[@]}"; do echo "failed: $failure"; done
echo "$passed passed, $failed failed, $skipped skipped"
[[ $failed -eq 0 && ${#failures[@]} -eq 0 ]]
