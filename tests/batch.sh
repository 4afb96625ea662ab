#!/usr/bin/env bash
# What a batch must survive, tried on the program: batch.sh PROGRAM [KILLS [FULL_DISKS]]
# After each mishap nothing is half-written under a final name, and the same command completes the work with
# the tables of an undisturbed run. KILLS is the number of kills at random moments (5 unless said),
# FULL_DISKS that of disks that are full at random points (4 unless said).
set -uo pipefail
program=$1 kills=${2:-5} full_disks=${3:-4}
work=$(mktemp -d) failures=0 skipped=0
tmpfs=
cleanup() { [[ -z $tmpfs ]] || umount "$tmpfs"; chmod -R u+rwx "$work"; rm -rf "$work"; }
trap cleanup EXIT
cd "$work" || exit 1

fail() { echo "FAILED: $*"; failures=$((failures + 1)); }
skip() { echo "NOT CHECKED: $*"; skipped=$((skipped + 1)); }
expect_code() {  # expect_code CODE WHAT COMMAND...
  local code=$1 what=$2 result=0
  shift 2
  "$@" >out.txt 2>err.txt || result=$?
  [[ $result -eq $code ]] || fail "$what: exit code $result instead of $code: $(tail -n 2 err.txt)"
}
expect_said() {  # expect_said TEXT WHAT: in what the last command said
  grep -q -- "$1" out.txt err.txt || fail "$2: says nothing of '$1': $(tail -n 2 err.txt)"
}
# Whole files, and every table as in the undisturbed run.
compare() {  # compare FILE WHAT [REFERENCE]
  /usr/bin/python3 - "${3:-reference}/result.h5" "$1" <<'P' || fail "$2: not what an undisturbed run gives"
import sys, h5py, numpy as np
with h5py.File(sys.argv[1]) as a, h5py.File(sys.argv[2]) as b:
    assert b.attrs['complete'] == 1
    assert list(a['scans']) == list(b['scans'])
    for name in a['scans']:
        assert a['scans'][name].attrs['sha256'] == b['scans'][name].attrs['sha256']
    for method in a['ndf']:
        for table in ('density', 'standard_error'):
            x, y = a['ndf'][method][table][:], b['ndf'][method][table][:]
            assert np.array_equal(x, y), (method, table)
P
}
# No half of a file under a final name: what stands there is an earlier whole one or nothing.
nothing_half_written() {  # nothing_half_written FOLDER WHAT [REFERENCE]
  [[ ! -e $1/result.h5 ]] || compare "$1/result.h5" "$2" "${3:-reference}"
}

mkdir scans
for k in $(seq 8); do "$program" synth gaussian --rows 200 --cols 220 --seed "$k" -o "scans/$k.dat" >/dev/null || exit 1; done
run() { "$program" run scans -o "$1" --without kirchhoff,pictures --size 257 --threads 1; }

start=$(date +%s%N)
expect_code 0 "undisturbed" run reference
took=$((($(date +%s%N) - start) / 1000000))  # ms
/usr/bin/python3 -c 'import h5py' || { skip "no h5py, so nothing can be compared"; exit 77; }

# Kills at random moments, into one folder.
RANDOM=7
for ((k = 0; k < kills; ++k)); do
  "$program" run scans -o killed --without kirchhoff,pictures --size 257 --threads 1 >/dev/null 2>&1 &
  victim=$!
  sleep "$(printf '%d.%03d' $((RANDOM % (took + 1) / 1000)) $((RANDOM % (took + 1) % 1000)))"
  kill -9 "$victim" 2>/dev/null
  wait "$victim" 2>/dev/null
  nothing_half_written killed "kill $k"
done
expect_code 0 "after $kills kills" run killed
compare killed/result.h5 "after $kills kills"
[[ -z $(find killed -name '.microbrdf-*') ]] || fail "unfinished files are left after the run that completes"

# Asked to stop in the middle of its work, three times over: what was done is kept, and taken up again.
for k in 1 2 3; do
  "$program" run scans -o stopped --without kirchhoff,pictures --size 257 --threads 1 >out.txt 2>err.txt &
  victim=$!
  sleep "$(printf '0.%03d' $((took / 5)))"
  kill -TERM "$victim" 2>/dev/null
  wait "$victim"
  code=$?
  [[ $code -eq 0 || $code -eq 3 || $code -eq 143 ]] || fail "stop $k: exit code $code: $(tail -n 2 err.txt)"
  [[ $code -ne 3 || -s stopped/checkpoint.h5 ]] || fail "stop $k: no checkpoint"
  nothing_half_written stopped "stop $k"
done
kept=no
[[ ! -e stopped/checkpoint.h5 ]] || kept=yes
expect_code 0 "after three stops" run stopped
[[ $kept == no ]] || expect_said "of an earlier run that was stopped" "after three stops"
compare stopped/result.h5 "after three stops"
[[ ! -e stopped/checkpoint.h5 ]] || fail "a checkpoint is left after the run that completes"

# A second run on one output, while the first is stopped in the middle of its work.
"$program" run scans -o held --without kirchhoff,pictures --size 257 --threads 1 >/dev/null 2>&1 &
first=$!
for _ in $(seq 200); do [[ -d held ]] && break; sleep 0.01; done
sleep 0.05
if kill -STOP "$first" 2>/dev/null; then
  expect_code 3 "second run" run held
  expect_said "held by another run" "second run"
  kill -CONT "$first"
fi
wait "$first" || fail "the first of two runs did not end well"
compare held/result.h5 "the first of two runs"

# A place that cannot be written to, and a file that cannot be read; root may do both.
if [[ $(id -u) -ne 0 ]]; then
  as_nobody=()
else
  as_nobody=(runuser -u nobody --)
  chmod 755 "$work"
  # Root's home, where a clone may lie, is closed to nobody.
  install -m 755 "$program" microbrdf
  program=$work/microbrdf
fi
if [[ $(id -u) -ne 0 ]] || command -v runuser >/dev/null; then
  mkdir sealed && chmod 555 sealed
  expect_code 3 "read-only place" "${as_nobody[@]}" "$program" run scans -o sealed/out --without kirchhoff
  expect_said sealed "read-only place"
  cp -r scans locked && chmod 000 locked/3.dat
  mkdir -m 777 open
  expect_code 1 "unreadable file" "${as_nobody[@]}" "$program" run locked -o open/out --without kirchhoff,pictures --size 257
  expect_said "3.dat" "unreadable file"
  chmod 644 locked/3.dat
  expect_code 0 "after the file was made readable" "${as_nobody[@]}" "$program" run locked -o open/out --without kirchhoff,pictures --size 257
  compare open/out/result.h5 "after the file was made readable"
else
  skip "read-only place and unreadable file: root without runuser"
fi

# Directories that hold no scan, or lead in circles.
mkdir empty junk
expect_code 3 "empty directory" "$program" run empty -o from_empty
[[ ! -e from_empty ]] || fail "an empty directory made an output"
for k in $(seq 20); do head -c $((k * 997)) /dev/urandom >"junk/$k"; done
: >junk/nothing
expect_code 3 "directory of junk" "$program" run junk -o from_junk
expect_said "holds no scan" "directory of junk"
cp -r scans looped && ln -s .. looped/up && ln -s self looped/self && mkdir looped/deeper && ln -s ../../looped looped/deeper/again
expect_code 0 "symlink loop" "$program" run looped -o from_loop --without kirchhoff,pictures --size 257
compare from_loop/result.h5 "symlink loop"

# A file that vanishes and one that is cut after the listing are failures by name, and the rest goes on.
cp -r scans moving
( sleep 0.05; rm -f moving/8.dat; truncate -s 1000 moving/7.dat ) &
"$program" run moving -o from_moving --without kirchhoff,pictures --size 257 --threads 1 >out.txt 2>err.txt
result=$?
wait %% 2>/dev/null
[[ $result -le 1 ]] || fail "a file that vanishes: exit code $result"
cp scans/7.dat scans/8.dat moving/
expect_code 0 "after the files came back" "$program" run moving -o from_moving --without kirchhoff,pictures --size 257
compare from_moving/result.h5 "after the files came back"

# A file that grows while it is read is a failure by name (its hash and its heights would be of two files), or was
# read between two of its changes; the rest goes on.
cp -r scans growing
while printf more >>growing/5.dat; do :; done &
writer=$!
"$program" run growing -o from_growing --without kirchhoff,pictures --size 257 --threads 1 >out.txt 2>err.txt
result=$?
kill "$writer"
wait "$writer" 2>/dev/null
[[ $result -le 1 ]] || fail "a file that grows: exit code $result"
[[ $result -ne 1 ]] || expect_said "5.dat: changed while it was read" "a file that grows"
cp scans/5.dat growing/
expect_code 0 "after the file was put back" "$program" run growing -o from_growing --without kirchhoff,pictures --size 257
compare from_growing/result.h5 "after the file was put back"

# A disk that is full, at random points of all that the run writes.
mkdir full
if [[ $(id -u) -eq 0 ]] && mount -t tmpfs -o size=64m tmpfs full 2>/dev/null; then
  tmpfs=$work/full
  with_pictures() { "$program" run scans -o "$1" --without kirchhoff --size 1025; }
  expect_code 0 "a disk with room" with_pictures roomy
  needed=$(du -sk --apparent-size roomy | cut -f 1)  # KiB
  RANDOM=11
  for ((k = 0; k < full_disks; ++k)); do
    room=$((RANDOM * needed / 32768))
    echo "full disk: $room KiB left of the $needed that the run needs"
    rm -rf full/*
    fallocate -l "$((65536 - room))k" full/filler
    expect_code 3 "full disk, $room KiB left" with_pictures full/out
    nothing_half_written full/out "full disk, $room KiB left" roomy
  done
  rm full/filler
  expect_code 0 "after room was made" with_pictures full/out
  compare full/out/result.h5 "after room was made" roomy
else
  skip "full disk: needs root and mount"
fi

echo "$failures failed, $skipped not checked"
[[ $failures -eq 0 ]]
