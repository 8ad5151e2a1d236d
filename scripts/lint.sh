#!/usr/bin/env bash
# clang-format on every C++ file, then clang-tidy on every translation unit of the product, or on those given.
# scripts/lint.sh --format: clang-format alone.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/setup.sh clang-format

git ls-files '*.cpp' '*.hpp' | xargs clang-format --dry-run -Werror
[ "${1:-}" != --format ] || exit 0

# One pinned version on every system; it passes over the headers of the system, which halves the time.
scripts/venv.sh build/lint/tools scripts/lint_tools.txt
export PATH=$PWD/build/lint/tools/bin:$PATH

# A tree of its own for each reading, so that nothing waits for build/release or changes it.
[ -f build/release/build.ninja ] || cmake --preset release >/dev/null
mujoco=$(sed -n 's/^MUJOCO_ROOT:PATH=//p' build/release/CMakeCache.txt)
[ -n "$mujoco" ] || ! [ -d build/release/_deps/mujoco ] || mujoco=$PWD/build/release/_deps/mujoco
configure() { # configure NAME SOURCES OPTION...: build/lint/NAME and its compile commands for clang, without what g++ alone knows
  cmake -S "$2" -B "build/lint/$1" -G Ninja -DFRICID_BUILD_TESTS=OFF -DFRICID_UNITY_BUILD=OFF -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON -DCMAKE_EXPORT_COMPILE_COMMANDS=ON -DMUJOCO_ROOT="$mujoco" "${@:3}" >/dev/null
  cmake --build "build/lint/$1" --target fricid_version >/dev/null
  sed -i -E 's/ -m(move|store)-max=[0-9]+//g; s/ --param=ggc-[^ ]+//g' "build/lint/$1/compile_commands.json"
}
configure units .
# The Python module is a project of its own; its units are read alone.
if scripts/venv.sh build/python/tools python/build_tools.txt; then
  configure python python -Dnanobind_DIR="$(build/python/tools/bin/python -m nanobind --cmake_dir)"
else
  echo "scripts/lint.sh: python/src is not read" >&2
fi
# clang counts what it suppressed in system headers on stderr; findings are on stdout
tidy() {
  local database=units
  case ${1#"$PWD"/} in python/*) database=python ;; esac
  clang-tidy -p "build/lint/$database" --quiet "$1" 2>/dev/null
}

# Units of a library are read together, by CMake's unity files, so that Eigen and the standard library are
# read and matched once for some ten units. Units whose names collide are read alone; so are all units of a batch
# with a finding, and that reading decides. Shadowing between units is no finding; inside one g++ sees it.
together() {
  clang-tidy -p build/lint/batches --quiet --extra-arg=-Wno-shadow \
    --header-filter='/(ident|sim|render|deploy|cli|workflow)/[^:]*\.[ch]pp$' "$1" 2>/dev/null
}
tidy_batch() {
  local units unit failed=0 alone= found collide
  units=$(sed -n 's|^#include "\(/[^"]*\)".*|\1|p' "$1")
  [ -n "$units" ] || { tidy "$1"; return; }
  while found=$(together "$1")
        collide=$(sed -n 's|^\(/[^:]*\.cpp\):.* error: .*\[clang-diagnostic-error\]$|\1|p' <<<"$found" | sort -u)
        [ -n "$collide" ] && grep -qF "$collide" "$1"; do
    for unit in $collide; do sed -i "\|\"$unit\"|d" "$1"; done
    alone+=" $collide"
  done
  [ -z "$found" ] || alone=$units
  for unit in $alone; do tidy "$unit" || failed=1; done
  return $failed
}
export -f tidy together tidy_batch

if [ $# -gt 0 ]; then
  printf '%s\0' "$@" | xargs -0 -P "$(nproc)" -I{} bash -c 'tidy {}'
  exit
fi
configure batches . -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=12
find build/lint/batches -name 'unity_*.cxx' -exec \
  sed -i -E 's|^#include "[^"]*"$|& // NOLINT(bugprone-suspicious-include)|' {} +
mapfile -t batches < <(sed -n 's/^ *"file": "\(.*\)".*/\1/p' build/lint/batches/compile_commands.json)

# every unit of the product is in a batch
missing=$(comm -23 \
  <(git ls-files 'ident/*.cpp' 'sim/*.cpp' 'render/*.cpp' 'deploy/*.cpp' 'cli/*.cpp' 'workflow/*.cpp' | sed "s|^|$PWD/|" | sort) \
  <({ printf '%s\n' "${batches[@]}"; sed -n 's|^#include "\(/[^"]*\)".*|\1|p' "${batches[@]}"; } | sort))
[ -z "$missing" ] || { echo "scripts/lint.sh: in no target of the build: $missing" >&2; exit 1; }
[ ! -f build/lint/python/build.ninja ] || mapfile -t -O ${#batches[@]} batches < <(git ls-files 'python/src/*.cpp' | sed "s|^|$PWD/|")
printf '%s\0' "${batches[@]}" | xargs -0 -P "$(nproc)" -I{} bash -c 'tidy_batch {}'
