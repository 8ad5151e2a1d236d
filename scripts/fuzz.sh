#!/usr/bin/env bash
# Feeds the readers of files from others with damaged ones: libFuzzer under the address and
# undefined-behaviour sanitizers. Inputs that reached something new are kept in build/fuzz/corpus/TARGET.
# Usage: scripts/fuzz.sh [RUNS] [TARGET...]     default 1000000 of hdf5, log, scene, contract, urdf, model, artefact
# Without clang++ it says so and does nothing.
set -euo pipefail
cd "$(dirname "$0")/.."
runs=${1:-1000000}
shift || true
targets=("$@")
[ $# -gt 0 ] || targets=(hdf5 log scene contract urdf model artefact)

clang=$(command -v clang++ || compgen -c clang++- | sort -V | tail -1 || true)
probe='extern "C" int LLVMFuzzerTestOneInput(const unsigned char*, unsigned long) { return 0; }'
if [ -z "$clang" ] || ! echo "$probe" | "$clang" -fsanitize=fuzzer -x c++ - -o /dev/null 2>/dev/null; then
  echo "skipped: scripts/fuzz.sh needs clang++ with libFuzzer"
  exit 0
fi

if [ ! -f build/fuzz/build.ninja ]; then
  mujoco=$(sed -n 's/^MUJOCO_ROOT:PATH=//p' build/release/CMakeCache.txt 2>/dev/null || true)
  [ -n "$mujoco" ] || ! [ -d build/release/_deps/mujoco ] || mujoco=$PWD/build/release/_deps/mujoco
  cmake --preset fuzz -DCMAKE_CXX_COMPILER="$clang" -DCMAKE_C_COMPILER="${clang/++/}" -DMUJOCO_ROOT="$mujoco" >/dev/null
fi
cmake --build build/fuzz --target "${targets[@]/%/_fuzz}" | tail -1
scripts/build.sh release write_corpus | tail -1
build/release/tests/fuzz/write_corpus build/fuzz/seeds

# All targets beside each other, as many as there are cores. A target works in a folder of its own: its paths are whole.
fuzz_one() {
  local target=$1 runs=$2 fuzz=$PWD/build/fuzz
  local log=$fuzz/$target.log
  mkdir -p "$fuzz/corpus/$target" "$fuzz/found/$target"
  # HDF5 files are tried in a process that crashes often: symbols would take seconds each time, and a small image is
  # soon copied. The library asks for whatever a file says, which no machine has.
  local options=(-use_value_profile=1)
  if [ "$target" = hdf5 ]; then
    options=(-malloc_limit_mb=1000000)
    export ASAN_OPTIONS=symbolize=0:quarantine_size_mb=16:allocator_may_return_null=1
  fi
  LSAN_OPTIONS=suppressions=$PWD/cmake/leaks_of_others.txt nice "$fuzz/tests/fuzz/${target}_fuzz" -runs="$runs" -max_len=16384 -seed=1 -timeout=60 -rss_limit_mb=2048 "${options[@]}" \
    -print_final_stats=1 -artifact_prefix="$fuzz/found/$target/" \
    "$fuzz/corpus/$target" "$fuzz/seeds/$target" >"$log" 2>&1 || { tail -60 "$log"; echo "FAILED: $target: $log"; return 1; }
  echo "$target: $(sed -n 's/^stat::number_of_executed_units: *//p' "$log") runs, $(sed -n 's/^stat::average_exec_per_sec: *//p' "$log") per second"
}
export -f fuzz_one
printf '%s\n' "${targets[@]}" | xargs -P "$(nproc)" -I{} bash -c 'fuzz_one {} '"$runs"
