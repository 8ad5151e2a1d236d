#!/usr/bin/env bash
# The filters of `fricid_bench --benchmark_filter='Bootstrap(Linear|Toy)'` in the Python packages
# particles and cuthbert, versions pinned in requirements.txt, one core. Makes its own virtual
# environment under build/peers. A bench.json (scripts/bench.sh) is shown beside them.
#
#     tests/bench/peers/run.sh [bench.json]
set -euo pipefail
here="$(cd "$(dirname "$0")" && pwd)"
venv="$here/../../../build/peers"
"$here/../../../scripts/venv.sh" "$venv" "$here/requirements.txt"
exec taskset -c 0 "$venv/bin/python" "$here/peers.py" "$@"
