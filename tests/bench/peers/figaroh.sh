#!/usr/bin/env bash
# figaroh (versions pinned in requirements_figaroh.txt) on the training data of a run: torque along the held-out motion.
# Makes its own virtual environment under build/peers_figaroh.
#
#     tests/bench/peers/figaroh.sh RUN URDF --predict OUT
#
# FRICID names the program; by default build/release/cli/fricid.
set -euo pipefail
here="$(cd "$(dirname "$0")" && pwd)"
build="$here/../../../build"
venv="$build/peers_figaroh"
"$here/../../../scripts/venv.sh" "$venv" "$here/requirements_figaroh.txt"
exec "$venv/bin/python" "$here/figaroh_peer.py" "$@" --program "${FRICID:-$build/release/cli/fricid}"
