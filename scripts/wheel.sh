#!/usr/bin/env bash
# Builds the wheel of the Python package: scripts/wheel.sh [FOLDER], default dist. It holds every library that
# is not part of any Linux, so it needs nothing but Python.
# FRICID_PREFIX=P takes the libraries of an installed fricid, and so its instruction set, in place of compiling them.
# Exits with 77 when the tools cannot be had from PyPI.
set -euo pipefail
cd "$(dirname "$0")/.."
folder=${1:-dist}
build=build/python
python=${PYTHON:-python3}
mkdir -p "$build" "$folder"

tools=$build/tools
if ! cmp -s python/build_tools.txt "$tools/installed.txt"; then
  rm -rf "$tools"
  "$python" -m venv "$tools"
  if ! "$tools/bin/pip" install -q --disable-pip-version-check -r python/build_tools.txt; then
    rm -rf "$tools"
    echo "scripts/wheel.sh: the tools of python/build_tools.txt cannot be had" >&2
    exit 77
  fi
  cp python/build_tools.txt "$tools/installed.txt"
fi
export PATH=$PWD/$tools/bin:$PATH

# HDF5 of Debian is linked to libcurl for files in the cloud, which are never read here: a library of that name
# that refuses takes the place of libcurl and its thirty libraries.
cc -shared -fPIC -O1 -o "$build/libcurl.so.4" -Wl,-soname,libcurl.so.4 \
  -Wl,--version-script=python/no_curl.map python/no_curl.c

raw=$build/raw
rm -rf "$raw"
settings=()
[ -z "${FRICID_PREFIX:-}" ] || settings+=("-Ccmake.define.fricid_ROOT=$FRICID_PREFIX" "-Cbuild-dir=$build/on_prefix")
pip wheel -q --disable-pip-version-check --no-deps --no-build-isolation "${settings[@]}" -w "$raw" .
LD_LIBRARY_PATH=$PWD/$build${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH} \
  auditwheel repair --disable-isa-ext-check -w "$folder" "$raw"/*.whl
