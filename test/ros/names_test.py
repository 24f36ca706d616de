#!/usr/bin/env python3
"""Names that are given wrongly: two nodes of one name, and a node whose image is its own output."""
import rospy
import rostest

from graph import TIMEOUT
from processes import GraphTest

NODE = ("rosrun", "gms_ransac", "match_filter_node", "__name:=filter")


class Names(GraphTest):
    def setUp(self):
        super().setUp()
        self.start_master()

    def test_two_of_one_name(self):
        first, log = self.start(*NODE)
        self.says(log, "/filter: method")
        second, log = self.start(*NODE)
        self.says(log, "/filter: method")
        # The master's rule: the older one is told to end, and does.
        self.assertEqual(first.wait(TIMEOUT), 0)
        self.wait(lambda: self.pid("/filter") == second.pid, "the newer one to have the name")
        self.assertIsNone(second.poll())

    def test_fed_its_own_output(self):
        for remapping in ("image:=filter/match_image", "~match_image:=image", "~mask:=filter/match_image",
                          "depth/image:=/filter/match_image _scale:=depth"):
            process, log = self.start(*NODE, *remapping.split())
            self.assertEqual(process.wait(TIMEOUT), 2, remapping)
            self.says(log, "is this node's own output")


if __name__ == "__main__":
    rospy.init_node("names_test")
    rostest.rosrun("gms_ransac", "names", Names)
