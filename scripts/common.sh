# Shared by scripts/demo, scripts/test and scripts/fuzz: installs what is missing, builds, and enters the ROS environment.
# Sourced, not run. Everything happens inside the project folder but the system packages.

project_dir=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
# Not $project_dir/build: rosrun overlooks programs in a folder of that name.
build_dir=${GMS_RANSAC_BUILD_DIR:-$project_dir/out/build}
# A script may add: groups of packages (scripts/packages.*) that are needed to build, and to run, packages beyond the list,
# settings of CMake, targets.
groups_to_build=(build) groups_to_run=(run) packages=() cmake_options=() build_targets=(all)
# Another python3 may come first on the PATH; ROS and its Python modules belong to the system's.
export PATH=/usr/bin:$PATH
python=/usr/bin/python3

say() { printf '\n== %s\n' "$*"; }
die() { printf '%s: %s\n' "$(basename "$0")" "$*" >&2; exit 1; }

# help_if_asked "$@": with --help the comment that the script opens with, and nothing else is done.
help_if_asked() {
  case ${1:-} in -h | --help) ;; *) return 0 ;; esac
  sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"
  exit 0
}

# The list of packages for this system: Debian 12 and 13 have ROS 1 themselves, Ubuntu 20.04 takes it from /opt/ros/noetic.
package_list() {
  if [ -d /opt/ros/noetic ]; then
    echo "$project_dir/scripts/packages.noetic"
  elif (. /etc/os-release && [ "$ID" = debian ]); then
    echo "$project_dir/scripts/packages.debian"
  else
    die "this is neither Debian nor an Ubuntu 20.04 with ROS Noetic in /opt/ros/noetic; install ROS Noetic first (wiki.ros.org/noetic/Installation/Ubuntu)"
  fi
}

# Seconds between two lines of progress where none can be drawn in place.
progress_seconds=${GMS_RANSAC_PROGRESS_SECONDS:-10}

# COMMAND 2>&1 | show_progress LOG [PACKAGES]: keeps the output in LOG and shows how far the command is, in one line that
# moves on a terminal, in a line now and then elsewhere. Understands cmake, ninja, and apt-get installing so many packages.
show_progress() {
  local log=$1 packages=${2:-} line text="" fetched=0 unpacked=0 set_up=0 shown_at=-$progress_seconds pending=""
  while IFS= read -r line; do
    printf '%s\n' "$line" >&3
    case $line in
      "["[0-9]*/[0-9]*"] "*) text=${line/$project_dir\//} ;;
      "-- "*) text="configuring: ${line#-- }" ;;
      Get:*) text="[$((++fetched))/$packages] fetched" ;;
      "Unpacking "*) text="[$((++unpacked))/$packages] unpacked" ;;
      "Setting up "*) text="[$((++set_up))/$packages] set up" ;;
      *) continue ;;
    esac
    if [ -t 1 ]; then
      printf '\r\033[K%.*s' "${COLUMNS:-79}" "$text"
    elif [ $((SECONDS - shown_at)) -ge "$progress_seconds" ]; then
      printf '%s\n' "$text"
      shown_at=$SECONDS pending=""
    else
      pending=$text
    fi
  done 3>"$log"
  if [ -t 1 ]; then
    [ -z "$text" ] || printf '\n'
  elif [ -n "$pending" ]; then
    printf '%s\n' "$pending"
  fi
}

# compilers CORES FREE_KB: how many to run at once. A board with many cores and little memory would swap, or kill one.
compilers() {
  local by_memory=$(($2 / 1100000))  # the largest compiler, of a test, takes 1 GB (GCC 12); the system needs some
  [ "$by_memory" -ge 1 ] || by_memory=1
  echo $(($1 < by_memory ? $1 : by_memory))
}

# missing_packages LIST GROUP...: those of the groups that are not installed.
missing_packages() {
  local list=$1 package
  shift
  awk -v groups=" $* " '/^# / { on = index(groups, " " substr($0, 3) " ") } !/^#/ && on' "$list" |
    cat - <(printf '%s\n' "${packages[@]}") | while read -r package; do
      [ -z "$package" ] || dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q '^install ok installed' ||
        echo "$package"
    done
}

# install_missing_packages LOG GROUP...
install_missing_packages() {
  local log=$1 list missing as_root=() count
  shift
  list=$(package_list) || exit 1
  mapfile -t missing < <(missing_packages "$list" "$@")
  [ ${#missing[@]} -eq 0 ] && return
  say "installing ${#missing[@]} missing packages"
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || die "these packages are missing and need root to install: ${missing[*]}"
    as_root=(sudo)
  fi
  [ -n "${updated:-}" ] || "${as_root[@]}" apt-get update -qq || die "apt-get update failed; is the network up?"
  updated=yes
  local install=(apt-get install -y -q --no-install-recommends)
  count=$("${install[@]}" --simulate "${missing[@]}" 2>/dev/null | grep -c '^Inst ' || true)
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive "${install[@]}" "${missing[@]}" 2>&1 |
    show_progress "$log" "$count" || { tail -n 20 "$log" >&2; die "apt-get install failed; the whole log is $log"; }
}

# One configuration for all scripts, or one would compile again what another has.
build_project() {
  [ -f /opt/ros/noetic/setup.bash ] && source_ros /opt/ros/noetic/setup.bash
  say "building in $build_dir"
  local jobs=${CMAKE_BUILD_PARALLEL_LEVEL:-}
  [ -n "$jobs" ] || jobs=$(compilers "$(nproc)" "$(awk '/^MemAvailable:/ { print $2 }' /proc/meminfo)")
  {
    cmake -G Ninja -S "$project_dir" -B "$build_dir" -DPYTHON_EXECUTABLE=$python -DCATKIN_ENABLE_TESTING=ON \
      -DGMS_RANSAC_EVALUATION=ON "${cmake_options[@]}" &&
      cmake --build "$build_dir" --parallel "$jobs" --target "${build_targets[@]}"
  } 2>&1 | show_progress "$build_dir/build.log" || { tail -n 40 "$build_dir/build.log" >&2; die "the build failed; the whole log is $build_dir/build.log"; }
}

# ROS's set-up files read unset variables.
source_ros() { set +u; . "$1"; set -u; }

# Everything above. Packages that are needed only to run are installed while the compilers work.
prepare() {
  local installing
  mkdir -p "$build_dir"
  install_missing_packages "$build_dir/install.log" "${groups_to_build[@]}"
  install_missing_packages "$build_dir/install_more.log" "${groups_to_run[@]}" >"$build_dir/install_more.txt" &
  installing=$!
  build_project
  wait "$installing" || { cat "$build_dir/install_more.txt" >&2; exit 1; }
  source_ros "$build_dir/devel/setup.bash"
  export ROS_MASTER_URI=${ROS_MASTER_URI:-http://localhost:11311} ROS_HOME=$build_dir/ros_home
}
