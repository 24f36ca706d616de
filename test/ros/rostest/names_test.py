#!/usr/bin/env python3
"""Command lines: help without a master, completion, and a node whose image is its own output."""
import os
import subprocess

from graph import TIMEOUT, run
from processes import GraphTest

NODE = ("rosrun", "gms_ransac", "match_filter_node", "__name:=filter")


class Names(GraphTest):
    def setUp(self):
        super().setUp()
        self.start_master()

    def test_help_needs_no_master(self):
        master = dict(os.environ, ROS_MASTER_URI="http://localhost:1")
        for program in ("match_filter_node", "find_loops", "triangulate_inliers", "print_keypoints.py",
                        "publish_keypoints.py"):
            done = subprocess.run(["rosrun", "gms_ransac", program, "--help"], env=master, stdout=subprocess.PIPE, text=True,
                                  timeout=TIMEOUT)
            self.assertEqual(done.returncode, 0)
            self.assertIn(":=/", done.stdout)

    def test_launch_files_refuse_arguments_that_they_do_not_have(self):
        def said(launch, *arguments):
            done = subprocess.run(["roslaunch", "--dump-params", "gms_ransac", launch, *arguments], text=True, timeout=TIMEOUT,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
            return done.stdout
        for launch, argument, sentence in (
                ("tum.launch", "calibraton:=1", "tum.launch has no argument calibraton, did you mean calibration; it has bag, "),
                ("tum.launch", "calibration:=4", "calibration is '4'; it must be 1, 2, 3 or empty"),
                ("kitti.launch", "variant:=rectified", "variant is 'rectified'; it must be raw, odom or empty"),
                ("kitti.launch", "camera:=left", "camera is 'left'; it must be gray_left, "),
                ("demo.launch", "dataset:=euroc", "dataset is 'euroc'; it must be tum, kitti or empty"),
                ("match_filter.launch", "overlay:=flow", "match_filter.launch has no argument overlay, did you mean overlay_"),
                ("example_two_cameras.launch", "frist:=/image", "no argument frist, did you mean first")):
            output = said(launch, "bag:=/none.bag" if argument[0] in "cvd" else argument, argument)
            self.assertIn(sentence, output)
            self.assertIn("Unable to load", output)
        # The layout of rviz, which README shows, has the frames and lengths that it needs.
        shown = said("match_filter.launch", "image:=/camera/image_raw", "rviz:=true", "overlay_layout:=side_by_side")
        for line in ("publish_odom_tf: true", "invert_odom_tf: true", "scale: propagate", "overlay_layout: side_by_side"):
            self.assertIn("/match_filter/" + line, shown)
        self.assertNotIn("odom_tf", said("match_filter.launch"))

    def test_methods_are_explained_without_a_master(self):
        printed = subprocess.check_output(["rosrun", "gms_ransac", "match_filter_node", "--methods"], text=True, timeout=TIMEOUT,
                                          env=dict(os.environ, ROS_MASTER_URI="http://localhost:1"))
        lines = printed.splitlines()
        self.assertEqual(len(lines), 2 * 12)
        self.assertIn("lo_prosac", lines[0::2])
        self.assertTrue(all(": " in line for line in lines[1::2]))

    def test_completion_offers_no_tests(self):
        completion = """for file in /opt/ros/noetic/share/rosbash/rosbash /etc/bash_completion.d/rosbash \
                            /usr/share/bash-completion/completions/rosbash; do
                          [ ! -f $file ] || source $file
                        done
                        COMP_WORDS=(rosrun gms_ransac "") COMP_CWORD=2
                        _roscomplete_exe
                        echo "${COMPREPLY[@]}" """
        offered = subprocess.check_output(["bash", "-c", completion], text=True).split()
        self.assertIn("match_filter_node", offered)
        for program in ("names_test.py", "core_test", "fuzz_stream", "node_load", "run_rostest.sh", "install_test.sh"):
            self.assertNotIn(program, offered)

    def test_fed_its_own_output(self):
        for remapping in ("image:=filter/match_image", "~match_image:=image", "~mask:=filter/match_image",
                          "depth/image:=/filter/match_image _scale:=depth"):
            process, log = self.start(*NODE, *remapping.split())
            self.assertEqual(process.wait(TIMEOUT), 2, remapping)
            self.says(log, "an output of this node")


if __name__ == "__main__":
    run("names", Names)
