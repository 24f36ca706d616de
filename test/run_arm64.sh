#!/bin/sh
# Builds for 64-bit ARM and runs in an emulator.
#   kernels: Compares the kernels of matching and extraction bit by bit with those for any processor.
#   core:    Compares every method on recorded images with the statuses and numbers of inliers recorded on x86. It needs
#            that processor's packages, which `scripts/arm64` fetches, and sets of GMS_RANSAC_DATA: the road and a desk,
#            or with `all` every set.
# usage: run_arm64.sh kernels|core BUILD_DIR [all]; exit status 77 (skipped) where something is missing.
set -eu

what=$1
build=$2/arm64_$1
source=$(cd "$(dirname "$0")/.." && pwd)
sysroot=
emulate="qemu-aarch64"

skip() {
  echo "skipped: $*"
  exit 77
}

for tool in aarch64-linux-gnu-g++ qemu-aarch64 cmake ninja; do
  command -v "$tool" >/dev/null || skip "$tool is not installed"
done
if [ "$what" = core ]; then
  sysroot=$source/out/arm64/sysroot
  [ -e "$sysroot/complete" ] || skip "no packages for 64-bit ARM in out/arm64; scripts/arm64 fetches them"
  emulate="qemu-aarch64 -L $sysroot"
  data=${GMS_RANSAC_DATA:-$source/../shared/data}
  sets="kitti_06 tum_fr1_desk"
  [ "${3:-}" != all ] || sets=$(ls "$data" 2>/dev/null)
  rm -rf "$build/data" && mkdir -p "$build/data"
  for set in $sets; do
    [ ! -d "$data/$set" ] || ln -s "$(cd "$data/$set" && pwd)" "$build/data/$set"
  done
fi

launcher=$(command -v ccache || true)
cmake -S "$source/test/arm64" -B "$build" -G Ninja -DSYSROOT="$sysroot" -DPYTHON_EXECUTABLE=/usr/bin/python3 \
  -DCMAKE_CXX_COMPILER_LAUNCHER="$launcher" -DCMAKE_TOOLCHAIN_FILE="$source/test/arm64/toolchain.cmake" >"$build.log"

if [ "$what" = core ]; then
  ninja -C "$build" digest_test
  [ -n "$(ls "$build/data")" ] || skip "built, but there is none of the recorded sets in GMS_RANSAC_DATA"
  GMS_RANSAC_DATA="$build/data" $emulate "$build/digest_test" --outcomes
  exit
fi
for room in hamming patch feature; do
  ninja -C "$build" "${room}_kernels_check"
  status=0
  $emulate "$build/${room}_kernels_check" >"$build/$room.log" || status=$?
  cat "$build/$room.log"
  [ "$status" -eq 0 ] || exit 1
  grep -q '^neon equals' "$build/$room.log"
done
