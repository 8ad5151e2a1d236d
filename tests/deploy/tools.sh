#!/usr/bin/env bash
# The exports in the programs that load them (MuJoCo, FMPy, onnxruntime, Pinocchio, from PyPI): tools.sh BUILD_TREE [--table].
# With --table it prints every law and modifier with the errors of its exports. Exits with 77 where PyPI cannot be
# reached.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
tree=$(cd "$1" && pwd)
shift
venv=$tree/tools
# Pinocchio brings the headers of its libraries, FMPy a CMake for FMUs without a binary
"$here/../../scripts/venv.sh" "$venv" "$here/tools_requirements.txt" cmeel.prefix/include cmake
samples=$(mktemp -d)
trap 'rm -rf "$samples"' EXIT
"$tree/tests/deploy/write_export_samples" "$samples"
export FRICID_SOURCE_DIR=$here/../.. FRICID_PLUGIN=$tree/sim/libfricid_mujoco.so
cd "$samples" # MuJoCo writes a log of its warnings
"$venv/bin/python" "$here/tools_test.py" "$samples" "$@"
