#!/usr/bin/env bash
# Prints the table of docs/doctor.md: how often 95 % intervals hold the truth, on 90 simulated motions at three rates,
# within minutes of one core. Further arguments go to the program: [LOGS_PER_ARM].
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/build.sh release fricid_coverage_table >/dev/null
echo "Commit $(git rev-parse --short HEAD), $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1)."
echo
exec taskset -c 0 build/release/tests/bench/fricid_coverage_table "$@"
