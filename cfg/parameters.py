"""The table of all parameters. scripts/generate_parameters.py makes from it: the binding of names to the options of the core
and of the node, the checks of values, the options of `evaluate` (`foo_bar` is `--foo-bar`), and with --write
match_filter.yaml and the tables of the documents. MatchFilter.cfg reads it, too."""
from typing import Any, NamedTuple, Optional


class Row(NamedTuple):
    name: str  # of the node's parameter, below its private namespace
    default: Any  # its type is the parameter's type; None: not set
    sentence: str  # shown to users everywhere; states the unit
    range: Optional[tuple] = None  # (least, greatest) of a number
    # The default stands for "not set": it is outside the range, the field is a std::optional, and its reader decides.
    open: bool = False
    # The words, or {word: text in the menu of rqt_reconfigure}. The enumerator of lowe_ratio is kLoweRatio.
    choices: Any = ()
    unit: str = ""  # of a number; of a word without choices: what it must be
    field: Optional[str] = None  # that it sets, as a whole path; None: the one of its name in `at` of its group
    example: Any = None  # where the default is None


class Group(NamedTuple):
    name: str  # not the name of a parameter: rqt_reconfigure would crash
    title: str  # in match_filter.yaml
    live: bool  # dynamic_reconfigure can change them; the others are read at start
    at: str  # struct of the fields, below one of STRUCTS
    parameters: list


# Paths begin with `core`, `start`, `processor` or `outputs`. Names with a slash are read by hand (read_parameters.cpp).
STRUCTS = {"core": "MatchFilterOptions", "start": "Parameters", "processor": "RuntimeOptions", "outputs": "RuntimeOptions"}

GROUPS = [
    Group("inputs", "input", live=False, at="start", parameters=[
        Row("input", "stream", "stream: images of one camera, each compared with an earlier one; pair: reference/image with "
            "current/image; stereo: left/image with right/image; keypoints: features of your own detector "
            "(gms_ransac/Keypoints) in place of images", choices=("stream", "pair", "stereo", "keypoints")),
        Row("image_transport", "raw", "Transport of the images; compressed reads image/compressed. Remap `image` only",
            unit="the name of an image transport"),
        Row("depth_image_transport", "raw", "Transport of depth/image; lossy ones spoil depth",
            unit="the name of an image transport"),
        Row("queue_size", 10, "Messages that each subscriber keeps, and images that wait with drop_frames false. When it is "
            "full the oldest is dropped, counted in ~stats and logged", range=(1, 10000)),
        Row("drop_frames", True, "true: only the newest waiting image is processed (live camera); false: every image (replay), "
            "unless more than queue_size wait"),
        Row("always_subscribe", False, "Subscribe to the images even while no output has a subscriber"),
        Row("threads", 1, "2: the next image is extracted while this one is matched; from 3 on threads also share extraction "
            "and matching. All nodelets of a manager share the helpers. The results do not depend on it", range=(1, 16)),
        Row("mask_file", "", "Image that is zero where no keypoint may be taken; used until a mask arrives on ~mask; empty: none",
            unit="the path of an image"),
        Row("mask_sync", "latest", "latest: the newest ~mask applies to every image; exact: the one of the same stamp, for which "
            "the image waits up to a second", choices=("latest", "exact")),
    ]),
    Group("camera", "camera", live=False, at="start", parameters=[
        Row("camera_info_sync", "latest", "latest: the newest camera_info applies to every image; exact: the one of the same stamp, for at most a second",
            choices=("latest", "exact")),
        Row("input_is_rectified", "auto", "true: the images have no distortion and P is used; false: K and D are used; auto: "
            "decided from D, K and the topic's name, and logged", choices=("auto", "true", "false")),
    ] + [
        Row("camera/" + name, None, "Focal length, pixels; fx, fy, cx, cy together replace camera_info. Log and diagnostics "
            "report where they contradict it", range=(0.001, 1e6), unit="pixels", example=525.0) for name in ("fx", "fy")
    ] + [
        Row("camera/" + name, None, "Principal point, pixels; given together with fx and fy", range=(-1e6, 1e6), unit="pixels",
            example=example) for name, example in (("cx", 319.5), ("cy", 239.5))
    ] + [
        Row("camera/" + name, None, "Distortion coefficient; plumb_bob has k1, k2, p1, p2, k3, equidistant k1 to k4, "
            "omnidirectional xi, k1, k2, p1, p2, double_sphere xi, alpha",
            range=(-1e6, 1e6), example=0.0) for name in ("k1", "k2", "p1", "p2", "k3", "k4", "xi", "alpha")
    ] + [
        Row("camera/distortion_model", None, "Model of those coefficients; not set: plumb_bob",
            choices=("plumb_bob", "equidistant", "omnidirectional", "double_sphere"), example="plumb_bob"),
    ]),
    Group("translation_scale", "scale of the translation", live=False, at="start", parameters=[
        Row("scale", "unit", "Length of the translations. unit: 1, the direction only; propagate: relative, carried from pair to "
            "pair through features seen three times; depth: metres from a registered depth/image; fixed: always fixed_scale; "
            "odometry: metres from prior_odom (nav_msgs/Odometry); ground: metres from camera_height and the ground in view",
            choices=("unit", "propagate", "depth", "fixed", "odometry", "ground")),
        Row("fixed_scale", 1.0, "Length of every translation, metres; used when scale is fixed", range=(1e-6, 1e6), unit="metres"),
        Row("camera_height", 0.0, "Height of the camera above the ground, metres; used when scale is ground. The normal of the "
            "ground is the z axis of base_frame, if that is set", range=(0.0, 1000.0), unit="metres"),
    ]),
    Group("priors", "other motion sensors", live=False, at="start", parameters=[
        Row("rotation_prior", "none", "Source of a prior of the camera's rotation: imu (sensor_msgs/Imu), tf (the camera in "
            "prior_frame) or odom (prior_odom, nav_msgs/Odometry). It proposes, checks and, with search guided, predicts "
            "positions; it never enters the pose",
            choices=("none", "imu", "tf", "odom")),
        Row("imu_frame", "", "Frame of the gyroscope's axes; empty: the frame_id of the messages. tf must know the camera in it",
            unit="a frame"),
        Row("prior_frame", "", "Fixed frame in which tf knows the camera; used when rotation_prior is tf", unit="a frame"),
        Row("image_time_offset", 0.0, "Added to image stamps before another sensor is read, seconds; diagnostics estimate it",
            range=(-1.0, 1.0), unit="seconds"),
    ]),
    Group("frames", "frames and messages", live=False, at="start", parameters=[
        Row("odom_frame", "odom", "Parent frame of ~odom", unit="a frame"),
        Row("base_frame", "", "Child frame of ~odom; empty: the camera's optical frame. tf must know the camera in it",
            unit="a frame"),
        Row("invert_odom_tf", False, "Broadcast base_frame -> odom_frame; for bases that have another parent in tf already"),
        Row("feature_layout", "vins_mono", "Channels of ~features. vins_mono: 5; vins_fusion: 9; lvi_sam: 6, the last is the depth "
            "(with scale depth; else -1)", choices=("vins_mono", "vins_fusion", "lvi_sam")),
        Row("stereo_features_type", "gms_ransac/StereoFeatures", "Type of ~stereo_features; msckf_vio/CameraMeasurement has the "
            "same fields", unit="a message type"),
        Row("diagnostic_period", 1.0, "Seconds between messages on /diagnostics", range=(0.001, 86400.0), unit="seconds"),
        Row("publish_uncertain", False, "Publish the likeliest motion also under MOTION_UNKNOWN, in ~correspondences and "
            "~relative_pose alone, with a translation of length 1. Weigh it by pose_probability"),
    ]),
    Group("matching", "features and matching", live=True, at="core", parameters=[
        Row("features", 2000, "Keypoints per image", range=(1, 100000), field="core.extractor.features"),
        Row("fast_threshold", 20, "Least contrast of a FAST corner, grey levels; simd_orb takes 7 at most, and 4 where corners are few; use 0 "
            "where texture is weak and above 3000 features", range=(0, 255), unit="grey levels", field="core.extractor.fast_threshold"),
        Row("search", "guided", "Where matches are searched. guided needs a fraction of the time with thousands of features; "
            "methods lan, gms and gms5 always search in full",
            choices={"full": "every point is compared with all points of the other image",
                     "guided": "points are compared near where the motion of their neighbourhood predicts them; with all points "
                               "where it predicts nothing"}),
        Row("gms_rotation", False, "Motion statistics try all rotations of the neighbourhood (rolling camera)",
            field="core.motion_statistics.rotation"),
        Row("gms_scale", False, "Motion statistics try five scales of the neighbourhood (zooming camera)",
            field="core.motion_statistics.scale"),
    ]),
    Group("robust_estimation", "robust estimation", live=True, at="core.robust", parameters=[
        Row("method", "lo_prosac", "Method of every stage (rosrun gms_ransac match_filter_node --methods explains them)",
            field="core.method", choices={
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
        Row("model", "essential", "Two-view model; without intrinsics essential becomes fundamental", choices={
            "essential": "calibrated camera",
            "fundamental": "any camera",
            "homography": "planar scene or rotating camera"}),
        Row("inlier_threshold_px", 0.0, "Largest residual of an inlier, pixels; 0: 1 for essential and fundamental, 3 for homography",
            range=(0.001, 100.0), open=True, unit="pixels"),
        Row("success_probability", 0.99, "Sampling stops when a sample without outliers was drawn with this probability",
            range=(0.01, 0.999999999)),
        Row("max_iterations", 2000, "Most samples drawn for one pair", range=(1, 1000000)),
        Row("min_pose_probability", 0.865, "OK needs a pose with this probability", range=(0.0, 1.0)),
        Row("min_rotation_probability", 0.805, "LOW_PARALLAX needs a rotation with this probability",
            range=(0.0, 1.0)),
        Row("calibration_sigma", 0.0, "Relative uncertainty of the focal length, and of the principal point in focal lengths; "
            "widens the covariance", range=(0, 0.2)),
        Row("rolling_shutter_readout", -1.0, "Seconds from the first row of an image to the last. Above 0: a rolling shutter "
            "(webcams: about 0.03), points are corrected for the rotation in that time; 0: a global shutter; -1: learnt "
            "from a stream that rotates", range=(-1, 0.2), unit="seconds"),
    ]),
    Group("time", "time and losses", live=True, at="processor", parameters=[
        Row("max_milliseconds", 0.0, "Time limit of an image (time_total of ~stats), milliseconds, kept by 99 % of them; fewer "
            "features, samples and steps when it is short; 0: no limit", range=(0.0, 10000.0), unit="milliseconds",
            field="core.max_milliseconds"),
        Row("max_frame_gap", 1.0, "Images further apart are not compared, seconds", range=(0.001, 3600.0), unit="seconds"),
        Row("recovery_frames", 0, "Images kept from before a loss (dark, blurred, covered or no images), to continue "
            "from when the camera sees the same scene again; 0: none. Each takes 240 kB at 2000 features",
            range=(0, 100), field="processor.recovery.frames"),
        Row("max_recovery_gap", 10.0, "Age at which a kept image is dropped, seconds", range=(0.001, 3600.0),
            unit="seconds", field="processor.recovery.seconds"),
        Row("hold_reference", True, "Keep comparing with the same image while the parallax is too small for a translation"),
    ]),
    Group("output", "output", live=True, at="outputs", parameters=[
        Row("publish_rejected", False, "Add the rejected matches to ~correspondences and fill its column `stage`"),
        Row("overlay_colour", "residual", "Colour of the arrows in ~match_image; stage shows the rejected matches, too", choices={
            "residual": "distance from the estimated motion, in standard deviations",
            "probability": "probability that the match is right",
            "track": "length of the track, images",
            "depth": "depth of the triangulated point",
            "stage": "inliers, and the matches that the filter or the model rejected"}, field="outputs.overlay.colour"),
        Row("overlay_layout", "flow", "Images in ~match_image: the current one, or reference and current joined by lines", choices={
            "flow": "the current image, with an arrow from the position of each point in the reference",
            "side_by_side": "reference and current image, joined by at most 150 lines"}, field="outputs.overlay.layout"),
        Row("publish_relative_tf", True, "Broadcast the transform <camera frame> -> <camera frame>_reference; the node then "
            "subscribes to images all the time"),
        Row("publish_odom_tf", False, "Broadcast the integrated motion, odom_frame -> base_frame; the node then subscribes to "
            "images all the time"),
        Row("feature_limit", 220, "Most features in ~features and ~stereo_features, longest tracks first; 0: no limit. VINS-Mono holds 1000 over its "
            "window without a check and can crash above 222", range=(0, 100000), field="outputs.features.selection.limit"),
        Row("feature_distance", 15.0, "Least distance between two of these features, pixels; 0: none", range=(0.0, 1000.0),
            unit="pixels", field="outputs.features.selection.distance"),
        Row("feature_rate", 10.0, "Most messages of either a second; tracks span the images between them; 0: one for every "
            "image", range=(0.0, 1000.0), unit="hertz", field="outputs.features.rate"),
        Row("systematic_sigma", 0.003, "Share of each motion that is wrong alike in all pairs, because of calibration and scale: "
            "its deviation grows with the way; 0: none, as of a simulator", range=(0.0, 1.0),
            field="processor.systematic_sigma"),
        Row("rotation_sigma_floor", 0.00004, "Least standard deviation about a rotation axis, radians", range=(0.00004, 3.0),
            unit="radians", field="processor.sigma_floor.rotation"),
        Row("translation_sigma_floor", 0.00004, "Least standard deviation along a translation axis, in lengths of the translation",
            range=(0.00004, 30.0), field="processor.sigma_floor.translation"),
    ]),
    Group("experiments", "for experiments: every method", live=False, at="core", parameters=[
        Row("extractor", "simd_orb", "Feature extractor", field="core.extractor.extractor",
            choices={"opencv": "cv::ORB, used in the paper", "simd_orb": "the ORB of this package"}),
        Row("pyramid_levels", 5, "Levels of the image pyramid (cv::ORB: 8)", range=(1, 16), field="core.extractor.pyramid_levels"),
        Row("pyramid_scale", 1.41, "Scale between pyramid levels (cv::ORB: 1.2)", range=(1.01, 2.0), field="core.extractor.pyramid_scale"),
        Row("one_to_one", True, "Keep the likeliest of the matches that share a current point; false: all, as in the papers"),
        Row("align_points", True, "Align points with the image, to a tenth of a pixel; false: as in the papers"),
        Row("gms_grid_columns", 0, "Cells across the image; 0: the method's own (20; lo_prosac: square cells)",
            range=(2, 100), open=True, field="core.motion_statistics.grid_columns"),
        Row("gms_grid_rows", 0, "Cells down the image; 0: the method's own (20; lo_prosac: square cells)", range=(2, 100),
            open=True, field="core.motion_statistics.grid_rows"),
        Row("gms_threshold_factor", 0.0, "Supporting matches that a match needs, in standard deviations (alpha); 0: the method's "
            "own (6; lo_prosac: 1)", range=(0.01, 100.0), open=True, field="core.motion_statistics.threshold_factor"),
        Row("gms_criterion", "own", "Criterion that accepts a match", open=True, choices={
            "own": "the method's own",
            "threshold": "score above the threshold, as published",
            "evidence": "score, descriptors, rotation and change of octave"},
            field="core.motion_statistics.criterion"),
        Row("gms_border", "opencv", "Published implementation to follow at the image border",
            choices={"opencv": "OpenCV contrib", "original": "Bian et al."}, field="core.motion_statistics.border"),
        Row("seed", 0, "Seed of the random samples: same seed and images, same result", range=(0, 2147483647),
            field="core.robust.seed"),
        Row("judge", True, "Require enough spread inliers, parallax and no alternative model; false: accept the model found, as "
            "in the papers", field="core.robust.judge"),
        Row("max_direction_sigma", 10.0, "Standard deviation of the direction that a pose is judged against, degrees; smaller asks "
            "for better directions", range=(0.01, 90), unit="degrees",
            field="core.robust.max_direction_sigma"),
        Row("refine", True, "Robust least squares on the final model; false: as in the textbook (lo_prosac always refines)",
            field="core.robust.refine"),
    ]),
    Group("comparison", "for experiments: single methods", live=False, at="core.robust", parameters=[
        Row("sort_key", "", "prosac, split2080, cp_ransac: order of the matches; empty: the method's own", open=True,
            choices={
                "": "the method's own",
                "score": "supporting matches in the neighbourhood",
                "relative_score": "score over the threshold of its neighbourhood",
                "distance": "Hamming distance",
                "lowe_ratio": "distance over second-nearest distance"}),
        Row("first_group_fraction", 0.5, "cp_ransac: share of the matches in the first confidence group, the paper's ratio",
            range=(0.01, 1.0)),
        Row("geometric_groups", False, "cp_ransac: widen by first_group_fraction of the rest each time, instead of to all at "
            "once"),
        Row("tdd_d", 1, "rransac_tdd: matches tested before a full verification", range=(1, 100)),
        Row("subset_count", 5, "subset_ransac: random subsets", range=(1, 100)),
        Row("subset_fraction", 0.2, "subset_ransac: share of the matches in each subset", range=(0.01, 1.0)),
        Row("split_fraction", 0.2, "split2080: share of the matches that is sampled; 1: all, and all verify",
            range=(0.01, 1.0)),
        Row("distance_reading", "displacement", "gms_dist_ransac: interpretation of its distance criterion", choices={
            "displacement": "lengths of displacements, locally",
            "pairwise": "ratios of distances between matches"}, field="core.distance_reading"),
        Row("lan_mutual", True, "lan: match in both directions", field="core.lan_mutual"),
        Row("lan_second_threshold_factor", 0.0, "lan: threshold factor of its final check; 0: the first times the root of the "
            "share kept", range=(0.01, 100.0), open=True, field="core.lan_second_threshold_factor"),
        Row("target_inlier_ratio", 0.0, "gms_ransac: stop at this inlier ratio; 0: never", range=(0.01, 1.0), open=True),
    ]),
]
