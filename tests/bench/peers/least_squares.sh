#!/usr/bin/env bash
# Model "simple" of a run beside an independent least squares on the same data (versions pinned in
# requirements_least_squares.txt). Makes its own virtual environment under build/peers_least_squares.
#
#     tests/bench/peers/least_squares.sh RUN URDF [--within 0.03]
#
# FRICID names the program; by default build/release/cli/fricid.
set -euo pipefail
here="$(cd "$(dirname "$0")" && pwd)"
build="$here/../../../build"
venv="$build/peers_least_squares"
"$here/../../../scripts/venv.sh" "$venv" "$here/requirements_least_squares.txt"
exec "$venv/bin/python" "$here/least_squares.py" "$@" --program "${FRICID:-$build/release/cli/fricid}"
