#!/usr/bin/env python3
"""The nodelet is loaded and unloaded 20 times in one manager while images keep coming, and answers after each load."""
import unittest

import rospy
import rostest
from gms_ransac.msg import MatchStats
from nodelet.srv import NodeletList, NodeletLoad, NodeletLoadRequest, NodeletUnload

from graph import Client, Scene, Stream

ROUNDS = 20


class NodeletReload(unittest.TestCase):
    def test_load_and_unload(self):
        for service in ("load_nodelet", "unload_nodelet", "list"):
            rospy.wait_for_service("manager/" + service)
        load = rospy.ServiceProxy("manager/load_nodelet", NodeletLoad)
        unload = rospy.ServiceProxy("manager/unload_nodelet", NodeletUnload)
        loaded = rospy.ServiceProxy("manager/list", NodeletList)
        scene = Scene()
        client = Client()
        stream = Stream(client, [scene.draw(t=(0.15 * i, 0.05 * i, 0)) for i in range(4)])
        stream.start()
        name = rospy.resolve_name("match_filter")
        for i in range(ROUNDS):
            before = len(client.stats)
            request = NodeletLoadRequest(name=name, type="gms_ransac/MatchFilter")
            self.assertTrue(load(request).success, "load %d" % i)
            client.wait(lambda: any(m.status == MatchStats.OK for m in client.stats[before:]), "an answer in round %d" % i)
            self.assertTrue(unload(name=name).success, "unload %d" % i)
            self.assertEqual(loaded().nodelets, [])
        stream.stop()


if __name__ == "__main__":
    rospy.init_node("nodelet_reload_test")
    rostest.rosrun("gms_ransac", "nodelet_reload", NodeletReload)
