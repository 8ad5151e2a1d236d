#!/usr/bin/env bash
# Runs a command under a Slurm that lives on this machine alone, for as long as the command takes:
# scripts/slurm_on_localhost.sh scripts/benchmark.sh --executor slurm --jobs 2 ...
# Needs root (or sudo) and the Debian packages slurm-wlm and munge, which it installs.
set -euo pipefail
cd "$(dirname "$0")/.."
[ $# -gt 0 ] || { echo "usage: $0 COMMAND..." >&2; exit 2; }

scripts/setup.sh slurm-wlm munge
root=$([ "$(id -u)" = 0 ] || echo sudo)

if [ -e /etc/slurm/slurm.conf ]; then
  echo "this machine has a Slurm already (/etc/slurm/slurm.conf): use that" >&2
  exit 2
fi

# One node, one partition, no accounting; state in a folder that goes away with the command.
state=$(mktemp -d)
host=$(hostname -s)
cores=$(nproc)
cat > "$state/slurm.conf" <<CONF
ClusterName=localhost
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
StateSaveLocation=$state/ctld
SlurmdSpoolDir=$state/spool
SlurmctldPidFile=$state/slurmctld.pid
SlurmdPidFile=$state/slurmd.pid
SlurmctldLogFile=$state/slurmctld.log
SlurmdLogFile=$state/slurmd.log
AuthType=auth/munge
AuthInfo=socket=$state/munge.socket
CredType=cred/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
MinJobAge=300
NodeName=$host NodeAddr=127.0.0.1 CPUs=$cores RealMemory=$(($(awk '/MemTotal/{print $2}' /proc/meminfo) / 1024 - 100))
PartitionName=main Nodes=$host Default=YES MaxTime=INFINITE State=UP
CONF
$root install -d -m 755 "$state/ctld" "$state/spool" "$state/munge"
head -c 1024 /dev/urandom | $root tee "$state/munge/munge.key" > /dev/null
$root chmod 600 "$state/munge/munge.key"
chmod 755 "$state"

stop() {
  $root rm -f /etc/slurm/slurm.conf
  for daemon in slurmd slurmctld munged; do
    [ -s "$state/$daemon.pid" ] || continue
    pid=$(cat "$state/$daemon.pid")
    $root kill "$pid" || continue
    while [ -e "/proc/$pid" ]; do sleep 0.2; done
  done
  $root rm -rf "$state"
}
trap stop EXIT

$root mkdir -p /etc/slurm
$root ln -s "$state/slurm.conf" /etc/slurm/slurm.conf  # where steps of a job look for it
$root munged --key-file "$state/munge/munge.key" --socket "$state/munge.socket" \
  --pid-file "$state/munged.pid" --log-file "$state/munged.log" --seed-file "$state/munge.seed" --force
$root slurmctld
$root slurmd
for _ in $(seq 30); do
  sinfo --noheader --format=%T 2> /dev/null | grep -q idle && break
  sleep 1
done
sinfo --noheader --format=%T | grep -q idle || { cat "$state"/*.log >&2; exit 1; }

"$@"
