#!/bin/sh
# A Slurm of one node on this machine, without systemd, from Debian's packages (as root):
#   apt-get install slurm-wlm munge
#   tests/cluster/slurm.sh start FOLDER     keys, logs and state go to FOLDER
#   tests/cluster/slurm.sh stop FOLDER
# Snakemake's plugin submits with an environment of its own, so the configuration lies where Slurm
# looks first. One that is there already, and is not this script's, is not touched. The node has one
# GPU in name, so that jobs may ask for it. No limit of time is short: a busy machine is slow.
set -eu
action=${1:?start or stop}
folder=${2:?a folder for keys, logs and state}
node=$(hostname -s)
conf=/etc/slurm/slurm.conf
# nproc would take OMP_NUM_THREADS for them; a job that asks for two must find them on any machine.
cpus=$(getconf _NPROCESSORS_ONLN)
[ "$cpus" -gt 1 ] || cpus=2

ours() {
    grep -q "^ClusterName=vibrom" "$conf" 2> /dev/null
}

# The daemons of FOLDER with all that they run, and their configuration.
stop() {
    ours && scancel --quiet --partition=all 2> /dev/null || true
    for name in slurmd slurmctld munged; do
        pid=$(cat "$1/$name.pid" 2> /dev/null) || continue
        grep -q "$name" "/proc/$pid/cmdline" 2> /dev/null || continue
        kill "$pid" 2> /dev/null || true
        for _ in $(seq 60); do
            kill -0 "$pid" 2> /dev/null || break
            sleep 0.5
        done
    done
    if ours; then rm -f "$conf" /etc/slurm/gres.conf; fi
}

case $action in
start)
    if [ -f "$conf" ] && ! ours; then
        echo "$conf is there already, and not this script's: this machine has a Slurm" >&2
        exit 1
    fi
    # What an interrupted run left would hold the ports.
    if ours; then stop "$(sed -n 's/^StateSaveLocation=\(.*\)\/state$/\1/p' "$conf")"; fi
    mkdir -p "$folder/state" "$folder/spool" /etc/slurm
    chmod 755 "$folder"
    [ -f "$folder/munge.key" ] || { head -c 1024 /dev/urandom > "$folder/munge.key"; chmod 400 "$folder/munge.key"; }
    cat > "$conf" << CONF
ClusterName=vibrom
SlurmctldHost=$node(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$folder/munge.socket
CredType=cred/munge
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
ReturnToService=2
MpiDefault=none
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
MinJobAge=3600
MessageTimeout=100
TCPTimeout=60
SlurmdTimeout=0
SlurmdParameters=config_overrides
BatchStartTimeout=600
UnkillableStepTimeout=600
GresTypes=gpu
NodeName=$node NodeAddr=127.0.0.1 CPUs=$cpus RealMemory=$(free -m | awk '/^Mem/ { print int($2 * 0.95) }') Gres=gpu:1 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
    echo "NodeName=$node Name=gpu File=/dev/zero" > /etc/slurm/gres.conf
    munged --force --key-file="$folder/munge.key" --socket="$folder/munge.socket" \
        --pid-file="$folder/munged.pid" --log-file="$folder/munged.log" --seed-file="$folder/munged.seed"
    slurmctld -c
    slurmd
    for _ in $(seq 300); do
        # `idle*` would be a node that does not answer.
        sinfo -h -o %T 2> /dev/null | grep -qx idle && exit 0
        sleep 1
    done
    echo "the node does not come up; see $folder/slurmctld.log and slurmd.log" >&2
    exit 1
    ;;
stop)
    stop "$folder"
    ;;
*)
    echo "$action: start or stop" >&2
    exit 2
    ;;
esac
