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
# what g++ alone knows
mkdir -p build/lint
sed -E 's/ -m(move|store)-max=[0-9]+//g' build/release/compile_commands.json >build/lint/compile_commands.json
# clang counts what it suppressed in system headers on stderr; findings are on stdout
printf '%s\n' "${units[@]}" | xargs -P "$(nproc)" -n 1 clang-tidy -p build/lint --quiet 2>/dev/null
