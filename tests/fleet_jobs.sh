#!/bin/bash
# The commands of docs/fleet.md for Slurm, exactly as they stand, on a single-node Slurm of their own on
# loopback (slurm-wlm, munge; root only, since its daemons start the jobs); those for GNU parallel run in
# tests/docs.  Skipped where Slurm cannot be started, and says why.
set -u
cd "$(dirname "$0")/.." || exit 1
. tests/ok.bash
for program in munged slurmctld slurmd sbatch; do
    PATH=$PATH:/usr/sbin:/sbin command -v $program >/dev/null || skip "fleet_jobs: no $program (Debian: slurm-wlm munge)"
done
[ "$(id -u)" -eq 0 ] || skip "fleet_jobs: not root"
PATH=${mukca%/*}:$PATH:/usr/sbin:/sbin
chmod 755 "$dir"
daemons=
stop() {
    kill $daemons 2>/dev/null
    wait
    rm -rf "$dir"
}
trap stop EXIT

# ---- the cluster: keys, state and sockets in a folder of its own, ports that nobody uses
mkdir -m 700 "$dir/munge" "$dir/state" "$dir/spool"
mkdir -m 755 "$dir/socket"
head -c 1024 /dev/urandom >"$dir/munge/key"
chmod 600 "$dir/munge/key"
port=$((20000 + $$ % 20000))
node=$(hostname -s)
cat >"$dir/slurm.conf" <<CONF
ClusterName=mukca$$
SlurmctldHost=$node(127.0.0.1)
SlurmctldPort=$port
SlurmdPort=$((port + 1))
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$dir/socket/munge
StateSaveLocation=$dir/state
SlurmdSpoolDir=$dir/spool
SlurmctldPidFile=$dir/slurmctld.pid
SlurmdPidFile=$dir/slurmd.pid
SlurmctldLogFile=$dir/slurmctld.log
SlurmdLogFile=$dir/slurmd.log
ProctrackType=proctrack/linuxproc
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
NodeName=$node NodeAddr=127.0.0.1 CPUs=2 RealMemory=1000 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=60 State=UP
CONF
export SLURM_CONF=$dir/slurm.conf
munged --foreground --force --key-file="$dir/munge/key" --socket="$dir/socket/munge" --pid-file="$dir/munge/pid" \
    --log-file="$dir/munge/log" --seed-file="$dir/munge/seed" >"$dir/munged.out" 2>&1 &
daemons=$!
sleep 1
slurmctld -D -f "$dir/slurm.conf" >"$dir/slurmctld.out" 2>&1 &
daemons="$daemons $!"
# slurmd loads a plugin for control groups even where none are used; which one there is depends on the kernel
ready=
for plugin in disabled cgroup/v1 cgroup/v2; do
    echo "CgroupPlugin=$plugin" >"$dir/cgroup.conf"
    slurmd -D -f "$dir/slurm.conf" -N "$node" >"$dir/slurmd.out" 2>&1 &
    slurmd=$!
    daemons="$daemons $slurmd"
    for _ in $(seq 30); do
        case $(sinfo -h -o %T 2>/dev/null) in idle | mixed) ready=1 && break 2 ;; esac
        kill -0 $slurmd 2>/dev/null || break
        sleep 1
    done
done
[ -n "$ready" ] || skip "fleet_jobs: Slurm does not start: $(cat "$dir"/*.out "$dir"/slurm*.log 2>/dev/null | grep -iE 'error|fatal' | tail -n 1)"

# ---- the commands: the first block makes the data, the block in `bash` is Slurm's
cp -r data docs "$dir"
cd "$dir" || exit 1
block() { # KIND NUMBER: of docs/fleet.md
    awk -v fence="\`\`\`$1" -v want="$2" '$0 == fence { n++; on = n == want; next } /^```/ { on = 0 } on' docs/fleet.md
}
block sh 1 >data.sh
block bash 1 >jobs.sh
bash -eu data.sh || { echo "not ok the data of docs/fleet.md"; exit 1; }
bash -eu jobs.sh >jobs.out 2>&1 || { echo "not ok sbatch as in docs/fleet.md"; cat jobs.out; exit 1; }
for _ in $(seq 240); do
    [ -n "$(squeue -h)" ] || break
    sleep 1
done
ok "the array job and the dependent pooling of docs/fleet.md on Slurm" \
    grep -q "^Departs arm7: joint compliance at joint_4" build/fleet/slurm-fleet.log
[ $failed = 0 ] || { squeue; tail -n 5 build/fleet/*.log slurmctld.log slurmd.log; }
mukca fleet -q build/fleet/arm*/session.json -o once.tsv
ok "Slurm gives the same bytes as one process" cmp once.tsv build/fleet/heron7.traits.tsv
exit $failed
