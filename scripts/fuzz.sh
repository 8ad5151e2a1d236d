#!/usr/bin/env bash
# Feeds the readers of logs with damaged files (libFuzzer, address and undefined-behaviour sanitizers).
# Usage: scripts/fuzz.sh [RUNS]        default 1000000; without clang it says so and does nothing
set -euo pipefail
cd "$(dirname "$0")/.."
runs=${1:-1000000}

clang=$(command -v clang++ || compgen -c clang++- | sort -V | tail -1 || true)
probe='extern "C" int LLVMFuzzerTestOneInput(const unsigned char*, unsigned long) { return 0; }'
if [ -z "$clang" ] || ! echo "$probe" | "$clang" -fsanitize=fuzzer -x c++ - -o /dev/null 2>/dev/null; then
  echo "skipped: scripts/fuzz.sh needs clang++ with libFuzzer"
  exit 0
fi

out=build/fuzz
mkdir -p $out/corpus
flags="-std=c++20 -O1 -g -Iident/base/include -Iident/signals/include -Iident/data/include -Iident/data/src -Itests/data
       $(pkg-config --cflags eigen3) -DFMT_HEADER_ONLY"
sources="ident/data/src/logs/columns.cpp ident/data/src/logs/compression.cpp ident/data/src/logs/csv.cpp ident/data/src/logs/kuka_trace.cpp
         ident/data/src/logs/mcap.cpp ident/data/src/logs/rsi.cpp ident/base/src/names.cpp ident/base/src/text.cpp
         ident/base/src/files.cpp ident/base/src/limits.cpp"
sanitize=address,undefined
"$clang" $flags -Iident/friction/include -Iident/dynamics/include tests/fuzz/write_corpus.cpp \
  -lzstd -llz4 -o $out/write_corpus
$out/write_corpus $out/corpus
"$clang" $flags -fsanitize=fuzzer,$sanitize -fno-sanitize-recover=all tests/fuzz/log_fuzz.cpp $sources \
  -lcrypto -lzstd -llz4 -o $out/log_fuzz
$out/log_fuzz -runs="$runs" -max_len=4096 -seed=1 -print_final_stats=1 -artifact_prefix=$out/ $out/corpus
