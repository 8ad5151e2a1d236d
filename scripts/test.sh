#!/usr/bin/env bash
# Sets up, builds and runs the tests. Further arguments go to ctest, e.g. -L unit or -R LuGre.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/build.sh release
# one more than there are cores: some tests wait for processes or clocks
exec ctest --preset release -j "$(($(nproc) + 1))" "$@"
