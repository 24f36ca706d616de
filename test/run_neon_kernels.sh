#!/bin/sh
# Cross-compiles the kernels of matching, extraction and robust estimation for 64-bit ARM and compares them with plain
# code in an emulator.
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
build=$1

# check NAME SOURCE...: builds test/NAME.cpp with the sources of the core and runs it; it must have compared NEON.
check() {
  program="$build/$1_aarch64"
  main="$source/test/$1.cpp"
  shift
  aarch64-linux-gnu-g++ -std=c++17 -O2 -Wall -Wextra -ffp-contract=off -static -I "$source/include" -I "$core" \
    -I "$source/test" "$main" "$core/simd.cpp" "$@" -o "$program"
  status=0
  qemu-aarch64 "$program" >"$program.log" || status=$?
  cat "$program.log"
  [ "$status" -eq 0 ] || exit 1
  grep -q '^neon equals' "$program.log"
}

check hamming_kernels_check "$core/matching/hamming_kernels.cpp" "$core/matching/hamming_portable.cpp" \
  "$core/matching/hamming_neon.cpp"
check feature_kernels_check "$core/features/kernels.cpp" "$core/features/kernels_scalar.cpp" \
  "$core/features/kernels_neon.cpp" "$core/features/orb_pattern.cpp"
check residual_kernels_check "$core/two_view/kernels/residual_kernels_scalar.cpp" \
  "$core/two_view/kernels/residual_kernels_neon.cpp"
