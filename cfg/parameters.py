"""Every parameter: the one table from which scripts/generate_parameters.py makes what speaks of them. While building: the
binding of names to the options of the core and of the node, the checks of values, the options of `evaluate` (`foo_bar` is
`--foo-bar`); MatchFilter.cfg reads it, too. With --write: match_filter.yaml and README's tables."""
from typing import Any, NamedTuple, Optional


class Row(NamedTuple):
    name: str  # of the node's parameter, below its private namespace
    default: Any  # says of which type the parameter is; None: not set
    sentence: str  # what a user reads everywhere; says the unit
    range: Optional[tuple] = None  # (least, greatest) of a number
    # The default stands for "not set": it is outside the range, the field is a std::optional, and its reader decides.
    open: bool = False
    # The words, or {word: what the menu of rqt_reconfigure says}. Those of an enumeration are its enumerators: lowe_ratio
    # is kLoweRatio.
    choices: Any = ()
    unit: str = ""  # of a number; of a word without choices what it must be
    field: Optional[str] = None  # of MatchFilterOptions; in a group that is not live of Parameters (src/ros/parameters.h)
    enum: Optional[str] = None  # type of that field where it is an enumeration
    old_names: tuple = ()  # still taken, with a warning; as are
    old_options: tuple = ()  # ... these by `evaluate`, and
    old_words: dict = {}  # ... {old choice: new choice}
    example: Any = None  # where the default is None


class Group(NamedTuple):
    name: str  # of a live one that of no parameter: rqt_reconfigure would take one for the other, and crash
    title: str  # in match_filter.yaml
    live: bool  # dynamic_reconfigure can change them; else they are read at start
    parameters: list


GROUPS = [
    Group("input", "input", False, [
        Row("input", "stream", "Images of one camera one after another, reference/image with current/image, or left/image with "
            "right/image", choices=("stream", "pair", "stereo"), field="input", enum="InputKind"),
        Row("image_transport", "raw", "How the images travel: compressed reads image/compressed; remap `image` alone",
            unit="the name of an image transport", field="image_transport"),
        Row("depth_image_transport", "raw", "The same for depth/image; lossy ones spoil depth",
            unit="the name of an image transport", field="depth_image_transport"),
        Row("queue_size", 10, "Messages kept by each subscriber, and images that wait with drop_frames false; beyond it the "
            "oldest is dropped, counted in ~stats and warned about", range=(1, 10000), field="queue_size"),
        Row("drop_frames", True, "true: only the newest waiting image is processed (live); false: every image (replay), unless "
            "more than queue_size wait", field="drop_frames"),
        Row("always_subscribe", False, "Take images even while nobody listens to any output", field="always_subscribe"),
        Row("threads", 1, "2: the next image is extracted while this one is matched; 3: two share the extraction; 4: and two "
            "the matching; and so on. Helpers are shared by all nodelets of a manager. The results are the same", range=(1, 16), field="threads"),
        Row("mask_file", "", "Image whose zeros say where no keypoint is taken, until one comes on ~mask; empty: none",
            unit="the path of an image", field="mask_file"),
        Row("mask_sync", "latest", "Which ~mask goes with an image: the newest, or the one of the same stamp, for which it waits "
            "(a second at most)", choices=("latest", "exact"), field="mask_sync", enum="MaskSync"),
    ]),
    Group("camera", "camera", False, [
        Row("camera_info_sync", "latest", "Which camera_info goes with an image: the newest, or that of the same stamp",
            choices=("latest", "exact"), field="camera_info_sync", enum="CameraInfoSync"),
        Row("input_is_rectified", "auto", "true: P is used; false: K and D; auto: decided from D, K and the topic's name, and "
            "logged", choices=("auto", "true", "false"), field="input_is_rectified", enum="Rectified"),
    ] + [
        Row("camera/" + name, None, "Focal length, pixels; fx, fy, cx, cy together replace camera_info. Log and diagnostics say "
            "when they describe another camera", range=(0.001, 1e6), unit="pixels", example=525.0) for name in ("fx", "fy")
    ] + [
        Row("camera/" + name, None, "Principal point, pixels, with fx and fy", range=(-1e6, 1e6), unit="pixels",
            example=example) for name, example in (("cx", 319.5), ("cy", 239.5))
    ] + [
        Row("camera/" + name, None, "Distortion that goes with them; plumb_bob has k1, k2, p1, p2, k3, equidistant k1 to k4",
            range=(-1e6, 1e6), example=0.0) for name in ("k1", "k2", "p1", "p2", "k3", "k4")
    ] + [
        Row("camera/distortion_model", None, "Of those coefficients; not set: plumb_bob",
            choices=("plumb_bob", "equidistant"), example="plumb_bob"),
    ]),
    Group("scale", "scale of the translation", False, [
        Row("scale", "unit", "Length of the translations: 1, direction only; carried from pair to pair through features seen "
            "three times; metres from a registered depth/image; fixed_scale metres; metres from prior_odom (nav_msgs/Odometry); metres "
            "from the ground that camera_height is above", choices=("unit", "propagate", "depth", "fixed", "odometry", "ground"),
            field="scale", enum="ScaleMode"),
        Row("fixed_scale", 1.0, "Length of every translation with scale fixed, metres", range=(1e-6, 1e6), unit="metres",
            field="fixed_scale"),
        Row("camera_height", 0.0, "Of the camera above the ground with scale ground, metres; with base_frame the ground's normal "
            "is its z axis", range=(0.0, 1000.0), unit="metres", field="camera_height"),
    ]),
    Group("priors", "what other sensors say of the motion", False, [
        Row("rotation_prior", "none", "Who says how the camera turned: imu (sensor_msgs/Imu), tf (the camera in prior_frame) or "
            "odom (prior_odom, nav_msgs/Odometry). A proposal, a check and, with search guided, where points are looked for; "
            "it never enters the pose",
            choices=("none", "imu", "tf", "odom"), field="rotation_prior", enum="RotationPriorKind"),
        Row("imu_frame", "", "Frame of the gyro's axes; empty: that of the messages. Its place on the camera must be in tf",
            unit="a frame", field="imu_frame"),
        Row("prior_frame", "", "Fixed frame in which tf knows the camera, with rotation_prior tf", unit="a frame",
            field="prior_frame"),
        Row("image_time_offset", 0.0, "Seconds added to the images' stamps when another sensor is asked; diagnostics estimate it",
            range=(-1.0, 1.0), unit="seconds", field="image_time_offset"),
    ]),
    Group("frames", "frames and messages", False, [
        Row("odom_frame", "odom", "Parent frame of ~odom", unit="a frame", field="odom_frame"),
        Row("base_frame", "", "Frame that ~odom moves; empty: the camera's optical frame. Its place must be in tf otherwise",
            unit="a frame", field="base_frame"),
        Row("invert_odom_tf", False, "Broadcast base -> odom, where another node owns the parent of the base frame",
            field="invert_odom_tf"),
        Row("feature_layout", "vins_mono", "Channels of ~features: five, nine, or six, the last of which is the depth (with scale depth; else -1)",
            choices=("vins_mono", "vins_fusion", "lvi_sam"), field="feature_layout", enum="FeatureLayout"),
        Row("diagnostic_period", 1.0, "Seconds between messages on /diagnostics", range=(0.001, 86400.0), unit="seconds",
            field="diagnostic_period"),
    ]),
    Group("extraction", "features", True, [
        Row("extractor", "simd_orb", "Feature extractor", field="extractor.extractor", old_words={"fast": "simd_orb"},
            choices={"opencv": "cv::ORB, what the paper used", "simd_orb": "the ORB of this package"}),
        Row("features", 2000, "Keypoints asked for per image", range=(1, 100000), field="extractor.features"),
        Row("pyramid_levels", 8, "Levels of the image pyramid", range=(1, 16), field="extractor.pyramid_levels",
            old_options=("levels",)),
        Row("pyramid_scale", 1.2, "Scale between pyramid levels", range=(1.01, 2.0), field="extractor.pyramid_scale",
            old_options=("scale-factor",)),
        Row("fast_threshold", 20, "FAST contrast, grey levels; lower where texture is weak, 0 is usual above 3000 features",
            range=(0, 255), unit="grey levels", field="extractor.fast_threshold"),
    ]),
    Group("matching", "matching", True, [
        Row("search", "full", "guided: most points are looked for only where their surroundings moved, which takes a fraction "
            "of the time with thousands of features", choices={
                "full": "every point is compared with all of the other image",
                "guided": "with those near where its surroundings moved; with all where that is not known"},
            field="search", enum="SearchMode"),
    ]),
    Group("motion_statistics", "motion statistics", True, [
        Row("gms_grid_columns", 0, "Cells across the image; 0: as the method has it (20; lo_prosac: square cells)",
            range=(2, 100), open=True, field="motion_statistics.grid_columns"),
        Row("gms_grid_rows", 0, "Cells down the image; 0: as the method has it (20; lo_prosac: square cells)", range=(2, 100),
            open=True, field="motion_statistics.grid_rows"),
        Row("gms_threshold_factor", 0.0, "Matches in support of it that a match needs, in standard deviations (alpha); 0: as "
            "the method has it (6; lo_prosac: 1)", range=(0.01, 100.0), open=True, field="motion_statistics.threshold_factor",
            old_options=("alpha",)),
        Row("gms_criterion", "own", "What makes a match accepted", open=True, choices={
            "own": "as the method has it",
            "threshold": "score above the threshold, as published",
            "evidence": "that, and descriptors, turn and change of octave"},
            field="motion_statistics.criterion", enum="Criterion", old_names=("gms_acceptance",), old_options=("acceptance",)),
        Row("gms_rotation", False, "Search all rotations of the neighbourhood (rolling camera)",
            field="motion_statistics.rotation", old_options=("rotation",)),
        Row("gms_scale", False, "Search five scales of the neighbourhood (zooming camera)", field="motion_statistics.scale",
            old_options=("scale",)),
        Row("gms_border", "opencv", "Which published implementation to follow at the image border",
            choices={"opencv": "OpenCV contrib", "original": "Bian et al."}, field="motion_statistics.border",
            enum="GridBorder"),
    ]),
    Group("robust_estimation", "robust estimation", True, [
        Row("method", "lo_prosac", "Named choice for every stage (rosrun gms_ransac evaluate --list explains them)",
            field="method", old_words={"fast": "lo_prosac"}, choices={
                "lo_prosac": "the most accurate and the fastest: the default",
                "ransac": "uniform samples from all nearest neighbours",
                "rransac_tdd": "Matas and Chum: few matches tested first",
                "prosac": "Chum and Matas: best matches by distance first",
                "subset_ransac": "Xu 2012: RANSAC inside random subsets",
                "split2080": "Ci 2022: samples from the best fifth",
                "gms": "GMS alone",
                "gms5": "Chen 2018: GMS with five cells",
                "gms_dist_ransac": "Zhu 2019: GMS, then matches that move as far as others",
                "lan": "Lan 2020: mutual neighbours, GMS twice",
                "gms_ransac": "GMS, then uniform samples from its survivors",
                "cp_ransac": "the paper: confident matches sampled first"}),
        Row("model", "essential", "Model; without intrinsics essential falls back to fundamental", choices={
            "essential": "calibrated camera",
            "fundamental": "any camera",
            "homography": "planar scene or rotating camera"}, field="robust.model", enum="ModelType"),
        Row("inlier_threshold_px", 0.0, "Residual below which a match is an inlier, pixels; 0: 1 for essential and fundamental, "
            "3 for homography", range=(0.001, 100.0), open=True, unit="pixels", field="robust.inlier_threshold_px",
            old_names=("threshold_px",), old_options=("threshold",)),
        Row("success_probability", 0.99, "Probability of having drawn a sample without outliers", range=(0.01, 0.999999999),
            field="robust.success_probability", old_names=("confidence",)),
        Row("max_iterations", 2000, "Most samples drawn for one pair", range=(1, 1000000), field="robust.max_iterations"),
        Row("seed", 0, "Seed of the random samples: same seed and images, same result", range=(0, 2147483647),
            field="robust.seed"),
        Row("first_group_fraction", 0.5, "cp_ransac: share of the matches in the first confidence group, the paper's ratio",
            range=(0.01, 1.0), field="robust.first_group_fraction", old_names=("ratio",)),
        Row("geometric_groups", False, "cp_ransac: widen by first_group_fraction of the rest each time, instead of to all at "
            "once", field="robust.geometric_groups"),
        Row("tdd_d", 1, "rransac_tdd: matches tested before a full verification", range=(1, 100), field="robust.tdd_d"),
        Row("subset_count", 5, "subset_ransac: random subsets", range=(1, 100), field="robust.subset_count"),
        Row("subset_fraction", 0.2, "subset_ransac: share of the matches in each", range=(0.01, 1.0),
            field="robust.subset_fraction"),
        Row("split_fraction", 0.2, "split2080: share of the matches that is sampled; 1: all, and all verify",
            range=(0.01, 1.0), field="robust.split_fraction", old_names=("split",)),
        Row("distance_reading", "displacement", "gms_dist_ransac: how its distance criterion is read", choices={
            "displacement": "lengths of displacements, locally",
            "pairwise": "ratios of distances between matches"}, field="distance_reading", enum="DistanceReading"),
        Row("one_to_one", True, "Keep one match of each current point, the likeliest; false: all, as in the papers",
            field="one_to_one"),
        Row("lan_mutual", True, "lan: match in both directions", field="lan_mutual"),
        Row("lan_second_threshold_factor", 0.0, "lan: threshold factor of its final check; 0: the first times the root of the "
            "share kept", range=(0.01, 100.0), open=True, field="lan_second_threshold_factor",
            old_names=("lan_second_alpha",), old_options=("second-alpha",)),
        Row("target_inlier_ratio", 0.0, "gms_ransac: stop at this inlier ratio; 0: never", range=(0.01, 1.0), open=True,
            field="robust.target_inlier_ratio", old_names=("target_ratio",)),
        Row("sort_key", "", "prosac, split2080, cp_ransac: what orders the matches; empty: as the method has it", open=True,
            choices={
                "": "as the method has it",
                "score": "matches in support of it in the neighbourhood",
                "relative_score": "score over the threshold of its neighbourhood",
                "distance": "Hamming distance",
                "lowe_ratio": "distance over second-nearest distance"},
            field="robust.sort_key", enum="SortKey", old_names=("quality",),
            old_words={"support": "relative_score", "ratio": "lowe_ratio"}),
        Row("judge", True, "Judge the result: enough spread inliers, parallax, no other motion as likely; false: the model found "
            "stands, as in the papers", field="robust.judge"),
        Row("max_direction_sigma", 10.0, "OK needs the direction of translation known with at most this standard deviation along "
            "its widest axis, degrees", range=(0.01, 90), unit="degrees", field="robust.max_direction_sigma"),
        Row("calibration_sigma", 0.0, "Relative uncertainty of the focal length, and of the principal point in focal lengths: "
            "widens the covariance", range=(0, 0.2), field="robust.calibration_sigma"),
        Row("rolling_shutter_readout", 0.0, "Seconds from the first row of an image to the last, which are read one after "
            "another (0.03 or so for a webcam): points are moved by the turn meanwhile; 0: all at once",
            range=(0, 0.2), unit="seconds", field="robust.rolling_shutter_readout"),
        Row("refine", True, "Robust least squares on the final model; false: as in the textbook (lo_prosac always does)",
            field="robust.refine"),
    ]),
    Group("time", "time", True, [
        Row("max_milliseconds", 0.0, "Most an image may take (time_total of ~stats), milliseconds, kept by 99 % of them: fewer "
            "features, samples and steps where it is short; 0: no limit", range=(0.0, 10000.0), unit="milliseconds",
            field="max_milliseconds"),
        Row("max_frame_gap", 1.0, "Seconds between two images above which they are not compared", range=(0.001, 3600.0),
            unit="seconds"),
        Row("recovery_frames", 0, "Images kept from before a loss (dark, blurred, covered, no image), from which the stream goes "
            "on when it sees the same again; 0: a loss is final. Each takes 240 kB at 2000 features", range=(0, 100)),
        Row("max_recovery_gap", 10.0, "Seconds after which a kept image is of no use any more", range=(0.001, 3600.0),
            unit="seconds"),
        Row("hold_reference", True, "Keep comparing with the same image while the parallax is too small for a translation"),
    ]),
    Group("output", "output", True, [
        Row("publish_rejected", False, "Add the rejected matches to ~correspondences and fill its column `stage`"),
        Row("publish_relative_tf", True, "Broadcast <camera frame> -> <camera frame>_reference; counts as a listener"),
        Row("publish_odom_tf", False, "Broadcast the integrated motion: odom_frame -> base_frame; counts as a listener"),
        Row("feature_limit", 220, "Most features in ~features, longest tracks first; 0: all. Above 222 VINS-Mono, which holds "
            "1000 over its window and does not check, can crash", range=(0, 100000)),
        Row("feature_distance", 15.0, "Least distance between two features in ~features, pixels; 0: any", range=(0.0, 1000.0),
            unit="pixels"),
        Row("feature_rate", 10.0, "Messages of ~features a second at most; tracks span the images between them; 0: one for every "
            "image", range=(0.0, 1000.0), unit="hertz"),
        Row("rotation_sigma_floor", 0.0005, "Least standard deviation of a rotation axis, radians", range=(0.00004, 3.0),
            unit="radians"),
        Row("translation_sigma_floor", 0.005, "Least standard deviation of a translation axis, in units of the translation",
            range=(0.00004, 30.0)),
    ]),
]
