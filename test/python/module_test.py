#!/usr/bin/env python3
"""`import gms_ransac`, against exact truth and against `evaluate`: module_test.py EVALUATE RENDER_SCENE TWO_IMAGES."""
import ast
import copy
import gc
import json
import pickle
import re
import shutil
import subprocess
import sys
import tempfile
import time
import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import cv2
import numpy as np

import gms_ransac

try:
    from gms_ransac.msg import Correspondences, MatchStats
except ImportError:
    Correspondences = None  # a wheel has no messages

EVALUATE, RENDER_SCENE, TWO_IMAGES = sys.argv[1:4]
SIZE, K = (640, 480), np.array([[500.0, 0, 320], [0, 500, 240], [0, 0, 1]])
CAMERA = gms_ransac.Camera(*SIZE, K=K)


def drawn(R, t, n=400, wrong=100):
    """Pixels of both images; the last are wrong matches."""
    random = np.random.RandomState(1)
    X = random.uniform((-3, -2, 4), (3, 2, 9), (n, 3))
    points = [(Y / Y[:, 2:]) @ K.T for Y in (X, (X - t) @ R)]  # X_reference = R X_current + t
    points[1][-wrong:] = random.uniform((0, 0, 1), SIZE + (1,), (wrong, 3))
    return [p[:, :2] for p in points]


class Module(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        room = Path(cls.folder.name, "room")
        subprocess.run([RENDER_SCENE, room, "-n", "3"], check=True, stdout=subprocess.DEVNULL)
        cls.room, cls.files = room, sorted(map(str, (room / "rgb").iterdir()))
        cls.intrinsics = (room / "camera.txt").read_text().split()[:4]
        fx, fy, cx, cy = map(float, cls.intrinsics)
        cls.grey, cls.colour = ([cv2.imread(name, mode) for name in cls.files] for mode in (0, 1))
        cls.camera = gms_ransac.Camera(*SIZE, K=[[fx, 0, cx], [0, fy, cy], [0, 0, 1]])

    def assert_same(self, one, other):
        for name in ("reference_points", "current_points", "stage", "probability", "current_in_reference", "covariance"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name), name)

    def test_exact_truth(self):
        R, t = cv2.Rodrigues(np.array([0.02, -0.05, 0.03]))[0], np.array([0.6, 0, 0.8])
        points = drawn(R, t)
        for method in ("lo_prosac", "cp_ransac", "prosac"):
            pair = gms_ransac.estimate(*points, CAMERA, method=method)
            self.assertEqual(pair.status, gms_ransac.Status.OK, method)
            T = pair.current_in_reference
            np.testing.assert_allclose(T, np.vstack([np.column_stack([R, t]), [0, 0, 0, 1]]), atol=1e-3, err_msg=method)
            right = pair.stage == pair.STAGE_INLIER
            self.assertTrue(right[:300].all() and right[300:].sum() < 10, method)
            self.assertTrue((np.linalg.eigvalsh(pair.covariance) > -1e-12).all())
            np.testing.assert_array_equal(pair.reference_points, points[0].astype(np.float32))
        homography = gms_ransac.estimate(points[0], points[0] + (30, 0), gms_ransac.Camera(*SIZE), model="homography")
        self.assertEqual(homography.status, gms_ransac.Status.UNCALIBRATED)
        np.testing.assert_allclose(homography.model / homography.model[2, 2], [[1, 0, 30], [0, 1, 0], [0, 0, 1]], atol=1e-3)

    def test_features_of_another_detector(self):
        R, t = cv2.Rodrigues(np.array([0.02, -0.05, 0.03]))[0], np.array([0.6, 0, 0.8])
        points = [p[:-100] for p in drawn(R, t)]  # without the wrong matches
        seen = ((points[1] >= -0.5) & (points[1] <= np.array(SIZE) - 0.5) & (points[0] >= -0.5) &
                (points[0] <= np.array(SIZE) - 0.5)).all(1)
        points, n = [p[seen] for p in points], seen.sum()
        random = np.random.RandomState(2)
        floats = random.normal(size=(n, 256)).astype(np.float32)
        long = random.randint(0, 256, (n, 64)).astype(np.uint8)
        for first, second in ((floats, floats + random.normal(0, 0.3, (n, 256))), (long, long ^ random.randint(0, 2, (n, 64)).astype(np.uint8))):
            # The second image has them in another order.
            order = random.permutation(n)
            features = [gms_ransac.Features(p, d, *SIZE, octave=np.zeros(n), angle=np.full(n, -1), response=np.ones(n))
                        for p, d in ((points[0], first), (points[1][order], second[order]))]
            self.assertEqual(len(features[0]), n)
            pair = gms_ransac.match(*features, CAMERA)
            self.assertEqual(pair.status, gms_ransac.Status.OK, features[0])
            np.testing.assert_allclose(pair.current_in_reference, np.vstack([np.column_stack([R, t]), [0, 0, 0, 1]]), atol=2e-3)
            self.assertGreater((pair.stage == pair.STAGE_INLIER).sum(), 0.9 * n)
            # A row of either column is one point.
            at = {tuple(p): i for i, p in enumerate(points[0].astype(np.float32))}
            partners = np.array([points[1][at[tuple(p)]] for p in pair.reference_points], np.float32)
            np.testing.assert_array_equal(pair.current_points, partners)
            matcher = gms_ransac.MatchFilter(CAMERA)
            self.assertEqual(matcher.process(features[0]).status, gms_ransac.Status.FIRST_FRAME)
            self.assert_same(matcher.process(features[1]), pair)

    def test_features_are_refused_with_what_is_wrong(self):
        points, descriptors = np.full((9, 2), 5.0), np.zeros((9, 61), np.uint8)
        features = gms_ransac.Features(points, descriptors, *SIZE)
        for complaint, make in (
                ("9 keypoints and 8 descriptors", lambda: gms_ransac.Features(points, descriptors[:8], *SIZE)),
                ("keypoint 0 lies outside", lambda: gms_ransac.Features(points + np.nan, descriptors, *SIZE)),
                ("keypoint 0 lies outside", lambda: gms_ransac.Features(points, descriptors, 4, 4)),
                ("keypoints has the shape (9, 3)", lambda: gms_ransac.Features(np.zeros((9, 3)), descriptors, *SIZE)),
                ("uint8 (binary descriptors) or", lambda: gms_ransac.Features(points, descriptors.astype(int), *SIZE)),
                ("uint8 (binary descriptors) or", lambda: gms_ransac.Features(points, None, *SIZE)),
                ("descriptor 0 has a number that is not finite",
                 lambda: gms_ransac.Features(points, np.full((9, 4), np.inf), *SIZE)),
                ("keypoint 0 has octave -1", lambda: gms_ransac.Features(points, descriptors, *SIZE, octave=np.full(9, 1e9))),
                ("octave has 8 numbers", lambda: gms_ransac.Features(points, descriptors, *SIZE, octave=np.zeros(8))),
                ("image0 is 640 x 480", lambda: gms_ransac.match(features, features, gms_ransac.Camera(320, 240))),
                ("mask has no effect", lambda: gms_ransac.MatchFilter().process(features, mask=np.ones((480, 640), bool))),
                ("32 bytes cannot be compared with those of 61 bytes", lambda: gms_ransac.match(features, self.grey[0]))):
            with self.assertRaises(ValueError) as refusal:
                make()
            self.assertIn(complaint, str(refusal.exception))

    def test_same_as_evaluate(self):
        out = str(self.room / "out.jsonl")
        subprocess.run([EVALUATE, "run", self.room, "--method", "lo_prosac", "--out", out], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        records = list(map(json.loads, Path(out).read_text().splitlines()))
        matcher = gms_ransac.MatchFilter(self.camera)
        pairs = [matcher.process(image) for image in self.colour]
        self.assertEqual(len(records), 2)
        self.assert_same(pairs[1], gms_ransac.match(*self.colour[:2], self.camera))
        for pair, record in zip(pairs[1:], records):
            self.assertEqual(pair.status.name, record["status"])
            for name in ("matches_raw", "matches_gms", "hypotheses", "rms_error_px", "sigma_px", "median_parallax_px"):
                self.assertEqual(getattr(pair, name), record[name], name)
            np.testing.assert_array_equal(pair.current_in_reference[:3, :3].ravel(), record["R"])
            np.testing.assert_array_equal(pair.current_in_reference[:3, 3], record["t"])
            np.testing.assert_array_equal(pair.covariance.ravel("F"), record["covariance"])
            columns = (pair.reference_points, pair.current_points, pair.confidence, pair.probability)
            inliers = np.column_stack(columns)[pair.stage == pair.STAGE_INLIER]
            np.testing.assert_array_equal(inliers, np.float32(record["correspondences"]))

    @unittest.skipIf(Correspondences is None, "installed without ROS")
    def test_names_are_those_of_the_messages(self):
        fields = set(Correspondences.__slots__) | set(MatchStats.__slots__)
        names = {name for name in dir(gms_ransac.MatchResult) if name[0].islower()}
        self.assertEqual(names - fields, {"covariance", "model", "matches", "raw", "residual", "reference", "current",
                                          "triangulate"})
        for name, value in gms_ransac.Status.__members__.items():
            self.assertEqual(int(value), getattr(MatchStats, name))

    def test_stubs_are_those_of_the_module(self):
        def named(body):
            return {node.target.id if isinstance(node, ast.AnnAssign) else node.name: node for node in body
                    if isinstance(node, (ast.ClassDef, ast.FunctionDef, ast.AnnAssign))}

        def check_arguments(name, function, node):
            signature = re.search(r"\((.*)\) -> ", function.__doc__)[1]
            self.assertEqual([argument.arg for argument in node.args.args], re.findall(r"(\w+): ", signature), name)
        stub = named(ast.parse((Path(__file__).parents[2] / "src/python/__init__.pyi").read_text()).body)
        self.assertEqual(set(stub), set(gms_ransac.__all__))
        for name, node in stub.items():
            thing = getattr(gms_ransac, name)
            if isinstance(node, ast.FunctionDef):
                check_arguments(name, thing, node)
                continue
            members = named(node.body)
            # pybind11 of Ubuntu 20.04 gives enumerators no `value`.
            self.assertEqual({member for member in members if member[0] != "_"} - {"value"},
                             {member for member in vars(thing) if member[0] != "_"} - {"value"}, name)
            for member in ("__init__", "process"):
                if member in members:
                    check_arguments(name + "." + member, getattr(thing, member), members[member])

    def test_arrays_are_views_that_keep_the_result(self):
        pair = gms_ransac.match(*self.grey[:2], self.camera)
        arrays = {name: getattr(pair, name) for name in ("current_points", "probability", "stage", "covariance", "model")}
        copies = {name: array.copy() for name, array in arrays.items()}
        for name, array in arrays.items():
            self.assertTrue(np.shares_memory(array, getattr(pair, name)), name)
        del pair
        gc.collect()
        gms_ransac.match(*self.grey[1:], self.camera)  # would take the memory
        for name, array in arrays.items():
            np.testing.assert_array_equal(array, copies[name], name)

    def test_images_and_masks(self):
        in_grey = [cv2.cvtColor(image, cv2.COLOR_BGR2GRAY) for image in self.colour]
        self.assert_same(gms_ransac.match(*self.colour[:2], self.camera), gms_ransac.match(*in_grey[:2], self.camera))
        halves = [image[:, ::2] for image in self.grey]  # no row of these is in one piece
        self.assert_same(gms_ransac.match(*halves[:2]), gms_ransac.match(*(half.copy() for half in halves[:2])))
        mask = np.zeros(SIZE[::-1], bool)
        mask[:, 320:] = True
        matcher = gms_ransac.MatchFilter(self.camera)
        self.assertEqual(matcher.process(self.grey[0], mask).status, gms_ransac.Status.FIRST_FRAME)
        pair = matcher.process(self.grey[1], 255 * mask.astype(np.uint8))
        self.assertTrue((pair.current_points[:, 0] > 319).all() and pair.inliers > 100)

    def test_arrays_that_nobody_may_write_and_other_shapes(self):
        def read_only(array):
            array = array.copy()
            array.flags.writeable = False
            return array
        expected = gms_ransac.match(*self.colour[:2], self.camera)
        frozen = [read_only(image) for image in self.colour[:2]]
        self.assert_same(gms_ransac.match(*frozen, self.camera), expected)
        buffers = [np.frombuffer(image.tobytes(), np.uint8).reshape(image.shape) for image in self.colour[:2]]
        self.assert_same(gms_ransac.match(*buffers, self.camera), expected)
        with_alpha = [cv2.cvtColor(image, cv2.COLOR_BGR2BGRA) for image in self.colour[:2]]
        self.assert_same(gms_ransac.match(*with_alpha, self.camera), expected)
        in_grey = [cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)[..., np.newaxis] for image in self.colour[:2]]
        self.assert_same(gms_ransac.match(*in_grey, self.camera), expected)
        everywhere = read_only(np.ones(SIZE[::-1] + (1,), bool))
        self.assertEqual(gms_ransac.MatchFilter().process(self.grey[0], everywhere).keypoints_current,
                         gms_ransac.MatchFilter().process(self.grey[0]).keypoints_current)
        for kind in (np.uint8, np.float32):
            descriptors = np.random.RandomState(1).randint(0, 256, (9, 61)).astype(kind)
            features = gms_ransac.Features(read_only(np.full((9, 2), 5.0)), read_only(descriptors), *SIZE)
            np.testing.assert_array_equal(features.descriptors, descriptors)
        self.assertEqual(features.keypoints[0].tolist(), [5, 5, 0, -1, 0])

    def test_cameras_as_messages_have_them(self):
        for D, model in ((None, ""), ([], "plumb_bob"), (np.zeros(8), "plumb_bob"), ([0.1, 0, 0, 0, 0, 0, 0, 0], "plumb_bob"),
                         ([0.1, 0, 0, 0, 0], "equidistant")):
            gms_ransac.Camera(*SIZE, K=K, D=D, distortion_model=model)

    def test_copies_and_pickles(self):
        lens = gms_ransac.Camera(*SIZE, K=K, D=[-0.1, 0.01, 0, 0, 0], distortion_model="plumb_bob")
        matcher = gms_ransac.MatchFilter(lens)
        first, pair = (matcher.process(image) for image in self.grey[:2])
        floats = gms_ransac.Features(np.full((9, 2), 5.0), np.full((9, 7), 0.5), *SIZE)
        for copied in (copy.copy, copy.deepcopy, lambda thing: pickle.loads(pickle.dumps(thing))):
            self.assert_same(gms_ransac.match(*self.grey[:2], copied(lens)), gms_ransac.match(*self.grey[:2], lens))
            gms_ransac.match(*self.grey[:2], copied(gms_ransac.Camera(*SIZE)))
            again = copied(pair)
            for name in dir(pair):
                if name[0] != "_" and name not in ("reference", "current", "triangulate"):
                    np.testing.assert_array_equal(getattr(again, name), getattr(pair, name), name)
            np.testing.assert_array_equal(again.triangulate().points, pair.triangulate().points)
            np.testing.assert_array_equal(again.current.keypoints, pair.current.keypoints)
            self.assertEqual(copied(first).status, first.status)
            np.testing.assert_array_equal(copied(floats).descriptors, floats.descriptors)
        state = pair.__getstate__()
        with self.assertRaisesRegex(ValueError, "another version"):
            gms_ransac.MatchResult.__new__(gms_ransac.MatchResult).__setstate__(state[:-1])

    def test_rows_are_those_of_the_core(self):
        matcher = gms_ransac.MatchFilter(self.camera, threads=3)
        self.assertEqual(matcher.options["threads"], 3)
        first, pair, third = (matcher.process(image) for image in self.grey[:3])
        self.assert_same(pair, gms_ransac.match(*self.grey[:2], self.camera))
        self.assertEqual((len(first.reference), len(first.current), first.matches_raw), (0, first.keypoints_current, 0))
        n = pair.matches_gms
        for name in ("matches", "confidence", "distance", "stage", "probability", "residual", "track_id", "track_length",
                     "reference_sigma", "current_sigma", "current_points"):
            self.assertEqual(len(getattr(pair, name)), n, name)
        np.testing.assert_array_equal(pair.reference_points, pair.reference.keypoints[pair.matches[:, 0], :2])
        # Keypoints, or aligned within three pixels of them.
        moved = np.abs(pair.current_points - pair.current.keypoints[pair.matches[:, 1], :2]).max(axis=1)
        self.assertLess(moved.max(), 4.5)
        self.assertTrue(0 < np.count_nonzero(moved) < len(moved))
        self.assertEqual(pair.raw.shape, (pair.matches_raw, 2))
        self.assertTrue(set(map(tuple, pair.matches)) < set(map(tuple, pair.raw)))
        # Tracks go on from pair to pair: one id is one keypoint of the image between.
        inlier = pair.stage == pair.STAGE_INLIER
        self.assertTrue((pair.track_length[inlier] >= 2).all() and (pair.track_id[~inlier] == 0).all())
        before = dict(zip(pair.track_id[inlier], pair.matches[inlier, 1]))
        both = [row for row, track in enumerate(third.track_id) if track in before]
        self.assertGreater(len(both), 100)
        for row in both:
            self.assertEqual(third.matches[row, 0], before[third.track_id[row]])
            self.assertGreaterEqual(third.track_length[row], 3)
        # Points of the inliers, before the camera and on its rays.
        points = pair.triangulate()
        self.assertEqual(len(points), pair.inliers)
        np.testing.assert_array_equal(points.row, np.flatnonzero(inlier))
        good = points.valid == 1
        self.assertGreater(good.sum(), 100)
        fx, fy, cx, cy = map(float, self.intrinsics)
        seen = points.points[good]
        np.testing.assert_allclose(seen[:, :2] / seen[:, 2:] * (fx, fy) + (cx, cy), pair.current_points[points.row[good]],
                                   atol=1e-3)
        self.assertLess(len(pair.triangulate(minimum_parallax=1).valid.nonzero()[0]), good.sum())
        self.assertEqual(len(gms_ransac.match(self.grey[0], self.grey[0], self.camera).triangulate()), 0)

    def test_reset_and_prior(self):
        matcher = gms_ransac.MatchFilter(self.camera)
        pairs = [matcher.process(image) for image in self.grey[:2]]
        matcher.reset()
        again = [matcher.process(image) for image in self.grey[:2]]
        self.assertEqual([pair.status.name for pair in pairs + again], 2 * ["FIRST_FRAME", "OK"])
        np.testing.assert_array_equal(again[1].probability, pairs[1].probability)
        self.assertGreater(again[1].track_id.max(), pairs[1].track_id.max())  # no id comes back
        # A prior is a proposal: a right one and a wrong one leave the answer what the matches show.
        R = pairs[1].current_in_reference[:3, :3]
        wrong = cv2.Rodrigues(np.array([0, 0.3, 0]))[0]
        for rotation in (R, wrong):
            prior = gms_ransac.RotationPrior(rotation, 1e-6 * np.eye(3))
            pair = gms_ransac.match(*self.grey[:2], self.camera, prior=prior)
            self.assertEqual(pair.status, gms_ransac.Status.OK)
            np.testing.assert_allclose(pair.current_in_reference[:3, :3], R, atol=2e-3)

    def test_without_the_module_the_remedy_is_named(self):
        package = Path(self.folder.name, "messages_only", "gms_ransac")
        package.mkdir(parents=True)
        shutil.copy(str(Path(__file__).parents[2] / "src/python/__init__.py"), str(package))
        for program in ("import gms_ransac; gms_ransac.MatchFilter()", "from gms_ransac import match"):
            run = subprocess.run([sys.executable, "-c", program], cwd=str(package.parent), env={}, stderr=subprocess.PIPE,
                                 universal_newlines=True)
            self.assertIn("ImportError: gms_ransac has its messages", run.stderr)
            self.assertIn("Install pybind11-dev", run.stderr)

    def test_refusals(self):
        def says(sentence, call, *arguments, **options):
            with self.assertRaisesRegex(ValueError, sentence):
                call(*arguments, **options)
        says("^features is '0'; it must be a whole number between 1 and 100000$", gms_ransac.MatchFilter, features=0)
        says("^seed is '1099511627776'; it must be a whole number", gms_ransac.MatchFilter, seed=2**40)
        says("^search is 'None'; it must be one of 'full' 'guided'$", gms_ransac.match, *self.grey[:2], search=None)
        says("^there is no parameter 'feature'$", gms_ransac.MatchFilter, feature=1)
        zero, one = self.grey[:2]
        says("^image1 is 640 x 479 pixels, the camera 640 x 480; both must be of one size$", gms_ransac.match, zero,
             one[1:], self.camera)
        says("^image0 is None, .*cv2.imread.*check the file's name$", gms_ransac.match, cv2.imread("no such file"), one)
        says("^image is None", gms_ransac.MatchFilter().process, None)
        says(r"^image0 has the shape \(640,\); it must be height x width, or", gms_ransac.match, zero[0], one)
        says(r"^image1 has the shape \(480, 640, 2\)", gms_ransac.match, zero, np.zeros((480, 640, 2), np.uint8))
        says(r"^mask has the shape \(480, 640, 3\)", gms_ransac.MatchFilter().process, zero, np.ones((480, 640, 3), np.uint8))
        says("^threads is '0'; it must be a whole number between 1 and 16", gms_ransac.MatchFilter, threads=0)
        says("^R is no rotation matrix", gms_ransac.RotationPrior, 2 * np.eye(3), np.eye(3))
        says("^covariance must be symmetric, with positive variances", gms_ransac.RotationPrior, np.eye(3), np.zeros((3, 3)))
        says("^R is str; it must be 3 x 3 numbers", gms_ransac.RotationPrior, "R", np.eye(3))
        says(r"^image0 has the shape \(0, 640\)", gms_ransac.match, zero[:0], one)
        for kind in (np.float32, np.float64, np.uint16, np.int32):
            says("^image0 is an array of %s; it must be an array of uint8, 0..255" % kind.__name__, gms_ransac.match,
                 kind(zero), one)
        says("^image1 is str; it must be an array of uint8", gms_ransac.match, zero, "1.png")
        says("^mask is 2 x 2 pixels, the image 640 x 480", gms_ransac.MatchFilter().process, zero, np.ones((2, 2), bool))
        says("^mask is an array of float32; it must be an array of uint8 or bool", gms_ransac.MatchFilter().process, zero,
             np.float32(zero))
        says(r"^points0 has the shape \(9, 3\); it must be N x 2", gms_ransac.estimate, np.zeros((9, 3)), np.zeros((9, 2)))
        says("^points1 is str; it must be N x 2 numbers", gms_ransac.estimate, np.zeros((9, 2)), "points")
        points = drawn(np.eye(3), np.array([0.6, 0, 0.8]))
        says(r"^400 of 400 points of points0 are outside of the camera's image of 640 x 480 pixels, such as \(100",
             gms_ransac.estimate, points[0] + 1e5, points[1] + 1e5, CAMERA)
        says("^K is str; it must be 3 x 3 numbers", gms_ransac.Camera, *SIZE, K="K")
        says("K must be", gms_ransac.Camera, *SIZE, K=K.T)
        says("takes 4 or 5 distortion", gms_ransac.Camera, *SIZE, K=K, D=[1.0])
        says("^points0 has 9 points and points1 has 8; both must have one point for each match$", gms_ransac.estimate,
             np.zeros((9, 2)), np.zeros((8, 2)), CAMERA)
        options = gms_ransac.MatchFilter(features=np.int64(500), judge=False, pyramid_scale=np.float32(1.5)).options
        self.assertEqual([options[name] for name in ("features", "judge", "pyramid_scale")], [500, False, 1.5])

    def test_a_result_says_what_it_is(self):
        pair = gms_ransac.match(*self.grey[:2], self.camera)
        self.assertEqual(repr(pair), "<MatchResult OK: %d inliers of %d matches>" % (pair.inliers, pair.matches_raw))
        self.assertEqual(pair.status_text, "%d of %d filtered matches agree on one motion" % (pair.inliers, pair.matches_gms))
        self.assertIn("give a camera", gms_ransac.match(*self.grey[:2]).status_text)
        self.assertIn("rotation only", gms_ransac.match(self.grey[0], self.grey[0], self.camera).status_text)
        self.assertIn("only 0 keypoints (the reference has 0)", gms_ransac.match(*2 * [0 * self.grey[0]]).status_text)
        self.assertIn("first image", gms_ransac.MatchFilter().process(self.grey[0]).status_text)
        self.assertIn("only 3 matches", gms_ransac.estimate(np.ones((3, 2)), np.ones((3, 2))).status_text)

    def test_estimates_within_a_time_and_without_a_camera(self):
        points = drawn(cv2.Rodrigues(np.array([0.02, -0.05, 0.03]))[0], np.array([0.6, 0, 0.8]), wrong=200)
        free, timed = (gms_ransac.estimate(*points, CAMERA, method="ransac", max_milliseconds=ms) for ms in (0, 10000))
        self.assertEqual(free.hypotheses, timed.hypotheses)
        self.assert_same(free, timed)
        pair = gms_ransac.estimate(*points)
        self.assertEqual(pair.status, gms_ransac.Status.UNCALIBRATED)
        lines = np.column_stack([pair.reference_points[:200], np.ones(200)]) @ pair.model.T
        distance = np.abs((np.column_stack([pair.current_points[:200], np.ones(200)]) * lines).sum(1))
        self.assertLess(np.median(distance / np.hypot(lines[:, 0], lines[:, 1])), 0.1)

    def test_threads_run_side_by_side(self):
        matcher, ticks = gms_ransac.MatchFilter(self.camera, features=20000), []

        def work(image):
            start = time.perf_counter()
            return matcher.process(image), start, time.perf_counter()
        with ThreadPoolExecutor(2) as pool:
            works = [pool.submit(work, image) for image in 4 * self.grey]
            while not all(one.done() for one in works):
                ticks.append(time.perf_counter())
        pairs, begins, ends = zip(*(one.result() for one in works))
        self.assertTrue(any((3 * a + b) / 4 < tick < (a + 3 * b) / 4 for a, b in zip(begins, ends) for tick in ticks))
        self.assertEqual(sum(pair.status == gms_ransac.Status.FIRST_FRAME for pair in pairs), 1)

    def test_example_draws_a_picture(self):
        run = subprocess.run([sys.executable, TWO_IMAGES, *self.files[:2], *self.intrinsics], cwd=self.folder.name,
                             check=True, stdout=subprocess.PIPE, universal_newlines=True)
        self.assertIn("Status.OK", run.stdout)
        picture = cv2.imread(str(Path(self.folder.name, "two_images.png"))).astype(int)
        self.assertGreater((picture[..., 1] - picture[..., 0] > 150).sum(), 1000)

    def test_example_names_the_image_that_is_missing(self):
        run = subprocess.run([sys.executable, TWO_IMAGES, self.files[0], "none.png", *self.intrinsics], cwd=self.folder.name,
                             stderr=subprocess.PIPE, universal_newlines=True)
        self.assertEqual((run.returncode, run.stderr.splitlines()[-1]), (1, "cannot read the image none.png"))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
