#!/usr/bin/env bash
# From nothing to the table and the plots: sets up, builds, runs scenes/kr6_demo.toml.
# Further arguments go to `fricid run`.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/build.sh release fricid
exec build/release/cli/fricid run scenes/kr6_demo.toml -o run/kr6_demo "$@"
