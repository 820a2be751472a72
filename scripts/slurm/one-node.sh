#!/bin/sh
# A whole Slurm on this machine alone, for trying job arrays, as root. Tried with Slurm 22.05 of Debian 12.
# usage: one-node.sh start DIR | one-node.sh stop DIR      then: export SLURM_CONF=DIR/slurm.conf; sbatch --array=0-3 --wait job.sh
# Needs Debian's slurm-wlm and munge (apt-get install slurm-wlm munge). DIR holds its configuration, state and logs.
set -e
dir=$(mkdir -p "$2" && cd "$2" && pwd); host=$(hostname -s)
case $1 in
start)
  mkdir -p /run/munge "$dir/state" "$dir/spool"; chown munge: /run/munge
  [ -f /etc/munge/munge.key ] || { dd if=/dev/urandom of=/etc/munge/munge.key bs=1 count=1024 2>/dev/null; chown munge: /etc/munge/munge.key; chmod 400 /etc/munge/munge.key; }
  [ -f /run/munge/munged.pid ] && kill -0 "$(cat /run/munge/munged.pid)" 2>/dev/null || su -s /bin/sh munge -c /usr/sbin/munged
  cat > "$dir/slurm.conf" <<CONF
ClusterName=one
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
StateSaveLocation=$dir/state
SlurmdSpoolDir=$dir/spool
SlurmctldPidFile=$dir/slurmctld.pid
SlurmdPidFile=$dir/slurmd.pid
SlurmctldLogFile=$dir/slurmctld.log
SlurmdLogFile=$dir/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
MaxArraySize=10001
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=all Nodes=$host Default=YES MaxTime=INFINITE State=UP
CONF
  export SLURM_CONF=$dir/slurm.conf
  slurmctld -f "$SLURM_CONF"; slurmd -f "$SLURM_CONF"
  for _ in 1 2 3 4 5 6 7 8 9 10; do sinfo -h -o %t 2>/dev/null | grep -q idle && break; sleep 1; done
  sinfo ;;
stop)
  for d in slurmd slurmctld; do
    pid=$(cat "$dir/$d.pid" 2>/dev/null) && kill "$pid" 2>/dev/null || continue
    # They write to DIR until they have ended.
    for _ in 1 2 3 4 5 6 7 8 9 10; do kill -0 "$pid" 2>/dev/null || break; sleep 1; done
  done
  [ -f /run/munge/munged.pid ] && kill "$(cat /run/munge/munged.pid)" || true ;;
*) sed -n 2,5p "$0"; exit 2 ;;
esac
