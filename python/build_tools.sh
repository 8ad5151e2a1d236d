#!/usr/bin/env bash
# Puts the tools that build the Python package (python/build_tools.txt, from PyPI) into build/python/tools.
# Exits with 77 when they cannot be had.
set -euo pipefail
cd "$(dirname "$0")/.."
tools=build/python/tools
cmp -s python/build_tools.txt "$tools/installed.txt" && exit
rm -rf "$tools"
"${PYTHON:-python3}" -m venv "$tools"
if ! "$tools/bin/pip" install -q --disable-pip-version-check -r python/build_tools.txt; then
  rm -rf "$tools"
  echo "the tools of python/build_tools.txt cannot be had" >&2
  exit 77
fi
cp python/build_tools.txt "$tools/installed.txt"
