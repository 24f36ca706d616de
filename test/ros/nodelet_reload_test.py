#!/usr/bin/env python3
"""The nodelet is loaded and unloaded many times in one manager while images keep coming, with every number of threads and at
every stage: as soon as it is loaded, with its first answer, at work. Says how long the unloading took."""
import time
import unittest

import rospy
import rostest
from gms_ransac.msg import MatchStats
from nodelet.srv import NodeletList, NodeletLoad, NodeletLoadRequest, NodeletUnload

from graph import FULL, Client, Scene, Stream

ROUNDS = 200 if FULL else 20


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
        # What has to have been answered before it is unloaded again.
        stages = (lambda answers: True, lambda answers: answers, lambda answers: any(m.status == MatchStats.OK for m in answers))
        seconds = []
        for i in range(ROUNDS):
            # Anew, and none that is still connecting when the nodelet goes: rospy would take either for a connection to the
            # nodelet that is loaded next.
            while client.subscribers:
                client.subscribers.pop().unregister()
            if i % len(stages):
                client.listen()
            before = len(client.stats)
            rospy.set_param(name + "/threads", 1 + i % 4)
            request = NodeletLoadRequest(name=name, type="gms_ransac/MatchFilter")
            self.assertTrue(load(request).success, "load %d" % i)
            reached = stages[i % len(stages)]
            client.wait(lambda: reached(client.stats[before:]), "an answer in round %d" % i)
            start = time.monotonic()
            self.assertTrue(unload(name=name).success, "unload %d" % i)
            seconds.append(time.monotonic() - start)
            self.assertEqual(loaded().nodelets, [])
        stream.stop()
        print("unloaded %d times, in %.3f s on average, %.3f s at most" % (ROUNDS, sum(seconds) / ROUNDS, max(seconds)))


if __name__ == "__main__":
    rospy.init_node("nodelet_reload_test")
    rostest.rosrun("gms_ransac", "nodelet_reload", NodeletReload)
