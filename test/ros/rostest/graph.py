"""What the rostests share: filters to start, a drawn scene with known motion, and a client that sends an image and awaits its
answer."""
import math
import os
import signal
import subprocess
import threading
import time

import cv2
import numpy as np
import rosbag
import roslib.packages
import rospkg
import rospy
import rostest
from gms_ransac.msg import Correspondences, MatchStats
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import CameraInfo, Image
from tf2_msgs.msg import TFMessage

# How many times slower everything may be: scripts/test says it of sanitized builds.
PATIENCE = float(os.environ.get("GMS_RANSAC_PATIENCE", 1))
TIMEOUT = 30.0 * PATIENCE  # seconds of wall time a condition is awaited before the test fails

# Long repetitions are shorter in a run of the whole suite.
FULL = os.environ.get("GMS_RANSAC_FULL") == "1"

WIDTH, HEIGHT = 640, 480
K = np.array([[500.0, 0, 319.5], [0, 500.0, 239.5], [0, 0, 1]])
STEP = np.array((0.15, 0.05, 0.0))  # metres between the images of a walk, in camera axes


def wait_for(condition, what, pause=time.sleep):
    """Returns the first true value of `condition()`; fails after TIMEOUT."""
    end = time.monotonic() + TIMEOUT
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        pause(0.05)  # not everything comes with a message, so look again now and then
    raise AssertionError("waited %g s in vain for %s" % (TIMEOUT, what))


def linger(path):
    """A message a second after the last image: the player ends with the last one, and may not have sent it all."""
    with rosbag.Bag(path, "a") as bag:
        bag.write("/tf", TFMessage(), rospy.Time.from_sec(bag.get_end_time() + 1))
    return path


def data_folder(name):
    """The folder of a real sequence, or None: most machines have none."""
    source = os.path.realpath(rospkg.RosPack().get_path("gms_ransac"))
    for root in (os.environ.get("GMS_RANSAC_DATA"), os.path.join(source, "..", "shared", "data")):
        if root and os.path.isdir(os.path.join(root, name)):
            return os.path.join(root, name)
    return None


def texture(size, seed):
    """Grey noise at three scales: corners everywhere."""
    random = np.random.RandomState(seed)
    picture = np.zeros((size, size), np.float32)
    for cell, weight in ((5, 0.3), (14, 0.4), (45, 0.3)):
        noise = random.randint(0, 256, (size // cell + 1, size // cell + 1)).astype(np.float32)
        picture += weight * cv2.resize(noise, (size, size), interpolation=cv2.INTER_NEAREST)
    return picture.astype(np.uint8)


class Scene:
    """Boards at twelve depths before a wall at 7 m, seen by a camera at `t` turned by the rotation vector `r`."""

    PIXELS = 200

    def __init__(self):
        self.boards = [(7.0, -10.0, -10.0, 20.0)]  # depth, left, top, side in metres; painted in this order
        for i in range(12):
            depth = 5.5 - 0.3 * i
            column, row = (5 * i) % 12 % 4, (5 * i) % 12 // 4
            self.boards.append((depth, depth * (-0.62 + 0.32 * column), depth * (-0.46 + 0.31 * row), 0.28 * depth))
        self.textures = [texture(self.PIXELS * (8 if i == 0 else 1), i) for i in range(len(self.boards))]

    def draw(self, t=(0, 0, 0), r=(0, 0, 0)):
        R = cv2.Rodrigues(np.array(r, float))[0]
        picture = np.zeros((HEIGHT, WIDTH), np.uint8)
        for (z, left, top, side), board in zip(self.boards, self.textures):
            scale = side / board.shape[0]
            # Board pixel (u, v, 1) -> point (left + scale u, top + scale v, z) -> camera -> image.
            to_world = np.array([[scale, 0, left], [0, scale, top], [0, 0, z]])
            to_camera = R.T @ (to_world - np.outer(np.array(t, float), (0, 0, 1)))
            H = K @ to_camera
            seen = cv2.warpPerspective(board, H, (WIDTH, HEIGHT), flags=cv2.INTER_LINEAR)
            mask = cv2.warpPerspective(np.full_like(board, 255), H, (WIDTH, HEIGHT), flags=cv2.INTER_NEAREST)
            picture[mask > 0] = seen[mask > 0]
        return picture

    def depth(self, t):
        """Exact depth along the optical axis, metres, as seen without rotation: the board painted last wins."""
        depth = np.zeros((HEIGHT, WIDTH), np.float32)
        v, u = np.mgrid[0:HEIGHT, 0:WIDTH]
        for z, left, top, side in self.boards:
            x, y = (u - K[0, 2]) / K[0, 0] * z + t[0], (v - K[1, 2]) / K[1, 1] * z + t[1]
            depth[(x >= left) & (x < left + side) & (y >= top) & (y < top + side)] = z
        return depth


def walk(count):
    """The first images of a camera that moves by STEP from one to the next."""
    scene = Scene()
    return [scene.draw(t=STEP * i) for i in range(count)]


def image_message(pixels, stamp, frame="camera", encoding="mono8"):
    message = Image()
    message.header.stamp = rospy.Time.from_sec(stamp)
    message.header.frame_id = frame
    message.height, message.width = pixels.shape[:2]
    message.encoding = encoding
    message.step = int(pixels.nbytes // max(pixels.shape[0], 1))
    message.data = pixels.tobytes()
    return message


def camera_info(stamp, frame="camera", k=None, d=(0.0,) * 5, p=None, size=(WIDTH, HEIGHT)):
    message = CameraInfo()
    message.header.stamp = rospy.Time.from_sec(stamp)
    message.header.frame_id = frame
    message.width, message.height = size
    message.distortion_model = "plumb_bob"
    message.D = list(d)
    matrix = K if k is None else k
    message.K = list(np.array(matrix, float).ravel())
    message.R = list(np.eye(3).ravel())
    projection = np.hstack([matrix if p is None else p, np.zeros((3, 1))])
    message.P = list(projection.ravel())
    return message


class Client:
    """Publishes to a match filter and collects what it answers."""

    def __init__(self, name="match_filter", image="image", info="camera_info", listen=True, camera=True):
        self.changed = threading.Condition()
        self.stats, self.correspondences = [], []
        self.last, self.copies = None, 0
        self.image = rospy.Publisher(image, Image, queue_size=200)
        self.info = rospy.Publisher(info, CameraInfo, queue_size=200) if camera else None
        self.subscribers = []
        self.name = name
        if listen:
            self.listen()

    def listen(self):
        self.subscribe("stats", MatchStats, self.stats)
        self.subscribe("correspondences", Correspondences, self.correspondences)

    def subscribe(self, topic, kind, into):
        """Collects the messages of an output in the list `into`."""

        def store(message):
            with self.changed:
                into.append(message)
                self.changed.notify_all()

        self.subscribers.append(rospy.Subscriber("%s/%s" % (self.name, topic), kind, store, queue_size=500))

    def wait(self, condition, what):
        """As wait_for, and looks at once when a message has come."""
        with self.changed:
            return wait_for(condition, what, self.changed.wait)

    def connect(self):
        """Waits until the filter listens to us and we to it."""
        publishers = [self.image] + ([self.info] if self.info else [])
        self.wait(lambda: all(p.get_num_connections() for p in publishers), "the filter to subscribe")
        self.wait(lambda: all(s.get_num_connections() for s in self.subscribers), "the filter to advertise")
        return self

    def send(self, pixels, stamp, encoding="mono8", frame="camera", info=None):
        """Sends one image, with camera_info first where there is one. An image that is the one before gets the noise of a
        sensor: a copy would be refused. The noise follows from how often the image was sent in a row, so that every run sends
        the same pixels."""
        if self.info:
            self.info.publish(info or camera_info(stamp, frame))
        again = self.last is not None and np.array_equal(self.last, pixels) and pixels.dtype == np.uint8
        self.last, self.copies = pixels, self.copies + 1 if again else 0
        if again:
            noise = np.random.RandomState(self.copies).randint(0, 2, pixels.shape).astype(np.uint8)
            pixels = np.where(pixels < 255, pixels + noise, pixels)
        self.image.publish(image_message(pixels, stamp, frame, encoding))

    def answer(self, count, what="an answer"):
        """The stats message number `count` (from 1)."""
        self.wait(lambda: len(self.stats) >= count, "%s (number %d)" % (what, count))
        return self.stats[count - 1]

    def ask(self, *args, **kwargs):
        """Sends one image and returns the stats that answer it."""
        count = len(self.stats) + 1
        self.send(*args, **kwargs)
        return self.answer(count)

    def correspondence(self, stamp):
        """The correspondences of the image with that stamp."""
        same = lambda: [m for m in self.correspondences if abs(m.header.stamp.to_sec() - stamp) < 1e-6]
        return self.wait(same, "correspondences of %.3f" % stamp)[0]


def client_of(name, **options):
    """A client of a filter that reads its topics below its name."""
    return Client(name, name + "/image", name + "/camera_info", **options)


def said_by(name="", level=Log.DEBUG):
    """A list that collects what a node, or every node, logs from now on at this level and above."""
    lines = []
    subscriber = rospy.Subscriber(
        "/rosout", Log, lambda m: lines.append(m.msg) if m.name.endswith(name) and m.level >= level else None)
    wait_for(subscriber.get_num_connections, "/rosout")
    return lines


def run(name, case, **filters):
    """Runs the tests of a class while match filters run that answer every image: their names and their parameters. Each reads
    its topics below its name."""
    rospy.init_node(name + "_test")
    program = roslib.packages.find_node("gms_ransac", "match_filter_node")[0]
    topics = [side + topic for side in ("", "left/", "right/") for topic in ("image", "camera_info")]
    topics += ["depth/image", "reference/image", "current/image", "imu", "prior_odom"]
    started = []
    for node, parameters in filters.items():
        rospy.set_param(node, dict({"drop_frames": False}, **parameters))
        remaps = ["%s:=%s/%s" % (t, node, t) for t in topics] + ["keypoints:=%s/detector/keypoints" % node]
        started.append(subprocess.Popen([program, "__name:=" + node] + remaps))
    try:
        rostest.rosrun("gms_ransac", name, case)
    finally:
        for process in started:
            process.send_signal(signal.SIGINT)
        for process in started:
            process.wait(TIMEOUT)


class Stream(threading.Thread):
    """Sends the frames over and over with rising stamps, until it is stopped; pauses while `ahead` have no answer."""

    PERIOD = 0.02  # seconds; a camera of 50 Hz

    def __init__(self, client, frames, ahead=math.inf):
        super().__init__(daemon=True)
        self.client, self.frames, self.ahead = client, frames, ahead
        self.stopping, self.sent = threading.Event(), 0

    def run(self):
        before = len(self.client.stats)
        while not self.stopping.wait(self.PERIOD):
            if before + self.sent - len(self.client.stats) >= self.ahead:
                continue
            self.client.send(self.frames[self.sent % len(self.frames)], 100 + self.PERIOD * self.sent)
            self.sent += 1

    def stop(self):
        self.stopping.set()
        self.join()


def rotation_matrix(q):
    x, y, z, w = q.x, q.y, q.z, q.w
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def vector(v):
    return np.array([v.x, v.y, v.z])


def degrees_between(a, b):
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b)), np.dot(a, b)))


def rotation_degrees(R):
    return np.degrees(np.linalg.norm(cv2.Rodrigues(R)[0]))
