#!/usr/bin/env bash
# run_rostest.sh BUILD_DIR NAME [PACKAGES]: runs test/ros/rostest/NAME.test, or NAME_test.py alone, under a ROS master of its own,
# with the ROS packages below PACKAGES, and leaves the cases of its test node in BUILD_DIR/test_results/rostest_NAME.xml. Exit
# status 77 when every case was skipped.
set -eo pipefail
export PATH=/usr/bin:$PATH  # another python3 may come first; ROS's modules belong to the system's
build=$1 name=$2 packages=$3
results=$build/test_results
source_dir=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
. "$build/devel/setup.bash"
export ROS_HOME=$results/ros_home/$name ROS_IP=127.0.0.1 PYTHONDONTWRITEBYTECODE=1
[ -z "$packages" ] || export ROS_PACKAGE_PATH=$packages:$ROS_PACKAGE_PATH
mkdir -p "$ROS_HOME"
# The test's own nodes are a package of their own: rosrun would offer those of ours to everybody.
nodes=$ROS_HOME/.gms_ransac_rostest
rm -rf "$nodes"
mkdir "$nodes"
echo '<package><name>gms_ransac_rostest</name></package>' >"$nodes/package.xml"
ln -s "$build/test/.programs/"* "$nodes"
printf '#!/bin/sh\nexec /usr/bin/python3 "%s" "$@"\n' "$source_dir/test/ros/rostest/${name}_test.py" >"$nodes/${name}_test.py"
chmod +x "$nodes/${name}_test.py"
export ROS_PACKAGE_PATH=$nodes:$ROS_PACKAGE_PATH
# A nodelet manager and Python load our libraries, and are not built with the sanitizer these need. Both leak on purpose.
# Freed memory is not reused for a short while only: some tests look at the memory of a process.
case $(sed -n 's/^GMS_RANSAC_SANITIZE:STRING=//p' "$build/CMakeCache.txt") in
  *address*) runtime=libasan.so ;;
  *thread*) runtime=libtsan.so ;;
esac
if [ -n "${runtime:-}" ]; then
  export ASAN_OPTIONS=detect_leaks=0:quarantine_size_mb=8:${ASAN_OPTIONS:-}
  export LD_PRELOAD="$(g++ -print-file-name="$runtime") $(g++ -print-file-name=libstdc++.so.6)"
fi
# Seconds for all cases of a test. It ends before ctest's limit, because it ends the nodes that it started.
export GMS_RANSAC_TIME_LIMIT=$((400 * ${GMS_RANSAC_PATIENCE:-1}))
[ "${GMS_RANSAC_FULL:-}" != 1 ] || GMS_RANSAC_TIME_LIMIT=$((3 * GMS_RANSAC_TIME_LIMIT))
launch=$source_dir/test/ros/rostest/$name.test
if [ ! -f "$launch" ]; then
  launch=$ROS_HOME/$name.test
  echo "<launch><test test-name='$name' pkg='gms_ransac_rostest' type='${name}_test.py' time-limit='$GMS_RANSAC_TIME_LIMIT'/></launch>" >"$launch"
fi
rm -f "$results/gms_ransac/"*"-$name.xml" "$results/rostest_$name.xml"
status=0
rostest --pkgdir="$source_dir" --package=gms_ransac --results-filename="$name.xml" --results-base-dir="$results" \
  "$launch" || status=$?
cases=$results/gms_ransac/rosunit-$name.xml
[ -f "$cases" ] || exit $((status ? status : 1))
# Where a required node ends, rostest stops the test, finds no case that failed, and reports success.
grep -q '<testcase' "$cases" || { echo "run_rostest.sh: $name ended without a case; did a required node end?" >&2; exit 1; }
cp "$cases" "$results/rostest_$name.xml"
if [ "$status" -eq 0 ] && grep -q '<skipped' "$cases" &&
  [ "$(grep -o '<testcase' "$cases" | wc -l)" -eq "$(grep -o '<skipped' "$cases" | wc -l)" ]; then
  exit 77
fi
exit "$status"
