#!/usr/bin/env bash
# Builds and runs the benchmarks on one core; writes bench.json. Further arguments go to the program,
# e.g. --benchmark_filter=BM_Friction.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/build.sh release fricid_bench
exec taskset -c 0 build/release/tests/bench/fricid_bench --benchmark_out=bench.json \
  --benchmark_out_format=json --benchmark_context=commit="$(git rev-parse --short HEAD)" \
  --benchmark_context=cpu="$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1)" "$@"
