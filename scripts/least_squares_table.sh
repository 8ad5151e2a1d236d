#!/usr/bin/env bash
# Prints the table of docs/benchmark.md: the model simple beside an independent least squares, differences in per
# cent, bold where they are beyond 3 % and two standard errors. With FRICID_REALLOGS the public log of the UR10 too.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/build.sh release fricid >/dev/null
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
echo "Commit $(git rev-parse --short HEAD), $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1)."
echo
echo "| log | joint 1 Fc, Fv | 2 | 3 | 4 | 5 | 6 |"
echo "|---|--:|--:|--:|--:|--:|--:|"
row() { # NAME SCENE URDF; 1: a fit that is not to be trusted, or a difference
  build/release/cli/fricid identify "$2" --model simple -o "$folder/$1" --quiet >/dev/null || [ $? -eq 1 ]
  tests/bench/peers/least_squares.sh "$folder/$1" "$3" --row "$1" || [ $? -eq 1 ]
}
row kr6_demo scenes/kr6_demo.toml models/kr6_r700/kr6_r700.urdf
row tiny tests/e2e/tiny.toml models/kr6_r700/kr6_r700.urdf
[ -z "${FRICID_REALLOGS:-}" ] || row ur10 scenes/ur10.toml "$FRICID_REALLOGS/ur10_unisa_2025/ur10_robot.urdf"
