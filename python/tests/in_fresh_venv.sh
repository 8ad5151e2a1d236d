#!/usr/bin/env bash
# Builds the wheel on the compiled libraries of a build tree, installs it into a new virtual environment and runs the
# tests of the package there: in_fresh_venv.sh BUILD_TREE [pytest options...]. Exits with 77 where PyPI cannot be reached.
set -euo pipefail
cd "$(dirname "$0")/../.."
tree=$(cd "$1" && pwd)
shift
work=$tree/python
rm -rf "$work/prefix" "$work/wheel" "$work/venv"
cmake --install "$tree" --prefix "$work/prefix" >/dev/null
FRICID_PREFIX=$work/prefix scripts/wheel.sh "$work/wheel"

"${PYTHON:-python3}" -m venv "$work/venv"
if ! "$work/venv/bin/pip" install -q --disable-pip-version-check -r python/tests/requirements.txt; then
  echo "python/tests: the packages of requirements.txt cannot be had" >&2
  exit 77
fi
"$work/venv/bin/pip" install -q --disable-pip-version-check --no-deps "$work"/wheel/*.whl

export FRICID_PROGRAM=$tree/cli/fricid FRICID_SOURCE_DIR=$PWD FRICID_WHEEL=$(echo "$work"/wheel/*.whl)
cd "$work" # not where a folder of sources is called fricid
exec venv/bin/python -m pytest -q -p no:cacheprovider "$FRICID_SOURCE_DIR/python/tests" "$@"
