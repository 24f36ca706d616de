// gms_ransac._gms_ransac: the pipeline for Python. Knows no ROS. Fields have the names of the messages in msg/, options
// those of the parameters in cfg/parameters.py.
#include <algorithm>
#include <cctype>
#include <cmath>
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
#include <opencv2/imgproc.hpp>

#include "gms_ransac/match_filter.h"
#include "parameter.h"
#include "survivors.h"
#include "two_view/sigma_by_octave.h"
#include "two_view/translation_variance.h"

namespace gms_ransac {

namespace {

namespace py = pybind11;

/// The answer to one pair of images. Python sees the columns in place.
struct Pair : MatchResult {
  std::vector<cv::Point2f> reference_points, current_points;  // of raw matches, as are all columns here
  std::vector<float> support, probabilities, reference_sigma, current_sigma;
  std::vector<MatchStage> stage;
  std::vector<uint16_t> distance;
  bool pose_valid = false;
  Eigen::Matrix4d current_in_reference = Eigen::Matrix4d::Identity();
  Covariance6d covariance = Covariance6d::Zero();

  void finish(const Features& reference, const Features& current) {
    const SigmaByOctave sigma(robust, current.scale_factor);
    forEachRaw([&](const Match& match, MatchStage its_stage, size_t row) {
      const bool kept = its_stage != MatchStage::kRaw;
      const cv::KeyPoint& p = reference.keypoints[static_cast<size_t>(match.reference)];
      const cv::KeyPoint& q = current.keypoints[static_cast<size_t>(match.current)];
      reference_points.push_back(p.pt);
      current_points.push_back(q.pt);
      reference_sigma.push_back(sigma[p.octave]);
      current_sigma.push_back(sigma[q.octave]);
      distance.push_back(match.distance);
      stage.push_back(its_stage);
      support.push_back(kept ? confidence[row] : 0);
      probabilities.push_back(kept ? probability(row) : 0);
    });
    pose_valid = status == Status::kOk || status == Status::kLowParallax;
    if (!pose_valid) return;
    current_in_reference.topLeftCorner<3, 3>() = robust.pose.R;
    covariance = robust.pose.covariance;
    if (status == Status::kOk) {
      current_in_reference.topRightCorner<3, 1>() = robust.pose.t;
    } else {
      setTranslationVariance(kUnknownTranslationVariance, covariance);
    }
  }
};

/// The status in words, with what to do about it.
std::string statusText(const Pair& pair) {
  const int raw = static_cast<int>(pair.raw.size());
  switch (pair.status) {
    case Status::kOk:
      return cv::format("%d of %d filtered matches agree on one motion", pair.inliers, pair.size());
    case Status::kFirstFrame:
      return "the first image has nothing to be compared with: process the next one";
    case Status::kTooFewKeypoints:
      return cv::format(
          "only %d and %d keypoints: an image is dark, blurred, plain or masked; fast_threshold=0 finds "
          "fainter ones",
          pair.keypoints_reference, pair.keypoints_current);
    case Status::kTooFewMatches:
      return cv::format("only %d matches, and %d are needed", raw, kMinimumMatches);
    case Status::kGmsRejected:
      return cv::format(
          "only %d of %d matches are left by the filter: the views differ too much, or features is too "
          "small",
          pair.size(), raw);
    case Status::kRansacFailed:
      if (pair.robust.doubt == DirectionDoubt::kDiscontinuity) {
        return "the direction of translation breaks with the motion before, and too little of what was static until "
               "now is seen to confirm it";
      }
      return cv::format(
          "no model explains enough of the %d filtered matches: the views differ too much, or little of "
          "what is seen is rigid",
          pair.size());
    case Status::kUncalibrated:
      return "matches and no pose: give a camera with K";
    case Status::kLowParallax:
      break;
  }
  switch (pair.robust.doubt) {
    case DirectionDoubt::kMostlyStatic:
      return "rotation only: most matches show no translation, and the others may lie on moving objects";
    case DirectionDoubt::kRotation:
      return "rotation only: its standard deviation is above one degree, too much for a translation";
    case DirectionDoubt::kDirection:
      return "rotation only: the direction of translation is less certain than max_direction_sigma";
    case DirectionDoubt::kDiscontinuity:
      return "rotation only: the direction of translation breaks with the motion before, and what was static until now "
             "does not show it";
    case DirectionDoubt::kUnconfirmed:
      return "rotation only: the direction of translation is not that of the pair before, and less certain than half "
             "of "
             "max_direction_sigma";
    case DirectionDoubt::kOtherMotion:
      return "rotation only: a second motion explains the matches as well, or part of them";
    default:
      return "rotation only: it explains the matches as well as a motion with translation; take images further apart";
  }
}

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
    const bool colour = !mask && array.ndim() == 3 && array.shape(2) == 3;
    if ((!colour && array.ndim() != 2) || array.size() == 0) {
      throw std::invalid_argument(name + " has the shape " + std::string(py::str(array.attr("shape"))) +
                                  "; it must be height x width" +
                                  (mask ? "" : ", or height x width x 3 (blue, green, red)"));
    }
    pixels = cv::Mat(static_cast<int>(array.shape(0)), static_cast<int>(array.shape(1)), colour ? CV_8UC3 : CV_8UC1,
                     array.mutable_data());
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
    return cv::Mat(static_cast<int>(array.shape(0)), static_cast<int>(array.shape(1)), type, rows.mutable_data())
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
  const auto matrix = arrayOf<Numbers>(K, "K", "3 x 3 numbers"), D = arrayOf<Numbers>(coefficients, "D", "numbers");
  const double* k = matrix.data();
  if (matrix.size() != 9 || k[1] != 0 || k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1) {
    throw std::invalid_argument("Camera: K must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]");
  }
  return {{k[0], k[4], k[2], k[5], model, {D.data(), D.data() + D.size()}}, cv::Size(width, height)};
}

/// By their text, so that numpy's numbers are numbers. Text that is no value of the parameter stays text and is
/// refused.
MatchFilterOptions optionsOf(const py::kwargs& named) {
  ParameterValues values;
  for (const auto& [name, value] : named) {
    std::string text = py::str(value);
    if (text == "True" || text == "False") text[0] = static_cast<char>(std::tolower(text[0]));
    ParameterValue& option = values[name.cast<std::string>()] = text;
    for (const Parameter& parameter : coreParameters()) {
      if (parameter.name == name.cast<std::string>()) option = parameter.parse(text).value_or(text);
    }
  }
  MatchFilterOptions options;
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
  ParameterValues options() const { return parametersOf(filter_.options()); }

  /// `name`: of the image, for refusals.
  std::unique_ptr<Pair> process(const Image& image, const std::optional<Image>& mask, std::optional<double> stamp,
                                const std::string& name) {
    const cv::Mat& pixels = image.pixels;
    if (mask) requireSize("mask", mask->pixels.size(), pixels.size(), "the image");
    const py::gil_scoped_release unlocked;
    const std::lock_guard<std::mutex> lock(mutex_);
    const cv::Size size = filter_.camera().imageSize();
    if (!size.empty()) requireSize(name, pixels.size(), size, "the camera");
    cv::Mat grey = pixels;
    if (pixels.channels() == 3) cv::cvtColor(pixels, grey, cv::COLOR_BGR2GRAY);
    filter_.extract(grey, current_, mask ? mask->pixels : cv::Mat(), stamp);
    return follow();
  }

  /// The same with features in place of an image.
  std::unique_ptr<Pair> process(const Features& features, std::optional<double> stamp, const std::string& name) {
    const py::gil_scoped_release unlocked;
    const std::lock_guard<std::mutex> lock(mutex_);
    const cv::Size size = filter_.camera().imageSize();
    if (!size.empty()) requireSize(name, features.image_size, size, "the camera");
    current_ = Frame(features, stamp);
    return follow();
  }

  /// `image`: an array, or Features.
  std::unique_ptr<Pair> process(const py::object& image, const py::object& mask, std::optional<double> stamp,
                                const std::string& name) {
    if (py::isinstance<Features>(image)) {
      if (!mask.is_none()) {
        throw std::invalid_argument("mask has no effect on Features; leave out the keypoints that it covers");
      }
      return process(image.cast<const Features&>(), stamp, name);
    }
    std::optional<Image> where;
    if (!mask.is_none()) where.emplace(mask, "mask", true);
    return process(Image(image, name), where, stamp, name);
  }

  /// Estimates from given matches, as if the filter had kept them all.
  std::unique_ptr<Pair> estimate(const py::object& reference, const py::object& current) {
    setPoints(reference, "points0", reference_.features);
    setPoints(current, "points1", current_.features);
    if (reference_.features.size() != current_.features.size()) {
      throw std::invalid_argument(
          cv::format("points0 has %d points and points1 has %d; both must have one point for each match",
                     reference_.features.size(), current_.features.size()));
    }
    const py::gil_scoped_release unlocked;
    const int n = current_.features.size();
    auto pair = std::make_unique<Pair>();
    pair->status = Status::kTooFewMatches;
    pair->keypoints_reference = pair->keypoints_current = n;
    for (int i = 0; i < n; ++i) pair->raw.push_back({i, i, 0, 0});
    MotionStatistics all;
    all.accepted.assign(pair->raw.size(), 1);
    all.score.assign(pair->raw.size(), 0);
    all.relative_score.assign(pair->raw.size(), 0);
    SurvivorSelector(false, filter_.options().robust.rolling_shutter_readout > 0)
        .select(reference_.features, current_.features, all, filter_.camera(), *pair);
    MatchFilterHooks::estimate(filter_, reference_, current_, *pair);
    pair->finish(reference_.features, current_.features);
    // Points without a ray are no fault of a filter.
    std::replace(pair->stage.begin(), pair->stage.end(), MatchStage::kRaw, MatchStage::kGms);
    std::fill(pair->support.begin(), pair->support.end(), 1);
    return pair;
  }

 private:
  /// Compares `current_` with the frame before, and keeps it for the next.
  std::unique_ptr<Pair> follow() {
    auto pair = std::make_unique<Pair>();
    if (have_reference_) {
      filter_.filter(reference_, current_, *pair, nullptr, &past_);
    } else {
      pair->keypoints_current = current_.features.size();
      pair->times.detect = current_.detect_seconds;
    }
    pair->finish(reference_.features, current_.features);
    std::swap(reference_, current_);
    have_reference_ = true;
    return pair;
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
  Frame reference_, current_;
  bool have_reference_ = false;
  Past past_;
  std::mutex mutex_;
};

/// The column in place, as a matrix with a row for each of its items.
template <class Number, int columns, class Item>
auto viewOf(const std::vector<Item>& column) {
  using Matrix = Eigen::Matrix<Number, Eigen::Dynamic, columns, columns == 1 ? Eigen::ColMajor : Eigen::RowMajor>;
  return Eigen::Map<const Matrix>(reinterpret_cast<const Number*>(column.data()),
                                  static_cast<Eigen::Index>(column.size()), columns);
}

constexpr const char* kPairText = R"(The answer to one pair of images. Arrays are views of it and keep it alive.

Columns with an entry for each of the N raw matches:
  reference_points, current_points  N x 2 float32, pixels
  confidence       float32, 0..1: motion-statistics score over the largest of the pair; no probability
  distance         uint16, 0..256: Hamming distance of the descriptors; of Features that are not 32 bytes scaled to
                   that range, with perpendicular vectors 128 apart
  stage            uint8: STAGE_RAW (rejected by the motion statistics), STAGE_GMS (by the estimator), STAGE_INLIER
  probability      float32, 0..1, that the match is right; 0: rejected, or no model
  reference_sigma, current_sigma  float32, pixels: standard deviation of either coordinate of a right match; 0: unknown
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
Counts: keypoints_reference, keypoints_current, matches_raw (N), matches_gms (kept by the motion statistics), inliers,
  hypotheses (minimal samples)
Pixels: median_parallax_px (displacement of the inliers without the rotation), rms_error_px (of the inliers against the
  model), sigma_px (of a keypoint of the finest level; 0: unknown)
camera_misfit: contradiction between matches and camera model; often above 1 with a good calibration
Seconds: time_detect, time_match, time_gms, time_ransac)";

constexpr const char* kFeaturesText =
    R"(Features(keypoints, descriptors, width, height, octave=None, angle=None, response=None, scale_factor=1.2)

Features of any detector, for MatchFilter.process and match in place of an image. Copied; ValueError names what is wrong.
keypoints     N x 2, pixels x, y, the centre of the first pixel at 0, 0
descriptors   N x K uint8: binary, K bytes each, compared by their Hamming distance; or N x D float32, compared by their
              Euclidean distance. Only mutual nearest neighbours match, except with K = 32 (ORB)
width, height of the image, pixels
octave        N pyramid levels, 0..15, of which the noise of a keypoint depends; None: 0
angle         N orientations, degrees 0..360, -1: unknown; None: unknown
response      N strengths; None: 0
scale_factor  between two octaves, above 1)";

void definePair(py::module& m) {
  py::enum_<Status> status(m, "Status", "Outcome of a pair, as in MatchStats.msg.");
  for (int i = 0; i <= static_cast<int>(Status::kUncalibrated); ++i) {
    status.value(toString(static_cast<Status>(i)).c_str(), static_cast<Status>(i));
  }
  py::class_<Pair> type(m, "MatchResult", kPairText);
  type.attr("STAGE_RAW") = static_cast<int>(MatchStage::kRaw);
  type.attr("STAGE_GMS") = static_cast<int>(MatchStage::kGms);
  type.attr("STAGE_INLIER") = static_cast<int>(MatchStage::kInlier);
  type.def_readonly("status", &Pair::status);
  type.def_readonly("pose_valid", &Pair::pose_valid);
  type.def_readonly("current_in_reference", &Pair::current_in_reference);
  type.def_readonly("covariance", &Pair::covariance);
  type.def_readonly("keypoints_reference", &Pair::keypoints_reference);
  type.def_readonly("keypoints_current", &Pair::keypoints_current);
  type.def_readonly("inliers", &Pair::inliers);
  type.def("__repr__", [](const Pair& pair) {
    return cv::format("<MatchResult %s: %d inliers of %zu matches>", toString(pair.status).c_str(), pair.inliers,
                      pair.raw.size());
  });
  const auto define = [&type](const char* name, auto getter) { type.def_property_readonly(name, getter); };
  define("status_text", &statusText);
  define("reference_points", [](const Pair& pair) { return viewOf<float, 2>(pair.reference_points); });
  define("current_points", [](const Pair& pair) { return viewOf<float, 2>(pair.current_points); });
  define("confidence", [](const Pair& pair) { return viewOf<float, 1>(pair.support); });
  define("distance", [](const Pair& pair) { return viewOf<uint16_t, 1>(pair.distance); });
  define("stage", [](const Pair& pair) { return viewOf<uint8_t, 1>(pair.stage); });
  define("probability", [](const Pair& pair) { return viewOf<float, 1>(pair.probabilities); });
  define("reference_sigma", [](const Pair& pair) { return viewOf<float, 1>(pair.reference_sigma); });
  define("current_sigma", [](const Pair& pair) { return viewOf<float, 1>(pair.current_sigma); });
  define("model", [](const Pair& pair) -> const Eigen::Matrix3d& { return pair.robust.model; });
  define("matches_raw", [](const Pair& pair) { return pair.raw.size(); });
  define("matches_gms", [](const Pair& pair) { return pair.size(); });
  define("hypotheses", [](const Pair& pair) { return pair.robust.effort.hypotheses; });
  define("median_parallax_px", [](const Pair& pair) { return pair.robust.median_parallax_px; });
  define("rms_error_px", [](const Pair& pair) { return pair.robust.rms_error_px; });
  define("sigma_px", [](const Pair& pair) { return pair.robust.sigma_px; });
  define("camera_misfit", [](const Pair& pair) { return pair.robust.camera_misfit; });
  define("time_detect", [](const Pair& pair) { return pair.times.detect; });
  define("time_match", [](const Pair& pair) { return pair.times.match; });
  define("time_gms", [](const Pair& pair) { return pair.times.gms; });
  define("time_ransac", [](const Pair& pair) { return pair.times.ransac; });
}

std::string filterText() {
  std::string text = R"(MatchFilter(camera=None, **options)

Compares each image of a sequence with the one before. Without a calibrated camera there are matches and no pose. Options
are the node's parameters; ValueError says what one must be:
)";
  for (const Parameter& parameter : coreParameters()) {
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
  py::class_<Camera>(m, "Camera",
                     "Camera(width, height, K=None, D=(), distortion_model='')\n\nAs in sensor_msgs/CameraInfo. width, "
                     "height: pixels. K: 3 x 3, pixels; None: not calibrated. D: coefficients in OpenCV's order. "
                     "distortion_model: '' or 'plumb_bob', 'rational_polynomial', 'equidistant' (fisheye), "
                     "'omnidirectional', 'double_sphere'.")
      .def(py::init(&makeCamera), py::arg("width"), py::arg("height"), py::arg("K") = py::none(),
           py::arg("D") = py::tuple(), py::arg("distortion_model") = "");
  py::class_<Features>(m, "Features", kFeaturesText)
      .def(py::init(&makeFeatures), py::arg("keypoints"), py::arg("descriptors"), py::arg("width"), py::arg("height"),
           py::arg("octave") = py::none(), py::arg("angle") = py::none(), py::arg("response") = py::none(),
           py::arg("scale_factor") = Features().scale_factor)
      .def("__len__", &Features::size)
      .def("__repr__", [](const Features& features) {
        return cv::format("<Features: %d keypoints, descriptors of %s>", features.size(),
                          features.descriptors.kind().c_str());
      });
  py::class_<Filter>(m, "MatchFilter", filterText().c_str())
      .def(py::init<const Camera*, const py::kwargs&>(), py::arg("camera") = py::none())
      .def(
          "process",
          [](Filter& filter, const py::object& image, const py::object& mask, std::optional<double> stamp) {
            return filter.process(image, mask, stamp, "image");
          },
          py::arg("image"), py::arg("mask") = py::none(), py::arg("stamp") = py::none(),
          "Returns the MatchResult of the last image and this one; status FIRST_FRAME if there was none.\n\n"
          "image: uint8, height x width (grey) or height x width x 3 (blue, green, red, as cv2.imread reads it); or "
          "Features.\n"
          "mask: uint8 or bool, height x width; no keypoint where it is zero.\n"
          "stamp: seconds, of the middle row; needed with rolling_shutter_readout.\n\n"
          "Other Python threads run meanwhile; calls to one filter wait for each other.")
      .def_property_readonly("options", &Filter::options, "dict: every option by name");
  m.def(
      "match",
      [](const py::object& image0, const py::object& image1, const Camera* camera, const py::kwargs& options) {
        Filter filter(camera, options);
        filter.process(image0, py::none(), std::nullopt, "image0");
        return filter.process(image1, py::none(), std::nullopt, "image1");
      },
      py::arg("image0"), py::arg("image1"), py::arg("camera") = py::none(),
      R"(match(image0, image1, camera=None, **options)

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
