#!/usr/bin/env bash
# Attacks the built program with hostile input (tests/attack); what failed is kept in build/attack.
# Usage: scripts/attack.sh [SECONDS] [SEED] [PRESET]        default 60 1 release
set -euo pipefail
cd "$(dirname "$0")/.."
exec nice python3 -B tests/attack/attack.py "build/${3:-release}/cli/fricid" build/attack "${1:-60}" "${2:-1}"
