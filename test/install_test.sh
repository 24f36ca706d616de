#!/usr/bin/env bash
# install_test.sh BUILD_DIR: installs into a fresh folder, and from there alone loads the nodelet through a launch file
# and runs a program.
set -eo pipefail
export PATH=/usr/bin:$PATH
build=$1
prefix=$(mktemp -d)
launch=
trap '[ -z "$launch" ] || { kill "$launch" 2>/dev/null; wait "$launch" 2>/dev/null; } || true; rm -rf "$prefix"' EXIT
DESTDIR= cmake -DCMAKE_INSTALL_PREFIX="$prefix" -P "$build/cmake_install.cmake" >"$prefix.log" 2>&1 || { cat "$prefix.log"; exit 1; }
rm -f "$prefix.log"
# Nothing of the build may be found, only ROS itself and what was installed.
unset CMAKE_PREFIX_PATH ROS_PACKAGE_PATH PYTHONPATH LD_LIBRARY_PATH
[ -f /opt/ros/noetic/setup.bash ] && . /opt/ros/noetic/setup.bash
. "$prefix/setup.bash" --extend 2>/dev/null || {
  export ROS_PACKAGE_PATH=$prefix/share:$ROS_PACKAGE_PATH CMAKE_PREFIX_PATH=$prefix:$CMAKE_PREFIX_PATH
  export LD_LIBRARY_PATH=$prefix/lib:$LD_LIBRARY_PATH PYTHONPATH=$prefix/lib/python3/dist-packages:$PYTHONPATH
}
case $(rospack find gms_ransac) in
  "$prefix"/*) ;;
  *) echo "gms_ransac is found in $(rospack find gms_ransac), not in the installation"; exit 1 ;;
esac
rosrun gms_ransac evaluate --list | grep -q cp_ransac
# The Python module, if it was built, next to the messages of the same package.
if compgen -G "$build/devel/lib/python3/dist-packages/gms_ransac/_gms_ransac*.so" >/dev/null; then
  (unset LD_LIBRARY_PATH
   /usr/bin/python3 -c "import gms_ransac, gms_ransac.msg as m; assert gms_ransac.__file__.startswith('$prefix/')
assert int(gms_ransac.Status.OK) == m.MatchStats.OK and gms_ransac.MatchFilter().options['features'] == 2000")
fi
port=$(/usr/bin/python3 -c 'import socket; s = socket.socket(); s.bind(("", 0)); print(s.getsockname()[1])')
export ROS_MASTER_URI=http://localhost:$port ROS_IP=127.0.0.1 ROS_HOME=$prefix/home
cat >"$prefix/graph.launch" <<'XML'
<launch>
  <node pkg="nodelet" type="nodelet" name="manager" args="manager"/>
  <include file="$(find gms_ransac)/launch/match_filter.launch">
    <arg name="manager" value="manager"/>
    <arg name="parameters" value="$(find gms_ransac)/cfg/match_filter.yaml"/>
  </include>
</launch>
XML
roslaunch -p "$port" "$prefix/graph.launch" >"$prefix/roslaunch.log" 2>&1 &
launch=$!
for ((i = 0; i < 300; ++i)); do
  if timeout 5 rosservice call /manager/list 2>/dev/null | grep -q match_filter &&
    timeout 5 rostopic list 2>/dev/null | grep -q '^/match_filter/correspondences$'; then
    grep -i 'not known' "$prefix/roslaunch.log" && exit 1
    echo "the installed nodelet runs"
    exit 0
  fi
  sleep 0.1  # between two looks at the graph
done
cat "$prefix/roslaunch.log"
exit 1
