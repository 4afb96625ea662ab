#!/usr/bin/env bash
# Runs the README's Python example as it stands: readme_example.sh MICROBRDF SOURCE_DIR
set -euo pipefail
if ! /usr/bin/python3 -c 'import h5py, matplotlib' 2>/dev/null; then
  echo "SKIPPED: /usr/bin/python3 has no h5py or matplotlib"
  exit 77
fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$1" run "$2/testdata" -o "$folder/demo-out" >/dev/null
sed -n '/^```python$/,/^```$/{/^```/d;p}' "$2/README.md" >"$folder/example.py"
[[ -s $folder/example.py ]] || { echo "README.md has no Python example"; exit 1; }
cd "$folder"
MPLBACKEND=Agg MPLCONFIGDIR=$folder /usr/bin/python3 example.py
[[ -s ndf.png ]] || { echo "the example made no ndf.png"; exit 1; }
