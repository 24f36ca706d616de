#!/usr/bin/env python3
"""The ROS master is killed, and started again: the node goes on and says both, in the log and in its diagnostics. What is
connected is served without a master from the first image on."""
import signal
import threading
import xmlrpc.client
from xmlrpc.server import SimpleXMLRPCServer

from gms_ransac.msg import MatchStats
from sensor_msgs.msg import Image

from graph import TIMEOUT, image_message, run, wait_for, walk
from processes import GraphTest
from tcpros import RawPublisher, RawSubscriber


class MasterThatEnds(threading.Thread):
    """Passes on what it is asked to the master `behind` it, and ends once it is armed and has answered one question of /filter."""

    def __init__(self, behind):
        super().__init__(daemon=True)
        self.server = SimpleXMLRPCServer(("localhost", 0), logRequests=False)
        self.server.register_instance(self)
        self.uri = "http://localhost:%d" % self.server.server_address[1]
        self.behind, self.armed, self.ended = behind, False, False

    def _dispatch(self, method, parameters):
        self.ended = self.armed and method in ("getPid", "lookupNode") and parameters[0] == "/filter"
        return getattr(xmlrpc.client.ServerProxy(self.behind), method)(*parameters)

    def run(self):
        while not self.ended:
            self.server.handle_request()
        self.server.server_close()


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
        wait_for(lambda: self.count(diagnostics, "was restarted") > 3, "more reports")
        self.assertEqual(self.count(log, "was restarted"), 1, "said once")
        node.send_signal(signal.SIGINT)
        self.assertEqual(node.wait(TIMEOUT), 0)

    def test_ends_between_two_questions_of_the_node(self):
        self.start_master()
        master = MasterThatEnds(self.uri)
        master.start()
        self.environment["ROS_MASTER_URI"] = master.uri
        _, log = self.start("rosrun", "gms_ransac", "match_filter_node", "__name:=filter")
        self.says(log, "subscribes to /image")
        master.armed = True
        self.says(log, "the ROS master at")
        self.assertEqual(self.count(log, "does not answer"), 1)

    def test_killed_before_the_first_image(self):
        master = self.start_master()
        _, log = self.start("rosrun", "gms_ransac", "match_filter_node", "__name:=filter", "_drop_frames:=false",
                            "_camera/fx:=500.0", "_camera/fy:=500.0", "_camera/cx:=319.5",
                            "_camera/cy:=239.5")
        self.says(log, "subscribes to /image")
        camera = RawPublisher("/camera", "/image", Image, master_uri=self.uri)
        listener = RawSubscriber("/listener", "/filter/stats", MatchStats, self.uri)
        wait_for(lambda: camera.served, "the filter to connect")
        master.kill()
        master.wait()
        for i, (frame, status) in enumerate(zip(walk(3), (MatchStats.FIRST_FRAME, MatchStats.OK, MatchStats.OK))):
            camera.publish(image_message(frame, 100 + 0.1 * i))
            self.assertEqual(listener.read().status, status)
        listener.close()


if __name__ == "__main__":
    run("master", Master)
