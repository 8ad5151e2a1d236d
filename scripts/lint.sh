#!/usr/bin/env bash
# clang-format on every C++ file, then clang-tidy on every translation unit of the product, or on those given.
# scripts/lint.sh --format: clang-format alone.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/setup.sh clang-format clang-tidy

git ls-files '*.cpp' '*.hpp' | xargs clang-format --dry-run -Werror
[ "${1:-}" != --format ] || exit 0

scripts/build.sh release fricid_version
units=("$@")
[ ${#units[@]} -gt 0 ] || mapfile -t units < <(git ls-files 'ident/*.cpp' 'sim/*.cpp' 'render/*.cpp' 'cli/*.cpp')
# clang counts what it suppressed in system headers on stderr; findings are on stdout
printf '%s\n' "${units[@]}" | xargs -P "$(nproc)" -n 1 clang-tidy -p build/release --quiet 2>/dev/null
