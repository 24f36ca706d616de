#!/usr/bin/env bash
# Checks of the source itself: check_source.sh ros_free|clock|floors|docs|parameters|version|format|lint|tidy [BUILD_DIR [FILE...]]:
# format and tidy look at these files, or at all. Exit status 77 means skipped. scripts/lint runs format, lint and tidy.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
SKIPPED=77

# Formatting and warnings differ between versions of these tools, so only the one the style was made with decides.
require_version_14() {
  "$1" --version 2>/dev/null | grep -q 'version 14\.' || { echo "$1 14 is not installed"; exit $SKIPPED; }
}

case ${1:-} in
  ros_free)
    # The core, its public headers and the Python module must build without ROS: no include of roscpp, tf2, cv_bridge or a message.
    ! grep -rnE '#include [<"](ros|tf2|tf2_[a-z]+|cv_bridge|image_transport|image_geometry|nodelet|pluginlib|[a-z]+_msgs|std_srvs|diagnostic_updater|dynamic_reconfigure|message_filters|rosbag|gms_ransac/(Correspondences|MatchStats))[/.]' \
      include src/core src/python
    ;;
  clock)
    # rosconsole's throttles go by the ROS clock, and log nothing while it stands at zero: src/ros/throttle.h.
    ! grep -rnE 'ROS_[A-Z_]+_THROTTLE' src examples
    ;;
  floors)
    /usr/bin/python3 test/check_floors.py
    ;;
  docs)
    /usr/bin/python3 test/check_docs.py
    ;;
  parameters)
    /usr/bin/python3 scripts/generate_parameters.py --check
    ;;
  version)
    # One version and one date of release; setup.py reads package.xml.
    version=$(sed -n 's/.*<version>\(.*\)<\/version>.*/\1/p' package.xml)
    date=$(sed -n "s/^$version (\(.*\))$/\1/p" CHANGELOG.rst)
    [ -n "$date" ] || { echo "CHANGELOG.rst has no line '$version (DATE)', the version of package.xml" >&2; exit 1; }
    same() { [ "$2" = "$3" ] || { echo "$1 says '$2', package.xml and CHANGELOG.rst '$3'" >&2; exit 1; }; }
    same CMakeLists.txt "$(sed -n 's/^project(.* VERSION \([^ ]*\).*/\1/p' CMakeLists.txt)" "$version"
    for file in test/consumers/cmake/CMakeLists.txt doc/use_it.md; do
      same "$file" "$(sed -n 's/.*find_package(gms_ransac \([0-9.]*\) .*/\1/p' "$file")" "${version%.*}"
    done
    same CITATION.cff "$(sed -n 's/^version: //p' CITATION.cff)" "$version"
    same debian/changelog "$(sed -n '1s/.*(\(.*\)).*/\1/p' debian/changelog)" "$version"
    same "date in debian/changelog" "$(date -u -d "$(sed -n 's/^ -- .*>  //p' debian/changelog | head -n 1)" +%F)" "$date"
    ;;
  format)
    require_version_14 clang-format
    if [ $# -gt 2 ]; then
      clang-format --dry-run --Werror "${@:3}"
      exit
    fi
    # Not git: the source may have come without it.
    find include src test examples \( -name '*.h' -o -name '*.cpp' \) -print0 | xargs -0 clang-format --dry-run --Werror
    ;;
  lint)
    command -v catkin_lint >/dev/null || { echo "catkin_lint is not installed"; exit $SKIPPED; }
    report=$(catkin_lint --offline -W1 --strict . 2>&1) || { echo "$report"; exit 1; }
    echo "$report"
    ! grep -q 'cannot lint' <<<"$report"  # which is a success to catkin_lint
    ;;
  tidy)
    require_version_14 clang-tidy
    # Files for one instruction set need its flags, which the compilation database has.
    /usr/bin/python3 test/check_tidy.py "${@:2}"
    ;;
  *)
    echo "usage: check_source.sh ros_free|clock|floors|docs|parameters|version|format|lint|tidy [BUILD_DIR [FILE...]]" >&2
    exit 2
    ;;
esac
