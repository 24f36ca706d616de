#!/usr/bin/env bash
# consumers_test.sh cpp|python BUILD_DIR: strangers build against this project and run.
#   cpp:    A catkin package is built against the devel space and against an installation. A plain CMake project is built
#           against an installation of the core without ROS, and around our sources. Compiled for other vectors than the
#           library they read the same numbers. The snippets of the pages compile and run as they stand.
#   python: pip installs the module, without ROS. Exit status 77 (skipped) means that a tool is missing.
set -euo pipefail
export PATH=/usr/bin:$PATH GMS_RANSAC_BUILT=$2 LC_ALL=C
build=$2
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
source=$(cd "$here/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "$*" >&2; exit 1; }
# quietly COMMAND: shows its output only if it fails.
quietly() { "$@" >"$work/log" 2>&1 || { cat "$work/log" >&2; fail "failed: $*"; }; }
# build_in FOLDER SOURCE OPTIONS: configures and builds.
build_in() {
  quietly cmake -G Ninja -S "$2" -B "$1" -DPYTHON_EXECUTABLE=/usr/bin/python3 -DCONSUMERS="$here" "${@:3}"
  quietly ninja -C "$1"
}
expect() { [ "$2" = "$3" ] || fail "$1: expected '$3', got '$2'"; }
# same_numbers NAME SOURCE PROGRAM OPTIONS: a consumer built with the flags of other programs prints what it prints with
# those of the library.
same_numbers() {
  local flags plain= numbers
  for flags in "" -march=native -mavx "-O0 -DEIGEN_DONT_VECTORIZE"; do
    case $flags in -m*) "${CXX:-c++}" "$flags" -E -x c++ /dev/null >/dev/null 2>&1 || continue ;; esac
    rm -rf "$work/numbers"
    build_in "$work/numbers" "$2" "-DCMAKE_CXX_FLAGS=$flags" "${@:4}"
    numbers=$("$work/numbers/$3" numbers) || fail "$1 compiled with '$flags' ends with status $?"
    [ -n "$plain" ] || plain=$numbers
    [ "$numbers" = "$plain" ] || fail "$1 compiled with '$flags' reads other numbers:
$(diff <(echo "$plain") <(echo "$numbers") || true)"
  done
  case $plain in OK*|LOW_PARALLAX*) ;; *) fail "$1 has no pose: $plain" ;; esac
}

unset CMAKE_PREFIX_PATH ROS_PACKAGE_PATH PYTHONPATH LD_LIBRARY_PATH
launcher=-DCMAKE_CXX_COMPILER_LAUNCHER=$here/reuse_object

if [ "$1" = cpp ]; then
  ros=
  [ ! -d /opt/ros/noetic ] || { ros=/opt/ros/noetic && set +u && . $ros/setup.bash && set -u; }
  quietly env DESTDIR= cmake -DCMAKE_INSTALL_PREFIX="$work/install" -P "$build/cmake_install.cmake"
  for space in "$build/devel" "$work/install"; do
    build_in "$work/catkin" "$here/catkin" "-DCMAKE_PREFIX_PATH=$space;$ros"
    expect "the catkin package against $space" \
      "$("$work/catkin/devel/lib/gms_ransac_consumer/consumer")" "2 matches, 8, FIRST_FRAME, OK is 0"
    grep -q "^gms_ransac_DIR:PATH=$space/" "$work/catkin/CMakeCache.txt" || fail "gms_ransac is not that of $space"
    rm -rf "$work/catkin"
    # Its library for the node has no headers.
    ! grep gms_ransac_ros "$space/share/gms_ransac/cmake/gms_ransacConfig.cmake" || fail "$space exports gms_ransac_ros"
  done
  /usr/bin/python3 "$here/snippets.py" "$work/snippets"
  build_in "$work/snippets/out" "$work/snippets/catkin" "-DCMAKE_PREFIX_PATH=$build/devel;$ros"
  case $("$work/snippets/out/my_node") in *" snippets ran") ;; *) fail "the snippets with ROS: no match was used" ;; esac
  same_numbers "the catkin package" "$here/catkin" devel/lib/gms_ransac_consumer/consumer "-DCMAKE_PREFIX_PATH=$build/devel;$ros"

  without_ros=(-DGMS_RANSAC_ROS=OFF "$launcher")
  moved="UNCALIBRATED, moved by -12"
  build_in "$work/core" "$source" "${without_ros[@]}" -DCMAKE_INSTALL_PREFIX="$work/core_install"
  ! grep -E '^(catkin|roscpp)_DIR' "$work/core/CMakeCache.txt" || fail "the core without ROS found ROS"
  quietly cmake --install "$work/core"
  build_in "$work/plain" "$here/cmake" -DCMAKE_PREFIX_PATH="$work/core_install"
  expect "the plain project" "$("$work/plain/consumer")" "$moved"
  build_in "$work/snippets/plain" "$work/snippets/cmake" -DCMAKE_PREFIX_PATH="$work/core_install"
  case $("$work/snippets/plain/my_program") in *" snippets ran") ;; *) fail "the snippets: no match was used" ;; esac
  same_numbers "the plain project" "$here/cmake" consumer -DCMAKE_PREFIX_PATH="$work/core_install"
  version=$(sed -n 's/.*<version>\(.*\)<\/version>.*/\1/p' "$source/package.xml")
  series=${version%.*}
  library=$(ldd "$work/plain/consumer" | sed -n 's/.*libgms_ransac_core.so.\([^ ]*\) => .*/\1/p')
  expect "the series that the plain project was linked to" "$library" "$series"
  mkdir "$work/other"
  for other in "0.$((${series#0.} + 1))" "0.$((${series#0.} - 1))" 1.0; do
    printf '%s\n' 'cmake_minimum_required(VERSION 3.10)' 'project(other NONE)' "find_package(gms_ransac $other QUIET)" \
      'if(gms_ransac_FOUND)' '  message(FATAL_ERROR found)' 'endif()' 'message("${gms_ransac_CONSIDERED_VERSIONS}")' \
      >"$work/other/CMakeLists.txt"
    expect "a project that asks for version $other" \
      "$(cmake -S "$work/other" -B "$work/other/build" -DCMAKE_PREFIX_PATH="$work/core_install" 2>&1 >/dev/null)" "$version"
    rm -rf "$work/other/build"
  done

  mkdir "$work/around"
  cp "$here/cmake/consumer.cpp" "$work/around"
  sed "s|^find_package(gms_ransac.*|add_subdirectory($source gms_ransac)|" "$here/cmake/CMakeLists.txt" \
    >"$work/around/CMakeLists.txt"
  build_in "$work/around/build" "$work/around" "${without_ros[@]}"
  expect "the project around our sources" "$("$work/around/build/consumer")" "$moved"
  exit
fi

/usr/bin/python3 -c 'import setuptools, pip, wheel, numpy, cv2' 2>/dev/null || {
  echo "skipped: python3-setuptools, python3-pip, python3-wheel, python3-numpy or python3-opencv is missing"
  exit 77
}
mkdir "$work/source"
(cd "$source" && cp -r CMakeLists.txt MANIFEST.in README.md cfg cmake include package.xml pyproject.toml setup.py "$work/source"
  mkdir "$work/source/scripts" "$work/source/src"
  cp scripts/generate_parameters.py "$work/source/scripts" && cp -r src/core src/python "$work/source/src")
quietly env CMAKE_ARGS="$launcher" /usr/bin/python3 -m pip install --no-build-isolation --no-index --no-deps \
  --target "$work/wheel" "$work/source"
# Below /usr/local the module lies where the system's Python looks for modules, next to its library.
build_in "$work/local" "$source" -DGMS_RANSAC_ROS=OFF -DGMS_RANSAC_PYTHON=ON "$launcher" -DCMAKE_INSTALL_PREFIX=/usr/local
quietly env DESTDIR="$work/stage" cmake --install "$work/local"
folder=$(dirname "$(dirname "$(find "$work/stage" -name '_gms_ransac*.so')")")
/usr/bin/python3 -c 'import site, sys; sys.exit(sys.argv[1] not in sys.path + site.getsitepackages())' \
  "${folder#"$work/stage"}" || fail "no Python looks for modules in ${folder#"$work/stage"}"
PYTHONPATH=$folder /usr/bin/python3 -c 'import gms_ransac; gms_ransac.MatchFilter()'

cd "$work"
for file in __init__.pyi py.typed; do [ -e "wheel/gms_ransac/$file" ] || fail "the wheel has no $file"; done
/usr/bin/python3 "$here/snippets.py" "$work/snippets"
PYTHONPATH=$work/wheel /usr/bin/python3 snippets/snippets.py | grep -q ' snippets ran$' || fail "the snippets of Python"
PYTHONPATH=$work/wheel /usr/bin/python3 "$source/test/python/module_test.py" "$build/devel/lib/gms_ransac/evaluate" \
  "$build/devel/lib/gms_ransac/render_scene" "$source/examples/two_images.py"
