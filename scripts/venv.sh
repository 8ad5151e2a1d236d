#!/usr/bin/env bash
# A virtual environment with the Python packages of a requirements file: scripts/venv.sh FOLDER REQUIREMENTS [UNUSED...]
# It is made when it is not there or was made for other requirements. Unused parts of the packages (paths in
# site-packages) are deleted. Exits with 77 where PyPI cannot be reached.
set -euo pipefail
folder=$1 requirements=$2
shift 2
mkdir -p "$(dirname "$folder")"
exec 9>"$folder.lock"
flock 9  # two jobs that need it at once
if ! cmp -s "$requirements" "$folder/installed.txt"; then
  rm -rf "$folder"
  "${PYTHON:-python3}" -m venv "$folder"
  if ! "$folder/bin/pip" install -q --disable-pip-version-check -r "$requirements"; then
    rm -rf "$folder"
    echo "the packages of $requirements cannot be had from PyPI" >&2
    exit 77
  fi
  cp "$requirements" "$folder/installed.txt"
fi
for unused in "$@"; do
  rm -rf "$folder"/lib/python*/site-packages/"$unused"
done
