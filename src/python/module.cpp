// gms_ransac._gms_ransac: the pipeline for Python. Knows no ROS. Fields have the names of the messages in msg/, options
// those of the parameters in cfg/parameters.py.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <Eigen/LU>
#include <opencv2/imgproc.hpp>

#include "gms_ransac/match_filter.h"
#include "gms_ransac/status_text.h"
#include "gms_ransac/triangulation.h"
#include "match_filter_hooks.h"
#include "parameters/parameter.h"
#include "survivors.h"
#include "two_view/sigma_by_octave.h"
#include "two_view/translation_variance.h"

namespace gms_ransac {

namespace {

namespace py = pybind11;

struct MatchIndices {
  int32_t reference, current;
};

using FeaturesPointer = std::shared_ptr<const Features>;

/// The answer to one pair of images, as Python sees it: numbers, and columns in place. Nothing else is kept of it, so
/// that it can be copied and pickled.
struct Pair {
  Status status = Status::kFirstFrame;
  std::string status_text;
  bool pose_valid = false, stationary = false;
  Eigen::Matrix4d current_in_reference = Eigen::Matrix4d::Identity();
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix3d model = Eigen::Matrix3d::Zero();
  int keypoints_reference = 0, keypoints_current = 0, inliers = 0, hypotheses = 0;
  double median_parallax_px = 0, rms_error_px = 0, sigma_px = 0, camera_misfit = 0;
  double pose_probability = 0, rotation_probability = 0;
  StageTimes times;
  std::vector<MatchIndices> matches, raw;  // indices of keypoints of the reference and of the current image
  // Columns: an entry for each of `matches`, in the order of the rows of the core's MatchResult.
  std::vector<cv::Point2f> reference_points, current_points;
  std::vector<float> confidence, probability, residual, reference_sigma, current_sigma;
  std::vector<uint16_t> distance, track_length;
  std::vector<uint32_t> track_id;
  std::vector<MatchStage> stage;
  FeaturesPointer reference, current;
  Camera camera;

  Pair() = default;
  Pair(const MatchResult& result, const MatchFilter& filter, FeaturesPointer from, FeaturesPointer to, bool given)
      : reference(std::move(from)), current(std::move(to)), camera(filter.camera()) {
    StatusCircumstances about;
    about.features_given = given;
    status = result.status;
    status_text = explain(status, result, filter.options(), about);
    copyMotion(result);
    copyNumbers(result);
    copyColumns(result);
  }

  int size() const { return static_cast<int>(matches.size()); }

  /// Every field, for copies in other memory.
  template <class Self, class Visit>
  static void visitFields(Self& p, const Visit& visit) {
    visit(p.status, p.status_text, p.pose_valid, p.stationary, p.current_in_reference, p.covariance, p.model,
          p.keypoints_reference, p.keypoints_current, p.inliers, p.hypotheses, p.median_parallax_px, p.rms_error_px,
          p.sigma_px, p.camera_misfit, p.pose_probability, p.rotation_probability, p.times, p.matches, p.raw,
          p.reference_points, p.current_points, p.confidence, p.probability, p.residual, p.reference_sigma,
          p.current_sigma, p.distance, p.track_length, p.track_id, p.stage, p.reference, p.current, p.camera);
  }

  /// Points of the inliers, none where no direction is known.
  Triangulation triangulate(double minimum_parallax) const {
    MatchResult result;
    for (const MatchIndices& match : matches) result.matches.push_back({match.reference, match.current, 0, 0});
    result.current_pixel = current_points;
    for (const MatchStage each : stage) result.inlier.push_back(each == MatchStage::kInlier);
    RelativePose& pose = result.robust.judgement.pose;
    pose.R = current_in_reference.topLeftCorner<3, 3>();
    pose.t = current_in_reference.topRightCorner<3, 1>();
    result.robust.judgement.pose_found = status == Status::kOk;
    Triangulation points;
    triangulateInliers(*reference, result, camera, points, minimum_parallax);
    return points;
  }

 private:
  void copyMotion(const MatchResult& result) {
    stationary = result.stationary;
    model = result.robust.model;
    pose_valid = status == Status::kOk || status == Status::kLowParallax;
    if (!pose_valid) return;
    RelativePose pose = result.robust.judgement.pose;
    current_in_reference.topLeftCorner<3, 3>() = pose.R;
    if (status == Status::kOk) {
      current_in_reference.topRightCorner<3, 1>() = pose.t;
    } else {
      setTranslationVariance(kUnknownTranslationVariance, pose.covariance);
    }
    covariance = pose.covariance;
  }

  void copyNumbers(const MatchResult& result) {
    const RobustResult& robust = result.robust;
    keypoints_reference = result.keypoints_reference;
    keypoints_current = result.keypoints_current;
    inliers = result.inliers;
    hypotheses = robust.effort.hypotheses;
    median_parallax_px = robust.judgement.median_parallax_px;
    rms_error_px = robust.rms_error_px;
    sigma_px = robust.judgement.sigma_px;
    camera_misfit = robust.judgement.camera_misfit;
    pose_probability = robust.judgement.pose_probability;
    rotation_probability = robust.judgement.rotation_probability;
    times = result.times;
  }

  void copyColumns(const MatchResult& result) {
    const RobustResult& robust = result.robust;
    for (const Match& match : result.raw) raw.push_back({match.reference, match.current});
    confidence = result.confidence;
    probability = robust.judgement.probability;
    residual = robust.judgement.residual;
    track_id = result.track_id;
    track_length = result.track_length;
    // Without a model, and in a pair that stands alone, they are zero.
    for (auto* column : {&probability, &residual}) column->resize(result.matches.size());
    track_id.resize(result.matches.size());
    track_length.resize(result.matches.size());
    const SigmaByOctave sigma(robust.judgement, current->scale_factor);
    for (size_t row = 0; row < result.matches.size(); ++row) {
      const Match& match = result.matches[row];
      const cv::KeyPoint& p = reference->keypoints[static_cast<size_t>(match.reference)];
      const cv::KeyPoint& q = current->keypoints[static_cast<size_t>(match.current)];
      matches.push_back({match.reference, match.current});
      reference_points.push_back(p.pt);
      current_points.push_back(result.current_pixel[row]);
      const bool aligned = result.pairs.isAligned(row);
      reference_sigma.push_back(sigma.of(p.octave, aligned));
      current_sigma.push_back(sigma.of(q.octave, aligned));
      distance.push_back(match.distance);
      stage.push_back(result.isInlier(row) ? MatchStage::kInlier : MatchStage::kGms);
    }
  }
};

std::string typeOf(const py::object& value) { return Py_TYPE(value.ptr())->tp_name; }

/// The argument `name` as an array of numbers in one piece, converted if need be.
template <class Array>
Array arrayOf(const py::object& value, const std::string& name, const std::string& expected) {
  Array array = Array::ensure(value);
  if (array) return array;
  PyErr_Clear();
  const bool typed = py::hasattr(value, "dtype");
  throw std::invalid_argument(name + " is " +
                              (typed ? "an array of " + std::string(py::str(value.attr("dtype"))) : typeOf(value)) +
                              "; it must be " + expected);
}

/// Pixels as Python gave them. The array is their memory.
struct Image {
  py::array_t<uint8_t, py::array::c_style> array;
  cv::Mat pixels;

  Image(const py::object& value, const std::string& name, bool mask = false) {
    if (value.is_none()) {
      throw std::invalid_argument(name +
                                  " is None, as cv2.imread returns it for a file that it cannot read; check "
                                  "the file's name");
    }
    array = arrayOf<decltype(array)>(value, name,
                                     mask ? "an array of uint8 or bool, height x width"
                                          : "an array of uint8, 0..255: scale it, then image.astype(numpy.uint8)");
    const py::ssize_t channels = array.ndim() == 3 ? array.shape(2) : 1;
    const bool plane = array.ndim() == 2 || (array.ndim() == 3 && channels == 1);
    const bool colour = !mask && array.ndim() == 3 && (channels == 3 || channels == 4);
    if ((!colour && !plane) || array.size() == 0) {
      throw std::invalid_argument(name + " has the shape " + std::string(py::str(array.attr("shape"))) +
                                  "; it must be height x width" +
                                  (mask ? "" : ", or height x width x 3 (blue, green, red), or x 4 (with alpha)"));
    }
    pixels = cv::Mat(static_cast<int>(array.shape(0)), static_cast<int>(array.shape(1)),
                     CV_8UC(static_cast<int>(channels)), const_cast<uint8_t*>(array.data()));  // it may be read-only
  }
  cv::Mat grey() const {
    cv::Mat grey = pixels;
    if (pixels.channels() == 3) cv::cvtColor(pixels, grey, cv::COLOR_BGR2GRAY);
    if (pixels.channels() == 4) cv::cvtColor(pixels, grey, cv::COLOR_BGRA2GRAY);
    return grey;
  }
};
using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// Throws unless `size`, that of `name`, is as large as `whose`.
void requireSize(const std::string& name, const cv::Size& size, const cv::Size& expected, const char* whose) {
  if (size == expected) return;
  throw std::invalid_argument(cv::format("%s is %d x %d pixels, %s %d x %d; both must be of one size", name.c_str(),
                                         size.width, size.height, whose, expected.width, expected.height));
}

/// Throws unless the array is N x 2; N.
py::ssize_t countPoints(const Numbers& points, const std::string& name, const char* what) {
  if (points.ndim() >= 2 && points.shape(points.ndim() - 1) == 2) return points.size() / 2;
  throw std::invalid_argument(name + " has the shape " + std::string(py::str(points.attr("shape"))) +
                              "; it must be N x 2, a row x, y for each " + what);
}

/// Bytes or floats, copied.
cv::Mat descriptorsOf(const py::object& value) {
  const std::string expected = "N x K uint8 (binary descriptors) or N x D float32, a row for each keypoint";
  const auto array = arrayOf<py::array>(value, "descriptors", expected);
  const bool bytes = py::isinstance<py::array_t<uint8_t>>(array), floats = array.dtype().kind() == 'f';
  if (array.ndim() != 2 || (!bytes && !floats)) {
    throw std::invalid_argument("descriptors is an array of " + std::string(py::str(array.dtype())) +
                                " with the shape " + std::string(py::str(array.attr("shape"))) + "; it must be " +
                                expected);
  }
  const auto matrix = [&](auto rows, int type) {
    return cv::Mat(static_cast<int>(array.shape(0)), static_cast<int>(array.shape(1)), type,
                   const_cast<void*>(static_cast<const void*>(rows.data())))  // it may be read-only
        .clone();
  };
  if (bytes) return matrix(arrayOf<py::array_t<uint8_t, py::array::c_style>>(value, "descriptors", expected), CV_8U);
  return matrix(arrayOf<py::array_t<float, py::array::c_style | py::array::forcecast>>(value, "descriptors", expected),
                CV_32F);
}

Features makeFeatures(const py::object& keypoints, const py::object& descriptors, int width, int height,
                      const py::object& octave, const py::object& angle, const py::object& response,
                      float scale_factor) {
  Features features;
  features.image_size = {width, height};
  features.scale_factor = scale_factor;
  const auto points = arrayOf<Numbers>(keypoints, "keypoints", "N x 2 numbers, pixels");
  const py::ssize_t n = points.size() == 0 ? 0 : countPoints(points, "keypoints", "keypoint");
  for (const double* p = points.data(); p != points.data() + 2 * n; p += 2) {
    features.keypoints.emplace_back(static_cast<float>(p[0]), static_cast<float>(p[1]), 0.f, -1.f, 0.f, 0);
  }
  const auto column = [&](const py::object& value, const std::string& name, const auto& set) {
    if (value.is_none()) return;
    const auto numbers = arrayOf<Numbers>(value, name, "N numbers");
    if (numbers.size() != n) {
      throw std::invalid_argument(cv::format("%s has %d numbers, but there are %d keypoints", name.c_str(),
                                             static_cast<int>(numbers.size()), static_cast<int>(n)));
    }
    for (py::ssize_t i = 0; i < n; ++i) set(features.keypoints[static_cast<size_t>(i)], numbers.data()[i]);
  };
  column(octave, "octave", [](cv::KeyPoint& k, double value) {
    k.octave = value >= 0 && value < Features::kOctaves ? static_cast<int>(value) : -1;
  });
  column(angle, "angle", [](cv::KeyPoint& k, double value) { k.angle = static_cast<float>(value); });
  column(response, "response", [](cv::KeyPoint& k, double value) { k.response = static_cast<float>(value); });
  features.descriptors.assign(descriptorsOf(descriptors));
  features.validate();
  return features;
}

Camera makeCamera(int width, int height, const py::object& K, const py::object& coefficients,
                  const std::string& model) {
  if (width < 1 || height < 1) throw std::invalid_argument("Camera: width and height must be positive");
  if (K.is_none()) return {CameraIntrinsics(), cv::Size(width, height)};
  const auto matrix = arrayOf<Numbers>(K, "K", "3 x 3 numbers"),
             D = coefficients.is_none() ? Numbers(0) : arrayOf<Numbers>(coefficients, "D", "numbers");
  const double* k = matrix.data();
  if (matrix.size() != 9 || k[1] != 0 || k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1) {
    throw std::invalid_argument("Camera: K must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]");
  }
  return {{k[0], k[4], k[2], k[5], model, {D.data(), D.data() + D.size()}}, cv::Size(width, height)};
}

/// Threads that share extraction and matching: the node's parameter of that name without its workers.
Parameter threadsParameter() {
  return {"threads", 1, 1, 16, "", "threads that share extraction and matching; the results do not depend on it", {}};
}

/// By their text, so that numpy's numbers are numbers. Text that is no value of the parameter stays text and is
/// refused.
MatchFilterOptions optionsOf(const py::kwargs& named) {
  ParameterValues values;
  MatchFilterOptions options;
  for (const auto& [name, value] : named) {
    if (name.cast<std::string>() == "threads") {
      const std::string text = py::str(value);
      const std::optional<ParameterValue> threads = threadsParameter().parse(text);
      if (!threads) throw std::invalid_argument(refusal("threads", text, threadsParameter().accepted()));
      options.matcher_threads = options.extractor.threads = std::get<int>(*threads);
      continue;
    }
    std::string text = py::str(value);
    if (text == "True" || text == "False") text[0] = static_cast<char>(std::tolower(text[0]));
    ParameterValue& option = values[name.cast<std::string>()] = text;
    for (const Parameter& parameter : coreParameters()) {
      if (parameter.name == name.cast<std::string>()) option = parameter.parse(text).value_or(text);
    }
  }
  setParameters(values, options);
  return options;
}

constexpr double kLargestImage = 1e5;  ///< pixels, a side

/// The pipeline runs without the interpreter's lock.
class Filter {
 public:
  Filter(const Camera* camera, const py::kwargs& options) : filter_(optionsOf(options)) {
    if (camera != nullptr) filter_.setCamera(*camera);
  }
  ParameterValues options() const {
    ParameterValues values = parametersOf(filter_.options());
    values["threads"] = filter_.options().matcher_threads;
    return values;
  }
  void reset() {
    const py::gil_scoped_release unlocked;
    const std::lock_guard<std::mutex> lock(mutex_);
    filter_.reset();
    mask_ = LearnedMask();
  }
  py::array_t<uint8_t> learnedMask() {
    cv::Mat image;
    {
      const py::gil_scoped_release unlocked;
      const std::lock_guard<std::mutex> lock(mutex_);
      image = mask_.toImage();
    }
    return py::array_t<uint8_t>({image.rows, image.cols}, image.data);
  }

  /// `image`: an array, or Features. `name`: of the argument, for refusals.
  std::unique_ptr<Pair> process(const py::object& image, const py::object& mask, std::optional<double> stamp,
                                const RotationPrior* prior, const std::string& name) {
    if (py::isinstance<Features>(image)) {
      if (!mask.is_none()) {
        throw std::invalid_argument("mask has no effect on Features; leave out the keypoints that it covers");
      }
      const auto& features = image.cast<const Features&>();
      return process(features.image_size, name, true, [&] { return &filter_.process(features, stamp, prior); });
    }
    std::optional<Image> where;
    if (!mask.is_none()) where.emplace(mask, "mask", true);
    const Image given(image, name);
    if (where) requireSize("mask", where->pixels.size(), given.pixels.size(), "the image");
    return process(given.pixels.size(), name, false,
                   [&] { return &filter_.process(given.grey(), where ? where->pixels : cv::Mat(), stamp, prior); });
  }

  /// Estimates from given matches, as if the filter had kept them all.
  std::unique_ptr<Pair> estimate(const py::object& from, const py::object& to) {
    Frame reference, current;
    setPoints(from, "points0", reference.features);
    setPoints(to, "points1", current.features);
    if (reference.features.size() != current.features.size()) {
      throw std::invalid_argument(
          cv::format("points0 has %d points and points1 has %d; both must have one point for each match",
                     reference.features.size(), current.features.size()));
    }
    const py::gil_scoped_release unlocked;
    MatchResult result;
    result.clear(Status::kTooFewMatches);
    const int n = result.keypoints_reference = result.keypoints_current = current.features.size();
    for (int i = 0; i < n; ++i) result.raw.push_back({i, i, 0, 0});
    SurvivorSelector(false, filter_.options().robust.rolling_shutter_readout > 0)
        .selectAll(reference.features, current.features, filter_.camera(), result);
    MatchFilterHooks::estimate(filter_, reference, current, result);
    return std::make_unique<Pair>(result, filter_, std::make_shared<Features>(std::move(reference.features)),
                                  std::make_shared<Features>(std::move(current.features)), true);
  }

 private:
  template <class Compare>
  std::unique_ptr<Pair> process(const cv::Size& size, const std::string& name, bool given, const Compare& compare) {
    const py::gil_scoped_release unlocked;
    const std::lock_guard<std::mutex> lock(mutex_);
    const cv::Size expected = filter_.camera().imageSize();
    if (!expected.empty()) requireSize(name, size, expected, "the camera");
    const MatchResult& result = *compare();
    mask_ = result.mask;
    const bool first = filter_.reference().features.size() == 0;
    FeaturesPointer reference = first || !last_ ? std::make_shared<Features>(filter_.reference().features) : last_;
    last_ = std::make_shared<Features>(filter_.current().features);
    return std::make_unique<Pair>(result, filter_, std::move(reference), last_, given);
  }

  void setPoints(const py::object& value, const std::string& name, Features& features) const {
    const auto points = arrayOf<Numbers>(value, name, "N x 2 numbers, pixels");
    countPoints(points, name, "match");
    cv::Point2d last(0, 0);
    for (const double* p = points.data(); p != points.data() + points.size(); p += 2) {
      features.keypoints.emplace_back(static_cast<float>(p[0]), static_cast<float>(p[1]), 0.f);
      if (std::isfinite(p[0]) && std::isfinite(p[1])) last = {std::max(last.x, p[0]), std::max(last.y, p[1])};
    }
    features.image_size = filter_.camera().imageSize();
    if (features.image_size.empty()) {  // no camera: the image is as large as the points need
      features.image_size = {cvCeil(std::min(last.x, kLargestImage)) + 1, cvCeil(std::min(last.y, kLargestImage)) + 1};
    } else {
      requireInside(name, features);
    }
  }
  /// A lost track may be anywhere, most points may not.
  static void requireInside(const std::string& name, const Features& features) {
    const cv::Size& size = features.image_size;
    const cv::KeyPoint* example = nullptr;
    size_t outside = 0;
    for (const cv::KeyPoint& point : features.keypoints) {
      if (cv::Rect2f(-1, -1, size.width + 2.f, size.height + 2.f).contains(point.pt)) continue;
      ++outside;
      if (std::isfinite(point.pt.x) && std::isfinite(point.pt.y)) example = &point;
    }
    if (example == nullptr || 2 * outside <= features.keypoints.size()) return;
    throw std::invalid_argument(cv::format(
        "%zu of %zu points of %s are outside of the camera's image of %d x %d pixels, such as (%g, %g); points must be "
        "x, y in pixels of that image",
        outside, features.keypoints.size(), name.c_str(), size.width, size.height, static_cast<double>(example->pt.x),
        static_cast<double>(example->pt.y)));
  }

  MatchFilter filter_;
  FeaturesPointer last_;  ///< a copy of the last image's, which answers share
  LearnedMask mask_;      ///< of the last pair
  std::mutex mutex_;
};

/// The column in place, as a matrix with a row for each of its items.
template <class Number, int columns, class Item>
auto viewOf(const std::vector<Item>& column) {
  using Matrix = Eigen::Matrix<Number, Eigen::Dynamic, columns, columns == 1 ? Eigen::ColMajor : Eigen::RowMajor>;
  return Eigen::Map<const Matrix>(reinterpret_cast<const Number*>(column.data()),
                                  static_cast<Eigen::Index>(column.size()), columns);
}

/// x, y, octave, angle, response of each keypoint.
py::array_t<float> columnsOf(const Features& features) {
  py::array_t<float> rows({static_cast<py::ssize_t>(features.size()), py::ssize_t{5}});
  float* out = rows.mutable_data();
  for (const cv::KeyPoint& k : features.keypoints) {
    for (const float value : {k.pt.x, k.pt.y, static_cast<float>(k.octave), k.angle, k.response}) *out++ = value;
  }
  return rows;
}

py::array descriptorsIn(const Features& features) {
  const cv::Mat rows = features.descriptors.asMat();
  const std::vector<py::ssize_t> shape = {rows.rows, rows.cols};
  if (rows.depth() == CV_32F) return py::array_t<float>(shape, rows.ptr<float>());
  return py::array_t<uint8_t>(shape, rows.data);
}

constexpr const char* kPairText = R"(The answer to one pair of images. Arrays are views of it and keep it alive.

Columns with an entry for each of the N matches that the filter keeps (`matches_gms`):
  matches          N x 2 int32: row of the match in the keypoints of `reference` and of `current`
  reference_points, current_points  N x 2 float32, pixels
  confidence       float32, 0..1: motion-statistics score over the largest of the pair; no probability
  distance         uint16, 0..256: Hamming distance of the descriptors; of Features that are not 32 bytes scaled to
                   that range, with perpendicular vectors 128 apart
  stage            uint8: STAGE_GMS (rejected by the estimator) or STAGE_INLIER
  probability      float32, 0..1, that the match is right; 0: rejected, or no model
  residual         float32: the residual that `probability` is computed from, in standard deviations
  reference_sigma, current_sigma  float32, pixels: standard deviation of either coordinate of a right match; 0: unknown
  track_id         uint32: constant while every image of the sequence has the feature; 0: no inlier, or no sequence
  track_length     uint16: images that have the id, at least 2; 0: no track
Before the filter:
  raw              M x 2 int32, as `matches`: all matches that were found (M is `matches_raw`)
  reference, current  gms_ransac.Features: keypoints and descriptors of the two images
Motion:
  status           gms_ransac.Status
  status_text      str: the status in words, with what to do
  pose_valid       bool: status OK, or LOW_PARALLAX, which has a rotation only
  current_in_reference  4 x 4 float64 T, X_reference = T X_current, optical frames; its translation has length 1, or 0
                   if unknown
  covariance       6 x 6 float64: x y z, then rotations about x y z (radians), along the axes of the reference camera; a
                   small rotation w changes R to exp(w) R. Variances of 1000: translation unknown
  model            3 x 3 float64 M: x_current^T M x_reference = 0 (essential: normalised coordinates; fundamental:
                   pixels), or x_current ~ M x_reference (homography: pixels); zero: none
  stationary       bool: the camera stands still
Counts: keypoints_reference, keypoints_current, matches_raw (M), matches_gms (N), inliers, hypotheses (minimal samples)
Pixels: median_parallax_px (displacement of the inliers without the rotation), rms_error_px (of the inliers against the
  model), sigma_px (of a keypoint of the finest level; 0: unknown)
camera_misfit: contradiction between matches and camera model; often above 1 with a good calibration
pose_probability, rotation_probability: that the motion found is right (rotation to 3 degrees, direction to 20), and
  that its rotation is; 0 without judge
Seconds: time_detect, time_match, time_gms, time_ransac)";

constexpr const char* kTriangulateText = R"(triangulate(minimum_parallax=0.0035)

Returns the gms_ransac.Triangulation of the inliers, empty unless the status is OK. minimum_parallax: radians between the
two rays, below which a point is not valid.)";

constexpr const char* kTriangulationText =
    R"(The inliers of a pair as points, in multiples of the baseline. Columns with
an entry for each inlier:
  row              int32: in the columns of the MatchResult
  points           K x 3 float64, in the current camera's optical frame
  depth_reference, depth_current  float64, along the optical axes
  parallax         float64, radians between the two rays
  valid            uint8, 1: before both cameras, with enough parallax)";

constexpr const char* kPriorText = R"(RotationPrior(R, covariance)

The rotation of a pair by a gyro, an odometry or the like. A proposal: it wins only where the matches support it.
R           3 x 3, X_reference = R X_current
covariance  3 x 3, radians^2, of a rotation vector w that changes R to exp(w) R)";

constexpr const char* kFeaturesText =
    R"(Features(keypoints, descriptors, width, height, octave=None, angle=None, response=None, scale_factor=1.2)

Features of any detector, for MatchFilter.process and match in place of an image. Copied; ValueError names what is wrong.
keypoints     N x 2, pixels x, y, the centre of the first pixel at 0, 0
descriptors   N x K uint8: binary, K bytes each, compared by their Hamming distance; or N x D float32, compared by their
              Euclidean distance. Only mutual nearest neighbours match, except with K = 32 (ORB)
width, height of the image, pixels
octave        N pyramid levels, 0..15, of which the noise of a keypoint depends; None: 0
angle         N orientations, degrees 0..360 or -180..180, -1: unknown; None: unknown
response      N strengths; None: 0
scale_factor  between two octaves, above 1

Has len(), and copies as arrays: `keypoints` (N x 5 float32: x, y, octave, angle, response), `descriptors`.)";

// Pickles hold every field: numbers and columns as their bytes, the rest as Python's objects.

constexpr int kPickleFormat = 1;  ///< another one is refused

template <class T>
py::object toPickle(const T& value) {
  return py::bytes(reinterpret_cast<const char*>(&value), sizeof(T));
}
template <class T>
py::object toPickle(const std::vector<T>& column) {
  return py::bytes(reinterpret_cast<const char*>(column.data()), column.size() * sizeof(T));
}
py::object toPickle(const std::string& text) { return py::str(text); }
py::object toPickle(const FeaturesPointer& features) { return features ? py::cast(Features(*features)) : py::none(); }
py::object toPickle(const Camera& camera) { return py::cast(camera); }

std::string bytesOf(const py::handle& pickled) { return py::cast<std::string>(py::cast<py::bytes>(pickled)); }
void requirePickle(bool is_ours) {
  if (!is_ours) throw std::invalid_argument("gms_ransac: this pickle was made by another version");
}

template <class T>
void fromPickle(const py::handle& pickled, T& value) {
  const std::string bytes = bytesOf(pickled);
  requirePickle(bytes.size() == sizeof(T));
  std::memcpy(static_cast<void*>(&value), bytes.data(), sizeof(T));
}
template <class T>
void fromPickle(const py::handle& pickled, std::vector<T>& column) {
  const std::string bytes = bytesOf(pickled);
  requirePickle(bytes.size() % sizeof(T) == 0);
  column.resize(bytes.size() / sizeof(T));
  if (!bytes.empty()) std::memcpy(static_cast<void*>(column.data()), bytes.data(), bytes.size());
}
void fromPickle(const py::handle& pickled, std::string& text) { text = pickled.cast<std::string>(); }
void fromPickle(const py::handle& pickled, FeaturesPointer& features) {
  if (!pickled.is_none()) features = std::make_shared<Features>(pickled.cast<const Features&>());
}
void fromPickle(const py::handle& pickled, Camera& camera) { camera = pickled.cast<const Camera&>(); }

py::tuple pickled(const Pair& pair) {
  py::list fields;
  fields.append(kPickleFormat);
  Pair::visitFields(pair, [&](const auto&... field) { (fields.append(toPickle(field)), ...); });
  return py::tuple(fields);
}

Pair pairOf(const py::tuple& fields) {
  Pair pair;
  Pair::visitFields(pair, [&](auto&... field) {
    requirePickle(fields.size() == 1 + sizeof...(field) && fields[0].cast<int>() == kPickleFormat);
    size_t i = 0;
    (fromPickle(fields[++i], field), ...);
  });
  return pair;
}

py::tuple pickledFeatures(const Features& features) {
  const cv::Mat rows = features.descriptors.asMat();
  const bool floats = rows.depth() == CV_32F;
  const size_t bytes = rows.total() * rows.elemSize();
  return py::make_tuple(kPickleFormat, features.image_size.width, features.image_size.height, features.scale_factor,
                        toPickle(features.keypoints), floats, rows.cols,
                        py::bytes(reinterpret_cast<const char*>(rows.data), bytes));
}

Features featuresOf(const py::tuple& fields) {
  requirePickle(fields.size() == 8 && fields[0].cast<int>() == kPickleFormat);
  Features features;
  features.image_size = {fields[1].cast<int>(), fields[2].cast<int>()};
  features.scale_factor = fields[3].cast<float>();
  fromPickle(fields[4], features.keypoints);
  const bool floats = fields[5].cast<bool>();
  const int columns = fields[6].cast<int>();
  std::string bytes = bytesOf(fields[7]);
  const size_t row = static_cast<size_t>(std::max(1, columns)) * (floats ? sizeof(float) : 1);
  requirePickle(bytes.size() % row == 0);
  const auto rows = static_cast<int>(bytes.size() / row);
  if (rows > 0) features.descriptors.assign(cv::Mat(rows, columns, floats ? CV_32F : CV_8U, &bytes[0]));
  return features;
}

py::tuple pickledCamera(const Camera& camera) {
  const CameraIntrinsics& k = camera.intrinsics();
  return py::make_tuple(kPickleFormat, camera.imageSize().width, camera.imageSize().height, k.fx, k.fy, k.cx, k.cy,
                        k.distortion_model, k.distortion);
}

Camera cameraOf(const py::tuple& fields) {
  requirePickle(fields.size() == 9 && fields[0].cast<int>() == kPickleFormat);
  return {{fields[3].cast<double>(), fields[4].cast<double>(), fields[5].cast<double>(), fields[6].cast<double>(),
           fields[7].cast<std::string>(), fields[8].cast<std::vector<double>>()},
          {fields[1].cast<int>(), fields[2].cast<int>()}};
}

void definePair(py::module& m) {
  py::enum_<Status> status(m, "Status", "Outcome of a pair, as in MatchStats.msg.");
  for (const Status each : kStatuses) {
    status.value(toString(each).c_str(), each);
  }
  py::class_<Pair> type(m, "MatchResult", kPairText);
  type.attr("STAGE_RAW") = static_cast<int>(MatchStage::kRaw);
  type.attr("STAGE_GMS") = static_cast<int>(MatchStage::kGms);
  type.attr("STAGE_INLIER") = static_cast<int>(MatchStage::kInlier);
  type.def("__repr__", [](const Pair& pair) {
    return cv::format("<MatchResult %s: %d inliers of %zu matches>", toString(pair.status).c_str(), pair.inliers,
                      pair.raw.size());
  });
  type.def(py::pickle(&pickled, &pairOf));
  type.def("triangulate", &Pair::triangulate, py::arg("minimum_parallax") = kMinimumParallax, kTriangulateText);
  type.def_readonly("status", &Pair::status);
  type.def_readonly("status_text", &Pair::status_text);
  type.def_readonly("pose_valid", &Pair::pose_valid);
  type.def_readonly("stationary", &Pair::stationary);
  type.def_readonly("current_in_reference", &Pair::current_in_reference);
  type.def_readonly("covariance", &Pair::covariance);
  type.def_readonly("model", &Pair::model);
  type.def_readonly("keypoints_reference", &Pair::keypoints_reference);
  type.def_readonly("keypoints_current", &Pair::keypoints_current);
  type.def_readonly("inliers", &Pair::inliers);
  type.def_readonly("hypotheses", &Pair::hypotheses);
  type.def_readonly("median_parallax_px", &Pair::median_parallax_px);
  type.def_readonly("rms_error_px", &Pair::rms_error_px);
  type.def_readonly("sigma_px", &Pair::sigma_px);
  type.def_readonly("camera_misfit", &Pair::camera_misfit);
  type.def_readonly("pose_probability", &Pair::pose_probability);
  type.def_readonly("rotation_probability", &Pair::rotation_probability);
  const auto define = [&type](const char* name, auto getter) { type.def_property_readonly(name, getter); };
  define("matches", [](const Pair& pair) { return viewOf<int32_t, 2>(pair.matches); });
  define("raw", [](const Pair& pair) { return viewOf<int32_t, 2>(pair.raw); });
  define("reference_points", [](const Pair& pair) { return viewOf<float, 2>(pair.reference_points); });
  define("current_points", [](const Pair& pair) { return viewOf<float, 2>(pair.current_points); });
  define("confidence", [](const Pair& pair) { return viewOf<float, 1>(pair.confidence); });
  define("distance", [](const Pair& pair) { return viewOf<uint16_t, 1>(pair.distance); });
  define("stage", [](const Pair& pair) { return viewOf<uint8_t, 1>(pair.stage); });
  define("probability", [](const Pair& pair) { return viewOf<float, 1>(pair.probability); });
  define("residual", [](const Pair& pair) { return viewOf<float, 1>(pair.residual); });
  define("reference_sigma", [](const Pair& pair) { return viewOf<float, 1>(pair.reference_sigma); });
  define("current_sigma", [](const Pair& pair) { return viewOf<float, 1>(pair.current_sigma); });
  define("track_id", [](const Pair& pair) { return viewOf<uint32_t, 1>(pair.track_id); });
  define("track_length", [](const Pair& pair) { return viewOf<uint16_t, 1>(pair.track_length); });
  define("reference", [](const Pair& pair) { return std::const_pointer_cast<Features>(pair.reference); });
  define("current", [](const Pair& pair) { return std::const_pointer_cast<Features>(pair.current); });
  define("matches_raw", [](const Pair& pair) { return pair.raw.size(); });
  define("matches_gms", &Pair::size);
  define("time_detect", [](const Pair& pair) { return pair.times.detect; });
  define("time_match", [](const Pair& pair) { return pair.times.match; });
  define("time_gms", [](const Pair& pair) { return pair.times.gms; });
  define("time_ransac", [](const Pair& pair) { return pair.times.ransac; });
}

void defineTriangulation(py::module& m) {
  py::class_<Triangulation> type(m, "Triangulation", kTriangulationText);
  const auto define = [&type](const char* name, auto getter) { type.def_property_readonly(name, getter); };
  type.def("__len__", &Triangulation::size);
  define("row", [](const Triangulation& points) { return viewOf<int, 1>(points.row); });
  define("points", [](const Triangulation& points) {
    Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> rows(points.size(), 3);
    for (int i = 0; i < points.size(); ++i) rows.row(i) = points.point(i);
    return rows;
  });
  define("depth_reference", [](const Triangulation& points) { return viewOf<double, 1>(points.depth_reference); });
  define("depth_current", [](const Triangulation& points) { return viewOf<double, 1>(points.depth_current); });
  define("parallax", [](const Triangulation& points) { return viewOf<double, 1>(points.parallax); });
  define("valid", [](const Triangulation& points) { return viewOf<uint8_t, 1>(points.valid); });
}

RotationPrior makePrior(const py::object& R, const py::object& covariance) {
  const auto matrixOf = [](const py::object& value, const std::string& name) {
    const auto numbers = arrayOf<Numbers>(value, name, "3 x 3 numbers");
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> matrix(numbers.data());
    if (numbers.size() != 9 || !matrix.allFinite()) throw std::invalid_argument(name + " must be 3 x 3 numbers");
    return Eigen::Matrix3d(matrix);
  };
  RotationPrior prior;
  prior.R = matrixOf(R, "R");
  prior.covariance = matrixOf(covariance, "covariance");
  constexpr double kRounding = 1e-6;
  if (!(prior.R.transpose() * prior.R).isIdentity(kRounding) || prior.R.determinant() < 0) {
    throw std::invalid_argument("R is no rotation matrix");
  }
  if (!prior.covariance.isApprox(prior.covariance.transpose()) || prior.covariance.diagonal().minCoeff() <= 0) {
    throw std::invalid_argument("covariance must be symmetric, with positive variances in radians^2");
  }
  return prior;
}

std::string filterText() {
  std::string text = R"(MatchFilter(camera=None, **options)

Compares each image of a sequence with the one before. Without a calibrated camera there are matches and no pose. Options
are the node's parameters; ValueError says what one must be:
)";
  std::vector<Parameter> parameters(coreParameters().begin(), coreParameters().end());
  parameters.push_back(threadsParameter());
  for (const Parameter& parameter : parameters) {
    text += "  " + parameter.name + "=" + toText(parameter.default_value) + ": " + parameter.sentence + " (" +
            parameter.accepted() + ")\n";
  }
  return text;
}

}  // namespace

}  // namespace gms_ransac

PYBIND11_MODULE(_gms_ransac, m) {
  using namespace gms_ransac;
  definePair(m);
  defineTriangulation(m);
  py::class_<Camera>(m, "Camera",
                     "Camera(width, height, K=None, D=(), distortion_model='')\n\nAs in sensor_msgs/CameraInfo. width, "
                     "height: pixels. K: 3 x 3, pixels; None: not calibrated. D: coefficients in OpenCV's order. "
                     "distortion_model: '' or 'plumb_bob', 'rational_polynomial', 'equidistant' (fisheye), "
                     "'omnidirectional', 'double_sphere'.")
      .def(py::init(&makeCamera), py::arg("width"), py::arg("height"), py::arg("K") = py::none(),
           py::arg("D") = py::tuple(), py::arg("distortion_model") = "")
      .def(py::pickle(&pickledCamera, &cameraOf));
  py::class_<RotationPrior>(m, "RotationPrior", kPriorText)
      .def(py::init(&makePrior), py::arg("R"), py::arg("covariance"));
  py::class_<Features, std::shared_ptr<Features>>(m, "Features", kFeaturesText)
      .def(py::init(&makeFeatures), py::arg("keypoints"), py::arg("descriptors"), py::arg("width"), py::arg("height"),
           py::arg("octave") = py::none(), py::arg("angle") = py::none(), py::arg("response") = py::none(),
           py::arg("scale_factor") = Features().scale_factor)
      .def("__len__", &Features::size)
      .def(py::pickle(&pickledFeatures, &featuresOf))
      .def_property_readonly("keypoints", [](const Features& features) { return columnsOf(features); })
      .def_property_readonly("descriptors", &descriptorsIn)
      .def("__repr__", [](const Features& features) {
        return cv::format("<Features: %d keypoints, descriptors of %s>", features.size(),
                          features.descriptors.kind().c_str());
      });
  py::class_<Filter>(m, "MatchFilter", filterText().c_str())
      .def(py::init<const Camera*, const py::kwargs&>(), py::arg("camera") = py::none())
      .def(
          "process",
          [](Filter& filter, const py::object& image, const py::object& mask, std::optional<double> stamp,
             const RotationPrior* prior) { return filter.process(image, mask, stamp, prior, "image"); },
          py::arg("image"), py::arg("mask") = py::none(), py::arg("stamp") = py::none(), py::arg("prior") = py::none(),
          "Returns the MatchResult of the last image and this one; status FIRST_FRAME if there was none.\n\n"
          "image: uint8, height x width (grey) or height x width x 3 (blue, green, red, as cv2.imread reads it), or x "
          "4 "
          "with alpha; or Features. Descriptors of another kind than those before begin a new sequence.\n"
          "mask: uint8 or bool, height x width; no keypoint where it is zero.\n"
          "stamp: seconds, of the middle row; needed with rolling_shutter_readout.\n"
          "prior: RotationPrior, the rotation since the last image by another sensor.\n\n"
          "Other Python threads run meanwhile; calls to one filter wait for each other.")
      .def("reset", &Filter::reset, "The next image is the first of a new sequence, of the same camera.")
      .def_property_readonly(
          "learned_mask", &Filter::learnedMask,
          "uint8, height x width: 0 where the last pair left out what is fixed to the camera, as `mask` "
          "takes it; empty before the first pair")
      .def_property_readonly("options", &Filter::options, "dict: every option by name");
  m.def(
      "match",
      [](const py::object& image0, const py::object& image1, const Camera* camera, const RotationPrior* prior,
         const py::kwargs& options) {
        Filter filter(camera, options);
        const auto first = filter.process(image0, py::none(), std::nullopt, prior, "image0");
        auto pair = filter.process(image1, py::none(), std::nullopt, prior, "image1");
        if (!first->current->descriptors.comparableWith(pair->current->descriptors)) {
          throw std::invalid_argument("descriptors of " + pair->current->descriptors.kind() +
                                      " cannot be compared with those of " + first->current->descriptors.kind());
        }
        return pair;
      },
      py::arg("image0"), py::arg("image1"), py::arg("camera") = py::none(), py::arg("prior") = py::none(),
      R"(match(image0, image1, camera=None, prior=None, **options)

Returns the MatchResult of the reference image0 and the current image1: arrays or Features, as of MatchFilter.process.
Options as of MatchFilter.)");
  m.def(
      "estimate",
      [](const py::object& points0, const py::object& points1, const Camera* camera, const py::kwargs& options) {
        return Filter(camera, options).estimate(points0, points1);
      },
      py::arg("points0"), py::arg("points1"), py::arg("camera") = py::none(),
      R"(estimate(points0, points1, camera=None, **options)

Returns the MatchResult of given matches, without a camera their fundamental matrix. points0, points1: N x 2, pixels of the reference and the current image, a row
for each match, most trusted first: methods that sample the best matches first keep this order. Options as of
MatchFilter.)");
}
