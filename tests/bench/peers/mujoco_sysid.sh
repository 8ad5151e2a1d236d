#!/usr/bin/env bash
# mujoco.sysid (versions pinned in requirements_sysid.txt) fitted to the training data of a run folder; its row then
# joins the run's table. Makes its own virtual environment under build/peers_sysid. Options: mujoco_sysid.py --help.
#
#     tests/bench/peers/mujoco_sysid.sh RUN [--chunks N]
#
# FRICID names the program; by default build/release/cli/fricid.
set -euo pipefail
here="$(cd "$(dirname "$0")" && pwd)"
build="$here/../../../build"
venv="$build/peers_sysid"
"$here/../../../scripts/venv.sh" "$venv" "$here/requirements_sysid.txt"
"$venv/bin/python" "$here/mujoco_sysid.py" "$@"
exec "${FRICID:-$build/release/cli/fricid}" evaluate "$1"
