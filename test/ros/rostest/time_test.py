#!/usr/bin/env python3
"""A simulated clock that restarts, gaps, late images, and exact pairing of camera_info through all of it."""
import unittest

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from gms_ransac.msg import MatchStats
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Bool

from graph import camera_info, client_of, run, said_by, walk


class Time(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.clock = rospy.Publisher("/clock", Clock, queue_size=10, latch=True)
        cls.reports = []
        cls.listener = rospy.Subscriber("/diagnostics", DiagnosticArray, cls.reports.append)
        cls.frames = walk(4)

    def play(self, client, start):
        """Clock and images as `rosbag play --clock` sends them; returns the statuses."""
        statuses = []
        for i in range(len(self.frames)):
            self.clock.publish(Clock(rospy.Time.from_sec(start + 0.1 * i)))
            client.wait(lambda: abs(rospy.get_time() - start - 0.1 * i) < 1e-6, "the clock")
            statuses.append(client.ask(self.frames[i], start + 0.1 * i).status)
        return statuses

    def check(self, name, base):
        client, restarts = client_of(name), []
        client.subscribe("restart", Bool, restarts)
        client.connect()
        ok = MatchStats.OK
        first = self.play(client, base)
        self.assertEqual(first[1:], [ok] * 3)
        # The bag starts again: stamps and clock go back. The filter has the clock first, as its reports show, or the image
        # would be one that was overtaken.
        count = len(self.reports)
        self.clock.publish(Clock(rospy.Time.from_sec(base)))
        client.wait(lambda: any(report.header.stamp.to_sec() == base and any(name in status.name for status in report.status)
                                for report in self.reports[count:]), "the filter's clock to go back")
        again = self.play(client, base)
        self.assertEqual(again, [MatchStats.TIME_RESET] + [ok] * 3)
        client.wait(lambda: restarts, "~restart")
        resets = client.stats[-1].resets
        # Five seconds without an image.
        self.assertEqual(self.play(client, base + 5), [MatchStats.TIME_RESET] + [ok] * 3)
        self.assertEqual(client.stats[-1].resets, resets + 1)
        # An image that was overtaken is dropped, and the next one compared with the last in order.
        answer = client.ask(self.frames[1], base + 5.15)
        self.assertEqual(answer.status, MatchStats.BAD_IMAGE)
        self.assertIn("out of order", answer.status_text)
        self.assertEqual(client.ask(self.frames[2], base + 5.4).status, ok)

    def test_a_clock_that_never_came(self):
        """First of all, in the order of names: what a replay leaves for a live camera, /use_sim_time and no /clock."""
        client, said = client_of("latest").connect(), said_by("silent")
        client.ask(self.frames[0], 100.0)
        client.wait(lambda: any("/clock" in status.message and "latest" in status.name
                                for report in self.reports for status in report.status), "a word on the clock")
        client.wait(lambda: any("nobody publishes" in line for line in said), "the log to name the silent topic")

    def test_clock_that_stands(self):
        """The images go on: they are answered as if nothing were wrong, and the node still reports."""
        client = client_of("latest").connect()
        self.play(client, 3000.0)
        for i in range(1, 20):
            answer = client.ask(self.frames[i % 4], 3000.3 + 0.1 * i)
            self.assertEqual(answer.status, MatchStats.OK, answer.status_text)
        count = len(self.reports)
        client.wait(lambda: len(self.reports) > count + 4, "reports while the clock stands")
        # As at the end of a bag: no image, and no warning.
        client.image.unregister()
        client.wait(lambda: any("/clock stands still" in s.message and s.level == 0 for s in self.reports[-1].status),
                    "a word on the clock")
        count = len(self.reports)
        client.wait(lambda: len(self.reports) > count + 15, "reports after the end")
        self.assertFalse([s for report in self.reports[count:] for s in report.status if s.level and "latest" in s.name])

    def test_latest_camera_info(self):
        self.check("latest", 1000.0)

    def test_exact_camera_info(self):
        self.check("exact", 500.0)
        # The filter leaves out an image without camera_info of its stamp, and counts it.
        client = client_of("exact").connect()
        client.send(self.frames[0], 700.0, info=camera_info(700.05))
        answer = client.ask(self.frames[0], 700.1)
        self.assertEqual((answer.frames_dropped, answer.frames_received), (1, answer.frames_processed + 1))
        without = lambda: [value.value for status in self.reports[-1].status if status.name.endswith("exact: input")
                           for value in status.values if value.key == "frames without camera_info of their stamp"]
        client.wait(lambda: "1" in without(), "diagnostics to count the image")
        timing = lambda: [s.message for r in self.reports for s in r.status if s.name.endswith("exact: timing")]
        self.assertFalse([text for text in timing() if "newer ones arrived first" in text], "it was not for want of time")


if __name__ == "__main__":
    rospy.set_param("/use_sim_time", True)
    run("time", Time, latest={}, exact={"camera_info_sync": "exact"}, silent={"always_subscribe": True})
