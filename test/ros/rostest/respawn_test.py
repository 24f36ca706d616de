#!/usr/bin/env python3
"""Manager and node are killed, as soon as they run, and come back by themselves every time (respawn of match_filter.launch)."""
import os
import signal

from graph import FULL, run, wait_for
from processes import GraphTest

# The moment that matters, between the first and the second sign of life of nodelet's bond, is a second long.
KILLS = 6 if FULL else 2
SAYS_IT_RUNS = "/match_filter: ~input"


class Respawn(GraphTest):
    def kill(self, name, log, sentence):
        """Kills the process of a node; returns when the launch says once more that the filter runs."""
        pid, before = wait_for(lambda: self.pid(name), name), self.count(log, sentence)
        os.kill(pid, signal.SIGKILL)
        wait_for(lambda: self.count(log, sentence) > before, "%s to come back" % name)
        self.assertNotEqual(self.pid(name), pid)

    def test_comes_back(self):
        log = self.launch(os.path.join(os.path.dirname(os.path.abspath(__file__)), "respawn.launch"))
        self.says(log, SAYS_IT_RUNS)
        self.says(log, "/node: ~input")
        for _ in range(KILLS):
            self.kill("/manager", log, SAYS_IT_RUNS)
        self.kill("/node", log, "/node: ~input")


if __name__ == "__main__":
    run("respawn", Respawn)
