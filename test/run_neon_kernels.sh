#!/bin/sh
# Cross-compiles the matching kernels for 64-bit ARM and compares them with a double loop in an emulator.
# usage: run_neon_kernels.sh BUILD_DIR; exit status 77 (skipped) where the compiler or the emulator is missing.
set -eu

for tool in aarch64-linux-gnu-g++ qemu-aarch64; do
  if ! command -v "$tool" >/dev/null; then
    echo "skipped: $tool is not installed"
    exit 77
  fi
done

source=$(cd "$(dirname "$0")/.." && pwd)
core="$source/src/core"
program="$1/hamming_kernels_check_aarch64"
aarch64-linux-gnu-g++ -std=c++17 -O2 -Wall -Wextra -ffp-contract=off -static -I "$source/include" -I "$core" \
  "$source/test/hamming_kernels_check.cpp" "$core/simd.cpp" "$core/matching/hamming_kernels.cpp" \
  "$core/matching/hamming_portable.cpp" "$core/matching/hamming_neon.cpp" -o "$program"
status=0
qemu-aarch64 "$program" >"$program.log" || status=$?
cat "$program.log"
[ "$status" -eq 0 ] || exit 1
grep -q '^neon equals' "$program.log"
