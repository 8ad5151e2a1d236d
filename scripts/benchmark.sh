#!/usr/bin/env bash
# Runs the benchmark of scenes/benchmark by Snakemake, which is installed beside the build on first
# use: scripts/benchmark.sh [SNAKEMAKE OPTIONS...], e.g. --cores 2 --config truths=kr6_gms seeds=1-3
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/setup.sh python3-venv

tools=${FRICID_BENCHMARK_TOOLS:-build/benchmark-tools}
scripts/venv.sh "$tools" scenes/benchmark/requirements.txt
[ $# -gt 0 ] || set -- --cores "$(nproc)"

fricid=${FRICID_PROGRAM:-build/release/cli/fricid}
if ! [ -x "$fricid" ]; then
  scripts/build.sh release fricid
fi
config=("fricid=$(realpath "$fricid")")
options=()
while [ $# -gt 0 ]; do
  case $1 in
    --config) shift; while [ $# -gt 0 ] && [[ $1 != -* ]]; do config+=("$1"); shift; done ;;
    *) options+=("$1"); shift ;;
  esac
done
exec "$tools/bin/snakemake" -s scenes/benchmark/Snakefile --config "${config[@]}" "${options[@]}"
