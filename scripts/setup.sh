#!/usr/bin/env bash
# Installs the missing ones of scripts/packages.txt and of the packages given. Without root it prints the
# line to run.
set -euo pipefail
cd "$(dirname "$0")/.."

missing=()
for package in $(grep -v '^#' scripts/packages.txt) "$@"; do
  dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' ||
    missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0

if [ "$(id -u)" -ne 0 ]; then
  echo "packages are missing; run:  sudo apt-get install --no-install-recommends ${missing[*]}" >&2
  exit 2
fi
echo "installing ${#missing[@]} packages" >&2
apt-get update -q >/dev/null
DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "${missing[@]}" >/dev/null
