"""What the tests share that start a ROS master and processes of their own, to kill them."""
import os
import socket
import subprocess
import tempfile
import unittest
import xmlrpc.client

import rospy

from graph import TIMEOUT, wait_for


def pid_of(node):
    """The process of a node of this test's master."""
    uri = rospy.get_master().lookupNode(node)[2]
    return xmlrpc.client.ServerProxy(uri).getPid("/test")[2]


def resident_mb(pid):
    with open("/proc/%d/statm" % pid) as fields:
        return int(fields.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def free_port():
    with socket.socket() as chosen:
        chosen.bind(("", 0))
        return chosen.getsockname()[1]


class GraphTest(unittest.TestCase):
    """A test whose processes have a master of their own, at `uri`, and end with it."""

    def setUp(self):
        self.port = free_port()
        self.uri = "http://localhost:%d" % self.port
        self.environment = dict(os.environ, ROS_MASTER_URI=self.uri, PYTHONUNBUFFERED="1",
                                ROSCONSOLE_STDOUT_LINE_BUFFERED="1")

    def start(self, *command, **options):
        """Returns the process and the file that collects what it says."""
        said = tempfile.NamedTemporaryFile("r")
        process = subprocess.Popen(command, env=self.environment, stdout=open(said.name, "w"), stderr=subprocess.STDOUT,
                                   **options)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process, said

    def start_master(self):
        process, _ = self.start("rosmaster", "--core", "-p", str(self.port))
        wait_for(lambda: self.nodes() is not None, "the master")
        return process

    def launch(self, file, *arguments):
        """A launch file with a master, all of which ends with the test; what it says."""
        process, said = self.start("roslaunch", "-p", str(self.port), file, *arguments)
        self.addCleanup(process.wait, TIMEOUT)
        self.addCleanup(process.terminate)  # before it is killed: its children are ended by it alone
        return said

    def ask(self, method, *arguments):
        """What the master answers; None: it does not, or has nothing to say."""
        try:
            code, _, value = getattr(xmlrpc.client.ServerProxy(self.uri), method)("/test", *arguments)
            return value if code == 1 else None
        except OSError:
            return None

    def nodes(self):
        """The names the master knows; None: it does not answer."""
        state = self.ask("getSystemState")
        return None if state is None else {name for kind in state for _, names in kind for name in names}

    def pid(self, node):
        """The process of a node that answers; else None."""
        uri = self.ask("lookupNode", node)
        try:
            return xmlrpc.client.ServerProxy(uri).getPid("/test")[2] if uri else None
        except OSError:
            return None

    def count(self, said, words):
        said.seek(0)
        return said.read().count(words)

    def says(self, said, words):
        wait_for(lambda: self.count(said, words), "'%s'" % words)
