#!/usr/bin/env bash
# clang-format on every C++ file, clang-tidy on every translation unit of the product (or those given).
set -euo pipefail
cd "$(dirname "$0")/.."
for tool in clang-format clang-tidy; do
  command -v $tool >/dev/null || { echo "$tool is missing; run: apt-get install $tool" >&2; exit 2; }
done
mapfile -t sources < <(git ls-files '*.cpp' '*.hpp')
clang-format --dry-run -Werror "${sources[@]}"

[ -f build/release/compile_commands.json ] || cmake --preset release >/dev/null
mapfile -t units < <(if [ $# -gt 0 ]; then printf '%s\n' "$@"; else git ls-files 'ident/*.cpp' 'sim/*.cpp' 'cli/*.cpp'; fi)
printf '%s\n' "${units[@]}" | xargs -P "$(nproc)" -n 1 clang-tidy -p build/release --quiet
