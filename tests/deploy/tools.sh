#!/usr/bin/env bash
# The exports in the programs that load them (MuJoCo, FMPy, onnxruntime, from PyPI): tools.sh BUILD_TREE [--table].
# With --table it prints every law and modifier with the errors of its exports. Exits with 77 where PyPI cannot be
# reached.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
tree=$(cd "$1" && pwd)
shift
venv=$tree/tools
if ! cmp -s "$here/tools_requirements.txt" "$venv/installed.txt"; then
  rm -rf "$venv"
  "${PYTHON:-python3}" -m venv "$venv"
  if ! "$venv/bin/pip" install -q --disable-pip-version-check -r "$here/tools_requirements.txt"; then
    rm -rf "$venv"
    echo "tests/deploy/tools.sh: the packages of tools_requirements.txt cannot be had" >&2
    exit 77
  fi
  cp "$here/tools_requirements.txt" "$venv/installed.txt"
fi
samples=$(mktemp -d)
trap 'rm -rf "$samples"' EXIT
"$tree/tests/deploy/write_export_samples" "$samples"
export FRICID_SOURCE_DIR=$here/../.. FRICID_PLUGIN=$tree/sim/libfricid_mujoco.so
cd "$samples" # MuJoCo writes a log of its warnings
"$venv/bin/python" "$here/tools_test.py" "$samples" "$@"
