#!/usr/bin/env bash
# Prints a table of docs/doctor.md, within minutes of one core. Arguments after its name go to the program:
#   table.sh doctor [LOGS_PER_KIND] [TEXT] [-v]   what the doctor finds of damage put into some 240 simulated logs
#   table.sh coverage [LOGS_PER_ARM]              how often 95 % intervals hold the truth, on 90 simulated motions
set -euo pipefail
cd "$(dirname "$0")/.."
name=fricid_${1:?doctor or coverage}_table
shift
scripts/build.sh release "$name" >/dev/null
echo "Commit $(git rev-parse --short HEAD), $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1)."
echo
exec taskset -c 0 "build/release/tests/bench/$name" "$@"
