#!/bin/sh
# A Slurm of one node on this machine, without systemd, from Debian's packages (as root):
#   apt-get install slurm-wlm munge
#   tests/cluster/slurm.sh start FOLDER     keys, logs and state go to FOLDER
#   tests/cluster/slurm.sh stop FOLDER
# Snakemake's plugin submits with an environment of its own, so the configuration lies where Slurm
# looks first. One that is there already is not touched.
set -eu
action=${1:?start or stop}
folder=${2:?a folder for keys, logs and state}
node=$(hostname -s)
conf=/etc/slurm/slurm.conf
case $action in
start)
    if [ -f "$conf" ] && ! grep -q "^ClusterName=vibrom" "$conf"; then
        echo "$conf is there already, and not this script's: this machine has a Slurm" >&2
        exit 1
    fi
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
MinJobAge=300
NodeName=$node NodeAddr=127.0.0.1 CPUs=$(nproc) RealMemory=$(free -m | awk '/^Mem/ { print int($2 * 0.95) }') State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
    munged --force --key-file="$folder/munge.key" --socket="$folder/munge.socket" \
        --pid-file="$folder/munged.pid" --log-file="$folder/munged.log" --seed-file="$folder/munged.seed"
    slurmctld -c
    slurmd
    for _ in 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15; do
        sinfo -h -o %T | grep -q idle && exit 0
        sleep 1
    done
    echo "the node does not come up; see $folder/slurmd.log" >&2
    exit 1
    ;;
stop)
    for name in slurmd slurmctld munged; do
        kill "$(cat "$folder/$name.pid")" 2> /dev/null || true
    done
    grep -q "^ClusterName=vibrom" "$conf" 2> /dev/null && rm -f "$conf"
    ;;
*)
    echo "$action: start or stop" >&2
    exit 2
    ;;
esac
