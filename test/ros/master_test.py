#!/usr/bin/env python3
"""The ROS master is killed, and started again: the node goes on and says both, in the log and in its diagnostics."""
import os
import signal
import socket
import subprocess
import tempfile
import time
import unittest
import xmlrpc.client

import rospy
import rostest

from graph import TIMEOUT


def free_port():
    with socket.socket() as chosen:
        chosen.bind(("", 0))
        return chosen.getsockname()[1]


class Master(unittest.TestCase):
    def setUp(self):
        self.port = free_port()
        self.uri = "http://localhost:%d" % self.port
        self.environment = dict(os.environ, ROS_MASTER_URI=self.uri, PYTHONUNBUFFERED="1",
                                ROSCONSOLE_STDOUT_LINE_BUFFERED="1")

    def start(self, *command):
        """Returns the process and the file that collects what it says."""
        said = tempfile.NamedTemporaryFile("r")
        process = subprocess.Popen(command, env=self.environment, stdout=open(said.name, "w"), stderr=subprocess.STDOUT)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process, said

    def start_master(self):
        process, _ = self.start("rosmaster", "--core", "-p", str(self.port))
        self.wait(lambda: self.nodes() is not None, "the master")
        return process

    def nodes(self):
        """The names the master knows; None: it does not answer."""
        try:
            state = xmlrpc.client.ServerProxy(self.uri).getSystemState("/test")[2]
            return {name for kind in state for _, names in kind for name in names}
        except OSError:
            return None

    def wait(self, condition, what):
        end = time.monotonic() + TIMEOUT
        while time.monotonic() < end:
            if condition():
                return
            time.sleep(0.05)  # there is no message to wait for
        self.fail("waited %g s in vain for %s" % (TIMEOUT, what))

    def count(self, said, words):
        said.seek(0)
        return said.read().count(words)

    def says(self, said, words):
        self.wait(lambda: self.count(said, words), "'%s'" % words)

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
