#!/usr/bin/env bash
# Builds the wheel of the Python package: scripts/wheel.sh [FOLDER], default dist. It holds every library that
# is not part of any Linux, so it needs nothing but Python, and their licences.
# FRICID_PREFIX=P takes the libraries of an installed fricid, and so its instruction set, in place of compiling them.
# Exits with 77 when the tools cannot be had from PyPI.
set -euo pipefail
cd "$(dirname "$0")/.."
folder=${1:-dist}
build=build/python
mkdir -p "$folder"
tools=$build/tools
scripts/venv.sh "$tools" python/build_tools.txt
export PATH=$PWD/$tools/bin:$PATH

# The MuJoCo plugin must find the libmujoco that its process has, under its own name.
# HDF5 of Debian is linked to libcurl for files in the cloud, which are never read here: a library of that name
# that refuses takes the place of libcurl and its thirty libraries.
cc -shared -fPIC -O1 -o "$build/libcurl.so.4" -Wl,-soname,libcurl.so.4 \
  -Wl,--version-script=python/no_curl.map python/no_curl.c

raw=$PWD/$build/raw
rm -rf "$raw"
compile() { # a wheel of one instruction set: compile NAME SETTING...
  pip wheel -q --disable-pip-version-check --no-deps --no-build-isolation "-Cbuild-dir=$build/$1" "${@:2}" -w "$raw/$1" .
}
if [ -n "${FRICID_PREFIX:-}" ]; then
  compile prefix "-Ccmake.define.fricid_ROOT=$FRICID_PREFIX"
  merged=$(echo "$raw"/prefix/*.whl)
else
  # the module of each further instruction set joins the first
  for instructions in x86-64-v3 x86-64-v4; do
    compile "$instructions" "-Ccmake.define.FRICID_ARCH=$instructions"
    wheel unpack -d "$raw/$instructions" "$raw/$instructions"/*.whl
  done
  cp "$raw"/x86-64-v4/fricid-*/fricid/_native/_core.* "$raw"/x86-64-v3/fricid-*/fricid/_native/
  wheel pack -d "$raw" "$raw"/x86-64-v3/fricid-*/
  merged=$(echo "$raw"/*.whl)
fi
LD_LIBRARY_PATH=$PWD/$build${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH} \
  auditwheel repair --disable-isa-ext-check --exclude 'libmujoco.so.*' -w "$raw/repaired" "$merged"
wheel unpack -d "$raw/licensed" "$raw"/repaired/*.whl
python python/licences.py "$raw"/licensed/fricid-*
wheel pack -d "$folder" "$raw"/licensed/fricid-*
