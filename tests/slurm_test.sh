#!/usr/bin/env bash
# Runs examples/slurm on a cluster of one machine: 24 scans in 4 shards, one task killed and submitted again,
# merged, and compared with a single run.   tests/slurm_test.sh MICROBRDF     (as root; slurm-wlm and munge)
set -euo pipefail
export MICROBRDF
MICROBRDF=$(realpath "$1")
examples=$(realpath "$(dirname "${BASH_SOURCE[0]}")/../examples/slurm")
if [[ $(id -u) -ne 0 ]] || ! command -v slurmctld munged >/dev/null; then
  echo "NOT CHECKED: needs root, slurm-wlm and munge"
  exit 77
fi
folder=$(mktemp -d)
daemons=()
finish() {
  for pid in "${daemons[@]}"; do kill "$pid" 2>/dev/null || true; done
  wait || true
  rm -rf "$folder"
}
trap finish EXIT
cd "$folder"
mkdir scans state spool
for k in $(seq -w 24); do
  "$MICROBRDF" synth gaussian --rows 300 --cols 400 --rms 0.3um --seed "$((10#$k))" -o "scans/$k.dat" >/dev/null
done

export SLURM_CONF=$folder/slurm.conf
cat >"$SLURM_CONF" <<CONF
ClusterName=test
SlurmctldHost=$(hostname)(127.0.0.1)
SlurmUser=root
SlurmctldPort=27817
SlurmdPort=27818
AuthType=auth/munge
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SwitchType=switch/none
MpiDefault=none
ReturnToService=2
NodeName=$(hostname) NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
if ! munge -n >/dev/null 2>&1; then
  [[ -s /etc/munge/munge.key ]] || mungekey
  install -d -o munge -g munge /run/munge
  runuser -u munge -- munged -F &
  daemons+=($!)
  sleep 1
fi
slurmctld -D -f "$SLURM_CONF" &
daemons+=($!)
slurmd -D -f "$SLURM_CONF" &
daemons+=($!)
for _ in $(seq 60); do
  [[ $(sinfo -h -o %T 2>/dev/null) == idle ]] && break
  sleep 1
done
[[ $(sinfo -h -o %T) == idle ]] || { echo "the node does not come up"; cat slurmctld.log slurmd.log; exit 1; }

submit() { sbatch --parsable --array=1-4 --cpus-per-task=1 --mem=0 "$examples/shards.sbatch" "$folder/scans" "$folder/out"; }
until_empty() { while [[ -n $(squeue -h) ]]; do sleep 0.5; done; }
job=$(submit)
until [[ -n $(squeue -h -t R -j "${job}_2" 2>/dev/null) ]]; do sleep 0.1; done
sleep 1
scancel -s KILL "${job}_2"
until_empty
done_first=$(ls out/shard-*/result.h5 2>/dev/null | wc -l)
echo "$done_first of 4 shards after one was killed"
[[ $done_first -eq 3 ]]
job=$(submit)
sbatch --dependency=afterok:"$job" --mem=0 "$examples/merge.sbatch" "$folder/out" >/dev/null
until_empty
"$MICROBRDF" run scans -o single --without pictures >/dev/null
/usr/bin/python3 - out/result.h5 single/result.h5 <<'PYTHON'
import sys
import h5py
import numpy

merged, single = (h5py.File(path) for path in sys.argv[1:])
assert list(merged["scans"]) == list(single["scans"]) and len(single["scans"]) == 24
for k in single["scans"]:
    assert merged["scans"][k].attrs["source"] == single["scans"][k].attrs["source"]
assert list(merged["ndf"]) == list(single["ndf"]) and list(merged["fit"]) == list(single["fit"])
for name, ndf in single["ndf"].items():
    a, b = merged["ndf"][name]["density"][:], ndf["density"][:]
    assert abs(a - b).max() <= 1e-6 * b.max(), name  # tables are float32
    assert abs(merged["ndf"][name].attrs["area_um2"] / ndf.attrs["area_um2"] - 1) < 1e-12
print("the merged result is that of the single run")
PYTHON
