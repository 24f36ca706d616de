#!/usr/bin/env bash
# Follows CONTRIBUTING.md in a copy of the source: its commands and diffs for a new method and a new parameter, in their
# order. The files that they touch compile, and the documents made from the table have the parameter.
set -euo pipefail
export PATH=/usr/bin:$PATH LC_ALL=C
cd "$(dirname "${BASH_SOURCE[0]}")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# quietly COMMAND: shows its output only if it fails.
quietly() { "$@" >"$work/log" 2>&1 || { cat "$work/log" >&2; echo "failed: $*" >&2; exit 1; }; }

mkdir -p "$work/source/src"
cp -r CMakeLists.txt CONTRIBUTING.md README.md cfg cmake doc include scripts "$work/source"
cp -r src/core "$work/source/src"
cd "$work/source"
awk '/^## /             { on = /^## Adding a (method|parameter)$/ }
     on && /^ *```sh$/   { kind = "sh"; next }
     on && /^ *```diff$/ { kind = "diff"; print "patch -p1 <<\"DIFF\""; next }
     /^ *```$/           { if (kind == "diff") print "DIFF"; kind = "" }
     kind != ""          { sub(/^   /, ""); print }' CONTRIBUTING.md >"$work/recipes.sh"
quietly bash -euo pipefail "$work/recipes.sh"
quietly scripts/generate_parameters.py --check

# These four files are enough: building and running all of the copy would take minutes.
quietly cmake -G Ninja -S . -B "$work/build" -DGMS_RANSAC_ROS=OFF -DGMS_RANSAC_UNITY=OFF -DCMAKE_BUILD_TYPE=Debug \
  -DCMAKE_CXX_FLAGS_DEBUG=-O0
objects=()
for file in methods/neighbour_ransac methods/method methods/cp_ransac parameters/parameter; do
  objects+=("src/core/CMakeFiles/gms_ransac_core.dir/$file.cpp.o")
done
quietly ninja -C "$work/build" "${objects[@]}"
grep -q '`~smallest_rest`' doc/parameters.md ||
  { echo "doc/parameters.md does not have the new parameter" >&2; exit 1; }
