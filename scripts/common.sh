# Shared by scripts/demo and scripts/test: installs what is missing, builds, and enters the ROS environment.
# Sourced, not run. Everything happens inside the project folder but the system packages.

project_dir=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
# Not $project_dir/build: rosrun overlooks programs in a folder of that name.
build_dir=${GMS_RANSAC_BUILD_DIR:-$project_dir/out/build}
# Another python3 may come first on the PATH; ROS and its Python modules belong to the system's.
export PATH=/usr/bin:$PATH
python=/usr/bin/python3

say() { printf '\n== %s\n' "$*"; }
die() { printf '%s: %s\n' "$(basename "$0")" "$*" >&2; exit 1; }

# The list of packages for this system: Debian 12 has ROS 1 itself, Ubuntu 20.04 takes it from /opt/ros/noetic.
package_list() {
  if [ -d /opt/ros/noetic ]; then
    echo "$project_dir/scripts/packages.noetic"
  elif (. /etc/os-release && [ "$ID" = debian ]); then
    echo "$project_dir/scripts/packages.debian"
  else
    die "this is neither Debian nor an Ubuntu 20.04 with ROS Noetic in /opt/ros/noetic; install ROS Noetic first (wiki.ros.org/noetic/Installation/Ubuntu)"
  fi
}

install_missing_packages() {
  local list missing=() package
  list=$(package_list) || exit 1
  while read -r package; do
    dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q '^install ok installed' || missing+=("$package")
  done < <(grep -v -e '^#' -e '^$' "$list")
  [ ${#missing[@]} -eq 0 ] && return
  say "installing ${#missing[@]} missing packages"
  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || die "these packages are missing and need root to install: ${missing[*]}"
    as_root=(sudo)
  fi
  "${as_root[@]}" apt-get update -qq || die "apt-get update failed; is the network up?"
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" \
    >"$build_dir/install.log" 2>&1 || { tail -n 20 "$build_dir/install.log" >&2; die "apt-get install failed; the whole log is $build_dir/install.log"; }
}

build_project() {
  [ -f /opt/ros/noetic/setup.bash ] && source_ros /opt/ros/noetic/setup.bash
  say "building in $build_dir"
  {
    cmake -G Ninja -S "$project_dir" -B "$build_dir" -DPYTHON_EXECUTABLE=$python -DCATKIN_ENABLE_TESTING="$1" &&
      cmake --build "$build_dir"
  } >"$build_dir/build.log" 2>&1 || { tail -n 40 "$build_dir/build.log" >&2; die "the build failed; the whole log is $build_dir/build.log"; }
}

# ROS's set-up files read unset variables.
source_ros() { set +u; . "$1"; set -u; }

# prepare ON|OFF: everything above, with or without the tests.
prepare() {
  mkdir -p "$build_dir"
  install_missing_packages
  build_project "$1"
  source_ros "$build_dir/devel/setup.bash"
  export ROS_MASTER_URI=${ROS_MASTER_URI:-http://localhost:11311} ROS_HOME=$build_dir/ros_home
}
