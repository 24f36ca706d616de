#!/usr/bin/env python3
"""Nodelets that share a manager, and nodelets that are loaded and unloaded while images flow: each answers every image as
it would alone, and the manager keeps no memory, thread or file of those that have left."""
import itertools
import os
import unittest

import numpy as np
import rospy
import rostest
from gms_ransac.msg import MatchStats
from nodelet.srv import NodeletList, NodeletLoad, NodeletLoadRequest, NodeletUnload
from rosgraph_msgs.msg import Log
from tf2_msgs.msg import TFMessage

from graph import FULL, Client, Stream, said_by, walk
from processes import pid_of, resident_mb

CYCLES = 200 if FULL else 4
GROWTH_MB = 2  # from the second quarter of the cycles to the last; in the first the allocator takes pages that it keeps


class Nodelets(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.frames = walk(4)
        cls.first = Client("first").connect()
        cls.pid = pid_of("/manager")

    def load(self, name, **parameters):
        rospy.set_param(name, dict({"drop_frames": False, "queue_size": 200}, **parameters))
        request = NodeletLoadRequest(name=name, type="gms_ransac/MatchFilter")
        self.assertTrue(rospy.ServiceProxy("manager/load_nodelet", NodeletLoad)(request).success)

    def unload(self, name):
        self.assertTrue(rospy.ServiceProxy("manager/unload_nodelet", NodeletUnload)(name=name).success)
        self.assertNotIn(name, rospy.ServiceProxy("manager/list", NodeletList)().nodelets)

    def threads_and_files(self):
        return tuple(len(os.listdir("/proc/%d/%s" % (self.pid, kind))) for kind in ("task", "fd"))

    def answers(self, start):
        """The correspondences of the frames from a new beginning on."""
        self.first.ask(self.frames[1], start - 100)  # the next one is not the same again, which would be given noise
        for i, frame in enumerate(self.frames):
            answer = self.first.ask(frame, start + 0.1 * i)
        self.assertEqual(answer.status, MatchStats.OK, answer.status_text)
        return [self.first.correspondence(start + 0.1 * i) for i in (1, 2, 3)]

    def test_two_answer_the_same_images_as_one_alone(self):
        """And the second leaves the transform to the first, although both are one node to tf."""
        transforms, errors = [], said_by("manager", Log.ERROR)
        listening = rospy.Subscriber("/tf", TFMessage, lambda m: transforms.extend(
            t.header.stamp for t in m.transforms if t.child_frame_id == "camera_reference"))
        self.first.wait(listening.get_num_connections, "tf")
        alone = self.answers(10000)
        self.load("/second", threads=2, features=500)
        self.addCleanup(self.unload, "/second")
        second, stamps = Client("second"), itertools.count(15000)
        other = itertools.cycle(self.frames[1:3])  # no image twice in a row, which would be given noise
        second.wait(lambda: self.first.ask(next(other), next(stamps)) and second.stats, "an answer of the second")
        for one, both in zip(alone, self.answers(20000)):
            self.assertEqual(one.current_points, both.current_points)
            self.assertEqual(one.current_in_reference, both.current_in_reference)
        for i in (1, 2, 3):
            self.assertTrue(second.correspondence(20000 + 0.1 * i).pose_valid)
        stamps = itertools.count(30000)
        self.first.wait(lambda: self.first.ask(next(other), next(stamps)) and transforms and errors, "transforms, and the refusal")
        self.assertEqual(len(errors), 1, errors)
        self.assertIn("/second: ", errors[0])
        self.assertIn("broadcasts the transform camera -> camera_reference, and a frame can have only one parent", errors[0])
        self.assertEqual(len(transforms), len(set(transforms)), "each stamp once")
        listening.unregister()

    def test_loaded_and_unloaded_while_images_flow(self):
        before = len(self.first.stats)
        stream = Stream(self.first, self.frames, ahead=10)
        stream.start()
        passing, held = Client("passing"), []
        for i in range(CYCLES):
            self.load("/passing", threads=1 + i % 4)
            seen = len(passing.stats)
            self.first.wait(lambda: any(m.status == MatchStats.OK for m in passing.stats[seen:]), "an answer of cycle %d" % i)
            self.unload("/passing")
            held.append((resident_mb(self.pid), *self.threads_and_files()))
        stream.stop()
        rospy.loginfo("held by the manager (MB, threads, files): %s", held)
        self.first.answer(before + stream.sent)
        self.assertEqual(self.first.stats[-1].frames_dropped, 0)
        if FULL:
            quarter = CYCLES // 4
            second, last = np.array(held[quarter:2 * quarter]), np.array(held[-quarter:])
            self.assertLess(np.median(last[:, 0]) - np.median(second[:, 0]), GROWTH_MB, held)
            # A connection or thread that ends just then is counted now and then.
            for kind in (1, 2):
                self.assertLessEqual(np.median(last[:, kind]), np.median(second[:, kind]), held)


if __name__ == "__main__":
    rospy.init_node("nodelets_test")
    rostest.rosrun("gms_ransac", "nodelets", Nodelets)
