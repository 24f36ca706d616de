// gms_ransac._gms_ransac: the pipeline for Python. Knows no ROS. Fields have the names of the messages in msg/, options
// those of the parameters in cfg/parameters.py.
#include <cctype>
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
  std::vector<cv::Point2f> reference_points, current_points;
  std::vector<float> reference_sigma, current_sigma;
  std::vector<uint16_t> distance;
  bool pose_valid = false;
  Eigen::Matrix4d current_in_reference = Eigen::Matrix4d::Identity();
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();

  void finish(const Features& reference, const Features& current) {
    const SigmaByOctave sigma(robust, current.scale_factor);
    for (const Match& match : matches) {
      const cv::KeyPoint& p = reference.keypoints[static_cast<size_t>(match.reference)];
      const cv::KeyPoint& q = current.keypoints[static_cast<size_t>(match.current)];
      reference_points.push_back(p.pt);
      current_points.push_back(q.pt);
      reference_sigma.push_back(sigma[p.octave]);
      current_sigma.push_back(sigma[q.octave]);
      distance.push_back(match.distance);
    }
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

using Bytes = py::array_t<uint8_t, py::array::c_style>;
using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// The array in place. It must outlive the matrix.
cv::Mat matrixOf(const Bytes& image) {
  const bool colour = image.ndim() == 3 && image.shape(2) == 3;
  if (!colour && image.ndim() != 2) {
    throw std::invalid_argument("an image is height x width, or height x width x 3 (blue, green, red), and not " +
                                std::string(py::str(image.attr("shape"))));
  }
  return {static_cast<int>(image.shape(0)), static_cast<int>(image.shape(1)), colour ? CV_8UC3 : CV_8UC1,
          const_cast<uint8_t*>(image.data())};
}

Camera makeCamera(int width, int height, const std::optional<Numbers>& K, const Numbers& D, const std::string& model) {
  if (width < 1 || height < 1) throw std::invalid_argument("Camera: width and height must be positive");
  if (!K) return {CameraIntrinsics(), cv::Size(width, height)};
  const double* k = K->data();
  if (K->size() != 9 || k[1] != 0 || k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1) {
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

/// The pipeline runs without the interpreter's lock.
class Filter {
 public:
  Filter(const Camera* camera, const py::kwargs& options) : filter_(optionsOf(options)) {
    if (camera != nullptr) filter_.setCamera(*camera);
  }
  ParameterValues options() const { return parametersOf(filter_.options()); }

  std::unique_ptr<Pair> process(const Bytes& image, const std::optional<Bytes>& mask, std::optional<double> stamp) {
    const cv::Mat pixels = matrixOf(image), where = mask ? matrixOf(*mask) : cv::Mat();
    const py::gil_scoped_release unlocked;
    const std::lock_guard<std::mutex> lock(mutex_);
    const cv::Size size = filter_.camera().imageSize();
    if (!size.empty() && pixels.size() != size) throw std::invalid_argument("the image is not of the camera's size");
    cv::Mat grey = pixels;
    if (pixels.channels() == 3) cv::cvtColor(pixels, grey, cv::COLOR_BGR2GRAY);
    filter_.extract(grey, current_, where, stamp);
    auto pair = std::make_unique<Pair>();
    if (have_reference_) {
      filter_.filter(reference_, current_, *pair);
    } else {
      pair->keypoints_current = current_.features.size();
      pair->times.detect = current_.detect_seconds;
    }
    pair->finish(reference_.features, current_.features);
    std::swap(reference_, current_);
    have_reference_ = true;
    return pair;
  }

  /// Estimates from given matches, as if the filter had kept them all.
  std::unique_ptr<Pair> estimate(const Numbers& reference, const Numbers& current) {
    setPoints(reference, reference_.features);
    setPoints(current, current_.features);
    if (reference_.features.size() != current_.features.size()) {
      throw std::invalid_argument("points0 and points1 must have one point for each match");
    }
    const py::gil_scoped_release unlocked;
    const int n = current_.features.size();
    auto pair = std::make_unique<Pair>();
    pair->status = Status::kTooFewMatches;
    pair->keypoints_reference = pair->keypoints_current = n;
    for (int i = 0; i < n; ++i) pair->matches.push_back({i, i, 0, 0});
    pair->stage.assign(pair->matches.size(), MatchStage::kGms);
    pair->confidence.assign(pair->matches.size(), 1);
    pair->probability.assign(pair->matches.size(), 0);
    MotionStatistics all;
    all.accepted.assign(pair->matches.size(), 1);
    all.score.assign(pair->matches.size(), 0);
    all.relative_score.assign(pair->matches.size(), 0);
    SurvivorSelector(false, filter_.options().robust.rolling_shutter_readout > 0)
        .select(reference_.features, current_.features, pair->matches, all, filter_.camera(), pair->survivors);
    pair->matches_gms = pair->survivors.size();
    filter_.estimate(reference_, current_, *pair);
    pair->finish(reference_.features, current_.features);
    return pair;
  }

 private:
  void setPoints(const Numbers& points, Features& features) const {
    if (points.ndim() < 2 || points.shape(points.ndim() - 1) != 2) {
      throw std::invalid_argument("points0 and points1 must be N x 2");
    }
    features.image_size = filter_.camera().imageSize();
    for (const double* p = points.data(); p != points.data() + points.size(); p += 2) {
      features.keypoints.emplace_back(static_cast<float>(p[0]), static_cast<float>(p[1]), 0.f);
    }
  }

  MatchFilter filter_;
  Frame reference_, current_;
  bool have_reference_ = false;
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
  distance         uint16, 0..256: Hamming distance of the descriptors
  stage            uint8: STAGE_RAW (rejected by the motion statistics), STAGE_GMS (by the estimator), STAGE_INLIER
  probability      float32, 0..1, that the match is right; 0: rejected, or no model
  reference_sigma, current_sigma  float32, pixels: standard deviation of either coordinate of a right match; 0: unknown
Motion:
  status           gms_ransac.Status
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
camera_misfit: contradiction between matches and camera model; 1: exceeded by chance in one pair of a hundred
Seconds: time_detect, time_match, time_gms, time_ransac)";

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
  type.def_readonly("matches_gms", &Pair::matches_gms);
  type.def_readonly("inliers", &Pair::inliers);
  const auto define = [&type](const char* name, auto getter) { type.def_property_readonly(name, getter); };
  define("reference_points", [](const Pair& pair) { return viewOf<float, 2>(pair.reference_points); });
  define("current_points", [](const Pair& pair) { return viewOf<float, 2>(pair.current_points); });
  define("confidence", [](const Pair& pair) { return viewOf<float, 1>(pair.confidence); });
  define("distance", [](const Pair& pair) { return viewOf<uint16_t, 1>(pair.distance); });
  define("stage", [](const Pair& pair) { return viewOf<uint8_t, 1>(pair.stage); });
  define("probability", [](const Pair& pair) { return viewOf<float, 1>(pair.probability); });
  define("reference_sigma", [](const Pair& pair) { return viewOf<float, 1>(pair.reference_sigma); });
  define("current_sigma", [](const Pair& pair) { return viewOf<float, 1>(pair.current_sigma); });
  define("model", [](const Pair& pair) -> const Eigen::Matrix3d& { return pair.robust.model; });
  define("matches_raw", [](const Pair& pair) { return pair.matches.size(); });
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
                     "distortion_model: '' or 'plumb_bob', 'rational_polynomial', 'equidistant' (fisheye).")
      .def(py::init(&makeCamera), py::arg("width"), py::arg("height"), py::arg("K") = py::none(),
           py::arg("D") = py::tuple(), py::arg("distortion_model") = "");
  py::class_<Filter>(m, "MatchFilter", filterText().c_str())
      .def(py::init<const Camera*, const py::kwargs&>(), py::arg("camera") = py::none())
      .def("process", &Filter::process, py::arg("image"), py::arg("mask") = py::none(), py::arg("stamp") = py::none(),
           "Returns the MatchResult of the last image and this one; status FIRST_FRAME if there was none.\n\n"
           "image: uint8, height x width (grey) or height x width x 3 (blue, green, red, as cv2.imread reads it).\n"
           "mask: uint8 or bool, height x width; no keypoint where it is zero.\n"
           "stamp: seconds, of the middle row; needed with rolling_shutter_readout.\n\n"
           "Other Python threads run meanwhile; calls to one filter wait for each other.")
      .def_property_readonly("options", &Filter::options, "dict: every option by name");
  m.def(
      "match",
      [](const Bytes& image0, const Bytes& image1, const Camera* camera, const py::kwargs& options) {
        Filter filter(camera, options);
        filter.process(image0, std::nullopt, std::nullopt);
        return filter.process(image1, std::nullopt, std::nullopt);
      },
      py::arg("image0"), py::arg("image1"), py::arg("camera") = py::none(),
      R"(match(image0, image1, camera=None, **options)

Returns the MatchResult of the reference image0 and the current image1. Images and options as of MatchFilter.)");
  m.def(
      "estimate",
      [](const Numbers& points0, const Numbers& points1, const Camera& camera, const py::kwargs& options) {
        return Filter(&camera, options).estimate(points0, points1);
      },
      py::arg("points0"), py::arg("points1"), py::arg("camera"),
      R"(estimate(points0, points1, camera, **options)

Returns the MatchResult of given matches. points0, points1: N x 2, pixels of the reference and the current image, a row
for each match, most trusted first: methods that sample the best matches first keep this order. Options as of
MatchFilter.)");
}
