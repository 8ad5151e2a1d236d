#!/usr/bin/env bash
# Ranks what a build spent its time on, from .ninja_log: the sum and the longest units of the program, the tests
# and the benchmarks. Usage: scripts/build_times.sh [BUILD_TREE] [COUNT]
# Seconds of the wall clock, with what else ran on the machine; units from the compiler cache take none.
set -euo pipefail
cd "$(dirname "$0")/.."
tree=${1:-build/release}
count=${2:-15}
[ -f "$tree/.ninja_log" ] || { echo "scripts/build_times.sh: no $tree/.ninja_log; build first" >&2; exit 2; }

echo "$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1), $(nproc) cores, $(git rev-parse --short HEAD)"
# part, seconds, unit; the last compile of a unit counts
awk -F '\t' '
  /^#/ || $4 !~ /\.(o|gch)$/ { next }
  { seconds[$4] = ($2 - $1) / 1000 }
  END {
    for (unit in seconds) {
      part = unit ~ /^tests\/bench\// ? "benchmarks" : unit ~ /^tests\// ? "tests" : "program"
      name = unit
      sub(/CMakeFiles\/[^\/]*\.dir\//, "", name)
      sub(/\.o$/, "", name)
      printf "%s\t%.1f\t%s\n", part, seconds[unit], name
    }
  }' "$tree/.ninja_log" | sort -t $'\t' -k1,1 -k2,2nr | awk -F '\t' -v count="$count" '
  $1 != part { if (part) print_sum(); part = $1; sum = units = 0 }
  { sum += $2; if (++units <= count) printf "%8.1f s  %s\n", $2, $3 }
  function print_sum() { printf "%8.0f s  in all: %d units of the %s\n\n", sum, units, part }
  END { if (part) print_sum() }'
