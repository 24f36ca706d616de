#!/usr/bin/env python3
"""Starts a paused `rosbag play --clock` once every subscriber is connected, so that the beginning of the bag is not lost.

Waits at most ~patience seconds for a subscriber on each of ~played (those of them that the bag holds) and of ~outputs, then
plays anyway and logs the topics without one. With ~paused the bag stays paused. Logs the end of the bag. Ends with an error,
and the launch with it, when the file ~bag does not exist or has no images on ~image, ~right or ~depth; the message lists the
images it has and the arguments that read them.

Parameters: ~bag, ~image, ~image_transport, ~right and ~depth (empty: not needed), ~played and ~outputs (topics, separated by
blanks), ~paused, ~patience. Service: player/pause_playback.
"""
import os
import re
import sys
import time
import xmlrpc.client

import rosbag
import rosgraph
import rospy
from std_srvs.srv import SetBool

LOOK_AGAIN = 0.05  # seconds of wall time; simulated time stands still
LOOK_FOR_THE_END = 0.5


class Subscribers:
    """Connections, asked of the nodes that publish: a registration at the master does not mean a connection."""

    def __init__(self):
        self.master = rosgraph.Master(rospy.get_name())

    def publishers(self):
        """{topic: names of the nodes that publish it}"""
        return dict(self.master.getSystemState()[0])

    def plays(self):
        """Returns false once the player has ended."""
        try:
            self.master.lookupService(rospy.resolve_name("player/pause_playback"))
        except rosgraph.MasterError:
            return False
        except OSError:
            pass  # the master is busy, or gone
        return True

    def has(self, topic, nodes):
        return any(self.connected(topic, node) for node in nodes)

    def connected(self, topic, node):
        try:
            with xmlrpc.client.ServerProxy(self.master.lookupNode(node)) as proxy:
                _, _, connections = proxy.getBusInfo(rospy.get_name())
        except (OSError, xmlrpc.client.Error, rosgraph.MasterException):
            return False  # it has just ended
        return any(direction == "o" and name == topic for _, _, direction, _, name, *_ in connections)


def arguments_for(topic, kind):
    """The launch file and the arguments that read images of this topic."""
    kitti = re.fullmatch(r"/kitti/camera_(\w+)/image_(raw|rect)", topic)
    if kitti:
        return "kitti.launch camera:=%s variant:=%s" % (kitti[1], "raw" if kitti[2] == "raw" else "odom")
    compressed = "CompressedImage" in kind
    base = re.sub("/compressed$", "", topic) if compressed else topic
    launch = "tum.launch" if base == "/camera/rgb/image_color" else "replay.launch image:=" + base
    return launch + (" image_transport:=compressed" if compressed else "")


def problem_of(bag, image, right="", depth=""):
    """Why this bag cannot be replayed with images of these topics, and the remedy; empty: it can."""
    if not os.path.isfile(bag):
        return "there is no file %s; give bag:= the path of a bag" % bag
    try:
        with rosbag.Bag(bag) as opened:
            kinds = {name: info.msg_type for name, info in opened.get_type_and_topic_info().topics.items()}
    except rosbag.ROSBagException as error:
        return "%s cannot be read: %s" % (bag, error)
    if image not in kinds:
        images = ["%s (%s)" % (name, arguments_for(name, kind)) for name, kind in sorted(kinds.items())
                  if kind in ("sensor_msgs/Image", "sensor_msgs/CompressedImage")]
        return "%s has no messages on %s; %s" % (bag, image, "its images: " + ", ".join(images) if images else "it has no images")
    if right and right not in kinds:
        return "%s has no messages on %s, the images of the right camera; leave stereo:=true out" % (bag, right)
    if depth and depth not in kinds:
        return "%s has no messages on %s, which scale:=depth reads; leave scale:=depth out" % (bag, depth)
    return ""


def topics(parameter):
    return [rospy.resolve_name(topic) for topic in rospy.get_param(parameter, "").split()]


def unheard(subscribers, played, outputs):
    """The topics that should have a subscriber and have none."""
    publishers = subscribers.publishers()
    expected = [topic for topic in played if topic in publishers] + outputs
    return [topic for topic in expected if not subscribers.has(topic, publishers.get(topic, []))]


def run():
    transport = rospy.get_param("~image_transport", "raw")
    image = rospy.get_param("~image") + ("" if transport == "raw" else "/" + transport)
    problem = problem_of(rospy.get_param("~bag"), image, rospy.get_param("~right", ""), rospy.get_param("~depth", ""))
    if problem:
        rospy.logfatal("%s", problem)
        return 1
    played, outputs, patience = topics("~played"), topics("~outputs"), rospy.get_param("~patience", 30.0)
    # The paused player's clock stands still, but it is published: from then on every topic of the bag is advertised.
    while rospy.get_rostime().is_zero() and not rospy.is_shutdown():
        time.sleep(LOOK_AGAIN)
    subscribers, end = Subscribers(), time.monotonic() + patience
    missing = unheard(subscribers, played, outputs)
    while missing and time.monotonic() < end and not rospy.is_shutdown():
        time.sleep(LOOK_AGAIN)
        missing = unheard(subscribers, played, outputs)
    if missing:
        rospy.logwarn("no subscriber on %s after %g s; the bag is played all the same", " or ".join(missing), patience)
    if not rospy.get_param("~paused", False):
        rospy.wait_for_service("player/pause_playback")
        rospy.ServiceProxy("player/pause_playback", SetBool)(False)
    while subscribers.plays() and not rospy.is_shutdown():
        time.sleep(LOOK_FOR_THE_END)
    if not rospy.is_shutdown():
        rospy.loginfo("the bag has ended; the graph goes on so that you can look at it: Ctrl-C ends it")
    rospy.spin()
    return 0


if __name__ == "__main__":
    sys.stdout.reconfigure(line_buffering=True)  # said at once also where the output is no terminal
    rospy.init_node("start_replay")
    try:
        sys.exit(run())
    except (rospy.ROSInterruptException, rospy.ServiceException):
        pass  # the launch is being ended
