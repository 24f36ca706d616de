#!/usr/bin/env python3
"""What scripts/soak runs: starts a graph of its own, disturbs it, watches it, and judges.

Two filters take the same images: the nodelet in a manager (every image, one thread) and the node (the newest, two threads).
"""
import argparse
import csv
import json
import math
import os
import random
import signal
import socket
import subprocess
import sys
import threading
import time
from collections import Counter

import numpy as np
import rosbag
import rospy
from dynamic_reconfigure.client import Client as Reconfigure
from gms_ransac.msg import MatchStats
from sensor_msgs.msg import CameraInfo, Image
from report.common import pyplot
from std_srvs.srv import SetBool, Trigger

PROCESSES = {"manager": "/nodelet_filter", "node": "/node_filter"}  # and the filters that they hold
FILTERS = tuple(PROCESSES.values())
SETTLED = 60.0  # seconds after which memory has to stay what it is,
SETTLED_IMAGES = 20000  # and images: a starved machine answers few in a minute, an idle one about so many
GROWTH_MB = 2.0
MASTER_FILES = 2  # roscpp keeps a connection to the master for each call that ever overlapped another
REST_EVERY, REST = 60.0, 4.0  # seconds; the parameters of the start are in force again for a while, see `growth`
WINDOW = 30  # samples, one a second, at the beginning and at the end of what is judged
SMALL = {"features": 300, "fast_threshold": 10, "pyramid_levels": 4}

# Each is set on top of what is in force, so that most pairs of them occur.
CHANGES = ([{"method": name} for name in ("lo_prosac", "gms_ransac", "cp_ransac", "prosac", "ransac", "lan", "subset_ransac")] +
           [{"features": count} for count in (100, 200, 300)] +
           [{"model": name} for name in ("fundamental", "homography", "essential", "essential")] +
           [{"gms_rotation": True}, {"gms_rotation": False}, {"gms_scale": True}, {"gms_scale": False},
            {"hold_reference": False}, {"hold_reference": True}, {"publish_rejected": True}, {"publish_rejected": False},
            {"publish_odom_tf": True}, {"publish_odom_tf": False}, {"feature_limit": 0}, {"feature_limit": 220}])
OUTPUTS = ("correspondences", "match_image", "odom", "path", "features", "match_markers", "inlier_points", "relative_pose", "twist")


def free_port():
    with socket.socket() as chosen:
        chosen.bind(("", 0))
        return chosen.getsockname()[1]


class Graph:
    """The processes; ended with `stop`."""

    def __init__(self, out):
        self.out, self.processes = out, {}
        os.environ["ROS_MASTER_URI"] = "http://localhost:%d" % free_port()

    def start(self, name, *command):
        log = open(os.path.join(self.out, name + ".log"), "w")
        # With one arena of malloc the resident memory is what is held. Freed memory of others stays, more and less.
        self.processes[name] = subprocess.Popen(command, stdout=log, stderr=log, env=dict(os.environ, MALLOC_ARENA_MAX="1"))

    def start_filters(self):
        self.start("master", "roscore", "-p", os.environ["ROS_MASTER_URI"].rsplit(":", 1)[1])
        while not master_answers():
            time.sleep(0.1)
        rospy.set_param(FILTERS[0], dict(SMALL, drop_frames=False, always_subscribe=True))
        # With frames of its own: else the two would broadcast the same transforms.
        rospy.set_param(FILTERS[1], dict(SMALL, threads=2, always_subscribe=True, publish_relative_tf=False, invert_odom_tf=True,
                                         odom_frame="node_odom"))
        # rosrun becomes the program: these are the processes that hold the filters.
        self.start("manager", "rosrun", "nodelet", "nodelet", "manager", "__name:=manager")
        self.start("loader", "rosrun", "nodelet", "nodelet", "load", "gms_ransac/MatchFilter", "/manager", "__name:=" + FILTERS[0][1:])
        self.start("node", "rosrun", "gms_ransac", "match_filter_node", "__name:=" + FILTERS[1][1:])
        for name in FILTERS:
            rospy.wait_for_service(name + "/reset")

    def dead(self):
        return [name for name, process in self.processes.items() if process.poll() is not None]

    def stop(self):
        for process in reversed(list(self.processes.values())):
            process.send_signal(signal.SIGINT)
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()


def master_answers():
    try:
        rospy.get_master().getPid()
        return True
    except OSError:
        return False


def held(pid):
    """(resident MB, threads, file descriptors) of a process (proc(5))."""
    with open("/proc/%d/status" % pid) as lines:
        fields = dict(line.split(":", 1) for line in lines)
    return int(fields["VmRSS"].split()[0]) / 1024, int(fields["Threads"]), len(os.listdir("/proc/%d/fd" % pid))


class Player(threading.Thread):
    """Plays the images of a bag over and over, as fast as the faster of the filters answers, and judges the answers. Stamps are
    those of the bag: they go back with every loop."""
    TOPICS = ("/camera/rgb/image_color", "/camera/rgb/camera_info")
    AHEAD = 3  # images that wait at the filter that answers first
    PATIENCE = 0.02  # seconds; while all filters are paused, an image is sent so often

    def __init__(self, path):
        super().__init__(daemon=True)
        with rosbag.Bag(path) as bag:
            messages = {topic: [message for _, message, _ in bag.read_messages(topic)] for topic in self.TOPICS}
        self.images, infos = messages.values()
        if len(self.images) < 2 or not infos:
            sys.exit("soak: %s needs two images on %s and their camera_info" % (path, self.TOPICS[0]))
        self.info, self.start_time = infos[0], time.monotonic()
        self.publishers = [rospy.Publisher(name, kind, queue_size=10) for name, kind in (("image", Image), ("camera_info", CameraInfo))]
        self.changed, self.sent, self.count, self.newest, self.stopping = threading.Condition(), {}, 0, 0, False
        self.answers = {name: dict(answered=0, wrong=Counter(), statuses=Counter(), latencies=[], last=MatchStats()) for name in FILTERS}
        self.subscribers = [rospy.Subscriber(name + "/stats", MatchStats, self.on_stats, name, queue_size=1000) for name in FILTERS]

    def run(self):
        while not self.stopping:
            image = self.images[self.count % len(self.images)]
            with self.changed:
                self.count += 1
                self.changed.wait_for(lambda: self.newest + self.AHEAD >= self.count, self.PATIENCE)
                self.sent[image.header.stamp] = self.count, time.monotonic()
            self.info.header.stamp = image.header.stamp
            self.publishers[1].publish(self.info)
            self.publishers[0].publish(image)

    def on_stats(self, stats, name):
        with self.changed:
            number, when = self.sent.get(stats.header.stamp, (0, math.nan))
            answer = self.answers[name]
            answer["wrong"].update(self.complaints(stats, answer["last"], number > 0))
            answer["answered"] += 1
            answer["statuses"][stats.status] += 1
            answer["latencies"].append(1e3 * (time.monotonic() - when))
            answer["last"] = stats
            self.newest = max(self.newest, number)
            self.changed.notify_all()

    @staticmethod
    def complaints(stats, last, was_sent):
        """What no answer may be."""
        if not was_sent:
            yield "answers to images that were never sent"
        if stats.frames_processed <= last.frames_processed:
            yield "counts of processed images that did not rise"
        if stats.frames_received < stats.frames_processed + stats.frames_passed_over + stats.frames_dropped:
            yield "more images answered than came"
        if not stats.inliers <= stats.matches_gms <= stats.matches_raw:
            yield "more inliers than matches"
        if not all(map(math.isfinite, (stats.inlier_ratio, stats.median_parallax_px, stats.rms_error_px, stats.time_total))):
            yield "numbers that are not finite"

    def report(self):
        """The columns of a row; latencies are of the time since the last report."""
        with self.changed:
            row = dict(seconds=time.monotonic() - self.start_time, sent=self.count, loops=self.count // len(self.images))
            for process, name in PROCESSES.items():
                answer, last = self.answers[name], self.answers[name]["last"]
                p50, p99 = map(float, np.percentile(answer["latencies"], (50, 99))) if answer["latencies"] else ("", "")
                answer["latencies"] = []
                columns = dict(answered=answer["answered"], received=last.frames_received, processed=last.frames_processed,
                               dropped=last.frames_dropped, resets=last.resets, p50_ms=p50, p99_ms=p99,
                               wrong=json.dumps(answer["wrong"]) if answer["wrong"] else "",
                               statuses=json.dumps(answer["statuses"]))
                row.update((process + "_" + column, value) for column, value in columns.items())
            return row


class Disturbance(threading.Thread):
    """Does something to one of the filters every now and then; the first minute holds all changes of parameters once."""

    def __init__(self, seed, steady, reconfigurations=0):
        super().__init__(daemon=True)
        self.steady, self.reconfigurations = steady, reconfigurations
        self.random, self.stopping, self.done = random.Random(seed), threading.Event(), Counter()
        self.reconfigure = {name: Reconfigure(name, timeout=30) for name in FILTERS}
        self.at_start = {name: client.get_configuration() for name, client in self.reconfigure.items()}
        self.resting = steady
        self.rate = 0.0  # actions a second after the first minute, without the rests
        self.listeners = []

    def run(self):
        every = [] if self.steady else [(name, change) for name in FILTERS for change in CHANGES]
        for name, change in every:
            if self.stopping.wait(0.8 * SETTLED / len(every)):
                return
            self.change(name, change)
            self.listen(name)
        actions = (self.listen, self.listen, self.reset, self.pause) + (() if self.steady else (self.change, self.change))
        pause = lambda: self.random.uniform(0.1, 1.5)
        if self.reconfigurations > 0:
            actions, pause = (self.change,), lambda: 1 / self.reconfigurations
        due = begin = time.monotonic()
        rested = actions_done = 0.0
        while not self.stopping.wait(due - time.monotonic()):
            name, action = self.random.choice(FILTERS), self.random.choice(actions)
            due += pause()  # not from the end of the action, which may take long
            try:
                if not self.steady and time.monotonic() > rested + REST_EVERY:
                    started = time.monotonic()
                    self.rest()
                    rested = time.monotonic()
                    due, begin = due + rested - started, begin + rested - started
                action(name)
                actions_done += 1
                self.rate = actions_done / max(time.monotonic() - begin, 1e-3)
            except (rospy.ROSException, rospy.ServiceException) as error:
                self.done["failed: %s" % error] += 1

    def change(self, name, change=None):
        self.reconfigure[name].update_configuration(change or self.random.choice(CHANGES))
        self.done["reconfigurations"] += 1

    def rest(self):
        """The parameters of the start, until what was in work with others is answered and a sample or two are taken."""
        for name in FILTERS:
            self.change(name, self.at_start[name])
        self.stopping.wait(REST / 2)
        self.resting = True
        self.stopping.wait(REST)
        self.resting = False

    def reset(self, name):
        rospy.ServiceProxy(name + "/reset", Trigger)()
        self.done["resets"] += 1

    def pause(self, name):
        pause = rospy.ServiceProxy(name + "/pause", SetBool)
        pause(True)
        self.stopping.wait(self.random.uniform(0, 1))
        pause(False)
        self.done["pauses"] += 1

    def listen(self, name):
        """One more listener; the oldest leaves."""
        topic = "%s/%s" % (name, self.random.choice(OUTPUTS))
        self.listeners.append(rospy.Subscriber(topic, rospy.AnyMsg, lambda message: None, queue_size=1))
        if len(self.listeners) > 3:
            self.listeners.pop(0).unregister()
        self.done["listeners"] += 1

    def stop(self):
        self.stopping.set()
        self.join(10)  # seconds; a service of a filter that has died is not waited for


def is_settled(row):
    return row["seconds"] >= SETTLED and enough(row, SETTLED_IMAGES)


class Record:
    """One row a second, in soak.csv as it comes."""

    def __init__(self, path):
        self.rows, self.file = [], open(path, "w", newline="", buffering=1)

    def add(self, row):
        writer = csv.DictWriter(self.file, list(row))
        if not self.rows:
            writer.writeheader()
        writer.writerow(row)
        self.rows.append(row)

    def settled(self, column):
        return [row[column] for row in self.rows if is_settled(row)]


def row_of(report, graph, resting):
    row = dict(report, resting=int(resting))
    for process in PROCESSES:
        for column, value in zip(("mb", "threads", "files"), held(graph.processes[process].pid)):
            row["%s_%s" % (process, column)] = value
    return row


def growth(record, process):
    """MB by which the least of the second half of the samples exceeds that of the first half, among those that have the
    parameters of the start: others need more memory or less. The allocator gives its free memory back at times, or keeps it,
    so that single samples differ by some MB; what is never freed raises the least, too."""
    memory = [row[process + "_mb"] for row in record.rows if is_settled(row) and row["resting"]]
    half = len(memory) // 2
    return min(memory[half:]) - min(memory[:half]) if half else float("nan")


def judge(record, died):
    """(lines of a summary, complaints)"""
    complaints = ["%s ended by itself" % name for name in died]
    if len(record.settled("seconds")) < 2 * WINDOW:
        return ["ended before there is anything to judge"], complaints + [
            "too short: a minute beyond the first, and beyond %d images of each" % SETTLED_IMAGES]
    last = record.rows[-1]
    lines = ["%d images sent in %.0f s, %d loops of the bag" % (last["sent"], last["seconds"], last["loops"])]
    for process in PROCESSES:
        value = lambda column: last["%s_%s" % (process, column)]
        memory, threads, files = (record.settled("%s_%s" % (process, column)) for column in ("mb", "threads", "files"))
        grown = growth(record, process)
        latency = [v for v in record.settled(process + "_p99_ms") if v != ""]
        lines.append("%s: %d answered, %d dropped, %d resets; memory %.1f MB once settled, at most %+.2f MB after that, %+.2f MB with the parameters of the start; "
                     "threads %d to %d, files %d to %d; p99 of a second: median %.1f ms, worst %.1f ms; statuses %s" %
                     (process, value("processed"), value("dropped"), value("resets"), memory[0], max(memory) - memory[0], grown,
                      min(threads), max(threads), min(files), max(files), np.median(latency), max(latency), value("statuses")))
        if not grown <= GROWTH_MB:
            complaints.append("%s grew by %.2f MB from the first half to the second, more than %g" % (process, grown, GROWTH_MB))
        # Listeners come and go, so what counts is the least of a while.
        for what, values, more in (("threads", threads, 0), ("files", files, MASTER_FILES)):
            if min(values[-WINDOW:]) > max(values[:WINDOW]) + more:
                complaints.append("%s holds %d %s at the end and %d after a minute" % (process, min(values[-WINDOW:]), what, max(values[:WINDOW])))
        if value("wrong"):
            complaints.append("%s: %s" % (process, value("wrong")))
        if value("received") - value("processed") - value("dropped") not in range(0, 20):
            complaints.append("%s: %d received, %d processed and %d dropped do not add up" % (process, value("received"), value("processed"), value("dropped")))
    return lines, complaints


def plot(record, path):
    plt = pyplot()
    if not plt:
        return
    panels = (("resident memory (MB)", "mb"), ("threads", "threads"), ("file descriptors", "files"), ("latency p99 (ms)", "p99_ms"),
              ("images answered", "processed"), ("images dropped", "dropped"), ("resets", "resets"))
    figure, axes = plt.subplots(len(panels), sharex=True, figsize=(9, 2 * len(panels)))
    hours = [row["seconds"] / 3600 for row in record.rows]
    for axis, (title, column) in zip(axes, panels):
        for process in PROCESSES:
            axis.plot(hours, [float(row["%s_%s" % (process, column)] or "nan") for row in record.rows], label=process, linewidth=0.8)
        axis.set_ylabel(title, fontsize=8)
        axis.grid(alpha=0.3)
    axes[3].set_yscale("log")
    axes[0].legend()
    axes[-1].set_xlabel("hours")
    figure.tight_layout()
    figure.savefig(path, dpi=80)


def enough(row, images):
    return min(row["manager_processed"], row["node_processed"]) >= images


def main():
    parser = argparse.ArgumentParser(allow_abbrev=False)
    parser.add_argument("hours", type=float)
    parser.add_argument("bag")
    parser.add_argument("out")
    parser.add_argument("--images", type=int, default=0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--steady", action="store_true")
    parser.add_argument("--reconfigure", type=float, default=0)
    options = parser.parse_args()
    graph, record, died = Graph(options.out), Record(os.path.join(options.out, "soak.csv")), []
    end = time.monotonic() + 3600 * options.hours
    disturbance = player = None
    for number in (signal.SIGINT, signal.SIGTERM):  # a shell ignores the first for what it starts in the background
        signal.signal(number, signal.default_int_handler)
    try:
        graph.start_filters()
        rospy.init_node("soak", disable_signals=True)
        player = Player(options.bag)
        player.start()
        disturbance = Disturbance(options.seed, options.steady, options.reconfigure)
        disturbance.start()
        while True:
            time.sleep(1)
            died = graph.dead()
            if died:
                break
            record.add(row_of(player.report(), graph, disturbance.resting))
            if time.monotonic() > end or (options.images > 0 and enough(record.rows[-1], options.images)):
                break
        died = died or graph.dead()
    except KeyboardInterrupt:
        pass
    finally:
        if disturbance:
            disturbance.stop()
        if player:
            player.stopping = True
        graph.stop()
    lines, complaints = judge(record, died)
    if disturbance:
        lines.append("done to them: " + ", ".join("%d %s" % (n, what) for what, n in sorted(disturbance.done.items())) +
                     "; %.1f a second after the first minute, outside of rests" % disturbance.rate)
    text = "\n".join(lines + ["FAILED: " + complaint for complaint in complaints] + ([] if complaints else ["passed"]))
    print(text)
    with open(os.path.join(options.out, "summary.txt"), "w") as out:
        out.write(text + "\n")
    plot(record, os.path.join(options.out, "soak.png"))
    sys.exit(1 if complaints else 0)


if __name__ == "__main__":
    main()
