#!/usr/bin/env python3
"""The ROS master is killed, and started again: the node goes on and says both, in the log and in its diagnostics."""
import signal

import rospy
import rostest

from graph import TIMEOUT
from processes import GraphTest


class Master(GraphTest):
    def test_killed_and_restarted(self):
        master = self.start_master()
        node, log = self.start("rosrun", "gms_ransac", "match_filter_node", "__name:=filter")
        _, diagnostics = self.start("rostopic", "echo", "/diagnostics")
        self.says(log, "subscribes to /image")
        self.says(diagnostics, "known to the ROS master")
        master.kill()
        master.wait()
        for said in log, diagnostics:
            self.says(said, "the ROS master at %s" % self.uri)
            self.says(said, "does not answer")
        self.start_master()
        for said in log, diagnostics:
            self.says(said, "was restarted and knows nothing of /filter")
        self.assertNotIn("/filter", self.nodes())
        self.assertIsNone(node.poll(), "it goes on")
        # Its diagnostics repeat what they say with every report: three later the log has had the time to.
        self.wait(lambda: self.count(diagnostics, "was restarted") > 3, "more reports")
        self.assertEqual(self.count(log, "was restarted"), 1, "said once")
        node.send_signal(signal.SIGINT)
        self.assertEqual(node.wait(TIMEOUT), 0)


if __name__ == "__main__":
    rospy.init_node("master_test")
    rostest.rosrun("gms_ransac", "master", Master)
