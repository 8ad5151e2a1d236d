#!/usr/bin/env bash
# Prints the table of docs/doctor.md: what the doctor finds of damage put into some 240 simulated logs, within
# minutes of one core. Further arguments go to the program: [LOGS_PER_KIND] [TEXT] [-v].
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/build.sh release fricid_doctor_table >/dev/null
echo "Commit $(git rev-parse --short HEAD), $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1)."
echo
exec taskset -c 0 build/release/tests/bench/fricid_doctor_table "$@"
