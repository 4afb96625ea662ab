# To be sourced by the scripts here. From then on: `scans`, the absolute paths of their arguments; the project's
# root is where they are; build TARGET... makes what they measure.
scans=()
for scan in "$@"; do scans+=("$(realpath -- "$scan")"); done
cd "$(dirname "${BASH_SOURCE[0]}")/.."
microbrdf=$PWD/build/release/microbrdf

build() {
  cmake --preset release -DMICRO_BENCH=ON >/dev/null
  cmake --build --preset release --target "$@" >/dev/null
}
