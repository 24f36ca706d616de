#!/usr/bin/env python3
"""Lets a paused `rosbag play --clock` go once everybody listens, so that the beginning of the bag is not lost.

Awaits a connected subscriber on each of ~played (those of them that the bag holds) and of ~outputs, for at most
~patience seconds; then plays anyway and says which of them nobody listens to. Ends when the bag plays.

Parameters: ~played and ~outputs (topics, separated by blanks), ~patience. Service: player/pause_playback.
"""
import time
import xmlrpc.client

import rosgraph
import rospy
from std_srvs.srv import SetBool

LOOK_AGAIN = 0.05  # seconds of wall time; simulated time stands still


class Listeners:
    """Who is connected to what, asked of the nodes that publish: a registration at the master alone receives nothing."""

    def __init__(self):
        self.master = rosgraph.Master(rospy.get_name())

    def publishers(self):
        """{topic: names of the nodes that publish it}"""
        return dict(self.master.getSystemState()[0])

    def has(self, topic, nodes):
        return any(self.connected(topic, node) for node in nodes)

    def connected(self, topic, node):
        try:
            with xmlrpc.client.ServerProxy(self.master.lookupNode(node)) as proxy:
                _, _, connections = proxy.getBusInfo(rospy.get_name())
        except (OSError, xmlrpc.client.Error, rosgraph.MasterException):
            return False  # it has just ended
        return any(direction == "o" and name == topic for _, _, direction, _, name, *_ in connections)


def topics(parameter):
    return [rospy.resolve_name(topic) for topic in rospy.get_param(parameter, "").split()]


def unheard(listeners, played, outputs):
    """The topics that somebody should listen to and nobody does."""
    publishers = listeners.publishers()
    expected = [topic for topic in played if topic in publishers] + outputs
    return [topic for topic in expected if not listeners.has(topic, publishers.get(topic, []))]


def run():
    played, outputs, patience = topics("~played"), topics("~outputs"), rospy.get_param("~patience", 30.0)
    # The paused player's clock stands, but it is told: from then on every topic of the bag is advertised.
    while rospy.get_rostime().is_zero() and not rospy.is_shutdown():
        time.sleep(LOOK_AGAIN)
    listeners, end = Listeners(), time.monotonic() + patience
    missing = unheard(listeners, played, outputs)
    while missing and time.monotonic() < end and not rospy.is_shutdown():
        time.sleep(LOOK_AGAIN)
        missing = unheard(listeners, played, outputs)
    if missing:
        rospy.logwarn("nobody has listened to %s for %g s; the bag is played all the same", " or ".join(missing), patience)
    rospy.wait_for_service("player/pause_playback")
    rospy.ServiceProxy("player/pause_playback", SetBool)(False)


if __name__ == "__main__":
    rospy.init_node("start_replay")
    try:
        run()
    except (rospy.ROSInterruptException, rospy.ServiceException):
        pass  # the launch is being ended
