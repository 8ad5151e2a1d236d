#!/usr/bin/env bash
# Sets up, builds and runs the tests. Further arguments go to ctest, e.g. -L unit or -R LuGre.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/build.sh release
exec ctest --preset release -j "$(nproc)" "$@"
