// The pipeline: consecutive images in, filtered correspondences and relative pose out.
#pragma once

#include <memory>
#include <optional>
#include <utility>

#include <opencv2/core/mat.hpp>

#include "gms_ransac/camera.h"
#include "gms_ransac/match_filter_options.h"
#include "gms_ransac/match_result.h"
#include "gms_ransac/past.h"

namespace gms_ransac {

struct Frame {
  Features features;
  cv::Mat image;  ///< that they were extracted from, a copy; empty: they are the caller's, and no points are aligned
  double detect_seconds = 0;
  double seconds_before = 0;  ///< set by the caller: what it took for the image itself; counts towards max_milliseconds
  int features_asked = 0;     ///< fewer than in the options where max_milliseconds wants it
  std::optional<double> stamp;  ///< seconds, of the middle row; not set: not known

  Frame() = default;
  /// Takes the caller's features, which need no extraction.
  explicit Frame(Features given, std::optional<double> when = std::nullopt)
      : features(std::move(given)), features_asked(features.size()), stamp(when) {}
};

/// extract -> match -> filter -> estimate -> judge. Not thread-safe, except that `extract` and `filter` may run at the
/// same time. Images of another size than the camera's are refused with std::invalid_argument.
class MatchFilter {
 public:
  explicit MatchFilter(const MatchFilterOptions& options = {});
  ~MatchFilter();
  MatchFilter(MatchFilter&&) noexcept;
  MatchFilter& operator=(MatchFilter&&) noexcept;

  const MatchFilterOptions& options() const;
  /// An uncalibrated camera gives correspondences without a pose.
  void setCamera(const Camera& camera);
  const Camera& camera() const;

  /// Compares the next image of a sequence (CV_8UC1) with the one before. `mask` as in FeatureExtractor::extract;
  /// `stamp` is needed with RobustOptions::rolling_shutter_readout; `prior` as in `filter`. The result is valid until
  /// the next call. If it throws, the sequence goes on from the image before.
  const MatchResult& process(const cv::Mat& image, const cv::Mat& mask = cv::Mat(),
                             std::optional<double> stamp = std::nullopt, const RotationPrior* prior = nullptr);
  /// The same with features of the caller's: any detector, binary descriptors of any length or floats. They replace the
  /// extraction; descriptors that are not of 32 bytes are compared with all others, and only mutual nearest neighbours
  /// match. Descriptors of another kind than those before begin a new sequence. Throws std::invalid_argument as
  /// Features::validate does.
  const MatchResult& process(Features features, std::optional<double> stamp = std::nullopt,
                             const RotationPrior* prior = nullptr);
  /// The images that `process` compared last, with the keypoints that Match::reference and Match::current number. After
  /// a first image the reference has none.
  const Frame& reference() const { return reference_; }
  const Frame& current() const { return current_; }
  /// The next image is the first of a new sequence, of the same camera.
  void reset();

  /// The two halves of `process`, for callers that choose the pairs themselves.
  void extract(const cv::Mat& image, Frame& frame, const cv::Mat& mask = cv::Mat(),
               std::optional<double> stamp = std::nullopt);
  /// `prior`: rotation from another sensor, or null. Guided searches use it if the first matches agree. A wrong one
  /// costs time, not accuracy. `past`: of the stream in which the pair follows on others; null: the pair stands alone.
  /// Frames may hold features of the caller's, which pass Features::validate. Throws std::invalid_argument if the
  /// descriptors of the two frames are of different kinds.
  void filter(const Frame& reference, const Frame& current, MatchResult& result, const RotationPrior* prior = nullptr,
              Past* past = nullptr);

  /// Goes on with what `before` has learnt of the time that images take, unless an option differs on which it depends:
  /// all but those of the estimator do.
  void continueBudget(const MatchFilter& before);

 private:
  friend struct MatchFilterHooks;  // for tests and statistics
  struct Stages;
  /// Storage for the next image of the sequence; the last one becomes the reference.
  Frame& nextFrame();
  /// Compares `current_` with the frame before, if there is one.
  const MatchResult& compareWithLast(const RotationPrior* prior);
  void requireCameraSize(const cv::Size& image) const;

  std::unique_ptr<Stages> stages_;
  Frame reference_, current_;
  bool have_reference_ = false, have_current_ = false;
  Past past_;
  MatchResult result_;
};

}  // namespace gms_ransac
