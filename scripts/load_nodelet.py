#!/usr/bin/env python3
"""`nodelet load` for a launch file with respawn: ends when the manager it loaded into has been replaced.

nodelet itself notices by a bond, but not always: when the manager dies between the first and the second sign of life, the
bond of bondcpp before 1.8.7 waits for ever (github.com/ros/bond_core/pull/93), and the nodelet never comes back.

Arguments: those of `nodelet`: load, type, manager.
"""
import os
import signal
import sys
import time
import xmlrpc.client

import rosgraph

PERIOD = 1.0  # seconds between two questions


def process_of(node):
    """Where a node can be asked, which differs from start to start; None: the master does not know or does not answer."""
    try:
        return rosgraph.Master("/load_nodelet").lookupNode(node)
    except (OSError, rosgraph.MasterException, xmlrpc.client.Error):
        return None


def watch(loader, manager):
    """Ends the process `loader`, our parent, when `manager` is another process than it was at first."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # ends with the parent
    first = None
    while os.getppid() == loader:
        now = process_of(manager)
        first = first or now
        if now not in (None, first):
            # There is nothing to unload: the nodelet went with its manager.
            print("[load_nodelet] %s was replaced; the nodelet is loaded again" % manager, flush=True)
            os.kill(loader, signal.SIGTERM)
            return
        time.sleep(PERIOD)


def main():
    arguments = rosgraph.myargv(sys.argv)[1:]
    if len(arguments) < 3 or arguments[0] != "load":
        sys.exit("load_nodelet.py: give it the arguments of nodelet: load, type, manager")
    manager = rosgraph.names.ns_join(rosgraph.names.get_ros_namespace(), arguments[2])
    loader = os.getpid()
    if os.fork() == 0:
        watch(loader, manager)
        os._exit(0)
    os.execlp("rosrun", "rosrun", "nodelet", "nodelet", *sys.argv[1:])


if __name__ == "__main__":
    main()
