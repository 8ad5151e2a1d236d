#!/usr/bin/env bash
# The leaderboard of real arms: fetches their public logs into DIR (those that are not there), runs every arm and the
# other tools, and prints the table (docs/real_arms.md): scripts/real_logs.sh DIR [SNAKEMAKE OPTIONS...],
# e.g. --cores 2 --config arms=ur10. FRICID_REALLOGS_URL names a server that has all files as FOLDER/FILE.
set -euo pipefail
[ $# -gt 0 ] || { sed -n '2,4s/^# //p' "$0" >&2; exit 2; }
mkdir -p "$1"
logs=$(realpath "$1")
shift
cd "$(dirname "$0")/.."

scripts/setup.sh python3-venv

config=() options=() arms=
while [ $# -gt 0 ]; do
  case $1 in
    --config)
      shift
      while [ $# -gt 0 ] && [[ $1 != -* ]]; do
        case $1 in arms=*) arms=${1#arms=} ;; *) config+=("$1") ;; esac
        shift
      done ;;
    *) options+=("$1"); shift ;;
  esac
done
[ ${#options[@]} -gt 0 ] || options=(--cores "$(nproc)")
arms=$(python3 scenes/real_logs/fetch.py "$logs" ${arms//,/ })

fricid=${FRICID_PROGRAM:-build/release/cli/fricid}
[ -x "$fricid" ] || scripts/build.sh release fricid
tools=${FRICID_BENCHMARK_TOOLS:-build/benchmark-tools}
scripts/venv.sh "$tools" scenes/benchmark/requirements.txt
FRICID_REALLOGS=$logs exec "$tools/bin/snakemake" -s scenes/real_logs/Snakefile \
  --config "fricid=$(realpath "$fricid")" "arms=$arms" "${config[@]}" "${options[@]}"
