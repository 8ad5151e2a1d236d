#!/usr/bin/env bash
# Uses the viewer in a window of a virtual display under the address and undefined-behaviour
# sanitizers. After scripts/test.sh, which sets up and configures.
set -euo pipefail
cd "$(dirname "$0")/.."
cmake --build --preset release --target viewer_sanitized_test
exec ctest --preset release -C Sanitized -R '^viewer_sanitized_test_in_a_window$' --no-tests=error
