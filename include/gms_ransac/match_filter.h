// The pipeline: consecutive images in, filtered correspondences and relative pose out.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gms_ransac/camera.h"
#include "gms_ransac/distance_consistency.h"
#include "gms_ransac/feature_extractor.h"
#include "gms_ransac/guided_search.h"
#include "gms_ransac/hamming_matcher.h"
#include "gms_ransac/method.h"
#include "gms_ransac/motion_prediction.h"
#include "gms_ransac/motion_statistics.h"
#include "gms_ransac/robust_estimator.h"
#include "gms_ransac/rotation_prior.h"
#include "gms_ransac/time_limit.h"

namespace gms_ransac {

class SurvivorSelector;
class TimeBudget;

/// Outcome of one pair of images. Values are those of gms_ransac/MatchStats, which has more for the node.
enum class Status : uint8_t {
  kOk = 0,
  kFirstFrame = 1,       ///< nothing to compare with yet
  kTooFewKeypoints = 2,  ///< fewer than kMinimumMatches in one of the images
  kTooFewMatches = 3,    ///< fewer than kMinimumMatches raw matches
  kGmsRejected = 4,      ///< fewer than kMinimumMatches left by the filter
  kRansacFailed = 5,     ///< no model that explains at least kMinimumMatches of the matches
  kLowParallax = 6,      ///< rotation is good, the direction of translation is not observable
  kUncalibrated = 7      ///< correspondences only, no pose
};
std::string toString(Status status);  ///< "OK", "FIRST_FRAME", ...

constexpr int kMinimumMatches = 8;

/// How far a match got.
enum class MatchStage : uint8_t { kRaw = 0, kGms = 1, kInlier = 2 };

struct MatchFilterOptions {
  std::string method = "lo_prosac";
  FeatureExtractorOptions extractor;
  MotionStatisticsOptions motion_statistics;
  RobustOptions robust;
  int matcher_threads = 1;
  SearchMode search = SearchMode::kFull;  ///< of methods that want mutual neighbours always full
  DistanceReading distance_reading = DistanceReading::kDisplacement;  ///< gms_dist_ransac
  /// Of the filter's matches with one current point only the best goes on to the estimator: the likeliest where the
  /// filter weighs evidence, else that of least descriptor distance; the first of equals. Off: as in the papers, where
  /// several reference points may share a current one.
  bool one_to_one = true;
  bool lan_mutual = true;  ///< lan: match in both directions; false: feed it the same matches as the other methods
  /// lan: of the final check; not set: the first times the square root of the share kept.
  std::optional<double> lan_second_threshold_factor;

  /// For an image from extraction to judgement: where it would take more, fewer features are asked for than the options
  /// say, fewer samples drawn and fewer steps refined, so that 99 % of the images keep it. 0: no limit, and the results
  /// do not depend on the machine.
  double max_milliseconds = 0;

  void validate() const;

  /// The paper's method as it is written: cv::ORB, all matches of GMS sorted by their bare score, ratio 1/2, the model
  /// as it was found. cfg/paper.yaml says the same to the node.
  static MatchFilterOptions paper();
};

/// One image and what was extracted from it.
struct Frame {
  Features features;
  double detect_seconds = 0;
  double seconds_before = 0;  ///< set by the caller: what it took for the image itself; counts towards max_milliseconds
  int features_asked = 0;     ///< fewer than in the options where max_milliseconds wants it
  std::optional<double> stamp;  ///< seconds, of the middle row; not set: not known
};

struct StageTimes {
  double detect = 0, match = 0, gms = 0, ransac = 0;  ///< seconds; detect is the current image alone
  double total() const { return detect + match + gms + ransac; }
};

/// What the filter hands to the estimator: the matches that it keeps.
struct Survivors {
  std::vector<int> match;  ///< indices into the raw matches, ascending
  PointPairs pairs;        ///< beside `match`

  int size() const { return static_cast<int>(match.size()); }
};

/// The outcome that an estimate with this camera stands for, from kOk, kRansacFailed, kLowParallax, kUncalibrated.
Status statusOf(const RobustResult& result, const Camera& camera);

/// The result of one pair. `matches` holds every raw match; the columns beside it have one entry for each.
struct MatchResult {
  Status status = Status::kFirstFrame;
  int keypoints_reference = 0, keypoints_current = 0;
  std::vector<Match> matches;
  std::vector<MatchStage> stage;
  /// 0..1: motion-statistics score over the largest score of the pair; 1 where the method has no such scores.
  std::vector<float> confidence;
  /// 0..1, that the match is right (RobustResult::probability); 0 where that was not weighed: the filter rejected the
  /// match, or there is no model.
  std::vector<float> probability;
  int matches_gms = 0, inliers = 0;
  Survivors survivors;
  RobustResult robust;  ///< columns are beside those of `survivors`; `stage` and `probability` are for the raw matches
  StageTimes times;

  /// Empties the result but keeps its storage.
  void clear(Status new_status);
};

/// The line: extract -> match -> filter -> estimate -> judge. Owns its stages, which keep nothing but scratch storage
/// from pair to pair (a method may also remember the last motion), and the previous frame. Not thread-safe, except that
/// `extract` may run on another thread than `filter`: they share no state.
class MatchFilter {
 public:
  explicit MatchFilter(const MatchFilterOptions& options = {});
  ~MatchFilter();
  MatchFilter(MatchFilter&&) noexcept;
  MatchFilter& operator=(MatchFilter&&) noexcept;

  const MatchFilterOptions& options() const { return options_; }
  /// An uncalibrated camera is fine: correspondences without pose.
  void setCamera(const Camera& camera);
  const Camera& camera() const { return camera_; }

  /// The whole line for the next image of a sequence (CV_8UC1): extracts it once, compares it with the one before,
  /// keeps it for the next. `mask` as in FeatureExtractor::extract: keypoints are not taken where it is zero. `stamp`
  /// is needed with RobustOptions::rolling_shutter_readout alone. The result is valid until the next call.
  const MatchResult& process(const cv::Mat& image, const cv::Mat& mask = cv::Mat(),
                             std::optional<double> stamp = std::nullopt);
  /// Forgets the previous frame: the next image is a first one.
  void reset();

  /// The two halves of `process`, for callers that choose the pairs themselves.
  void extract(const cv::Mat& image, Frame& frame, const cv::Mat& mask = cv::Mat(),
               std::optional<double> stamp = std::nullopt);
  /// `prior`: how the camera turned, as another sensor says; null: none does. Guided searches look where it turns the
  /// points if the first matches say the same. A wrong one costs time, not accuracy.
  void filter(const Frame& reference, const Frame& current, MatchResult& result, const RotationPrior* prior = nullptr);

  /// The end of the line alone, estimate -> judge, on the survivors in `result`, which `filter` filled for the same
  /// frames. With `setSeed` and `reset` for statistics over seeds, where matching again would cost most of the time.
  void estimate(const Frame& reference, const Frame& current, MatchResult& result);
  void setSeed(uint64_t seed);
  /// For tests: the clock of `times` and of max_milliseconds, whose experience it empties. Not beside another call.
  void setClock(const Clock& clock);

 private:
  /// From match on; ends with the first stage that leaves too few.
  Status compare(const Frame& reference, const Frame& current, MatchResult& result);
  Status estimate(const Features& reference, const Features& current, MatchResult& result);
  /// Tells the budget what the pair took.
  void learn(const Frame& reference, const Frame& current, const MatchResult& result);

  MatchFilterOptions options_;
  Clock clock_;
  Camera camera_;

  // The stages. A method has two, or three: filter, estimate (which ends with the judgement), post-filter.
  std::unique_ptr<Method> method_;
  std::unique_ptr<FeatureExtractor> extractor_;
  HammingMatcher matcher_;
  std::optional<GuidedSearch> guided_search_;  ///< where it is wanted, in place of the matcher
  MotionPrediction turn_;                      ///< what it is told of a prior
  std::unique_ptr<SurvivorSelector> selector_;

  std::unique_ptr<TimeBudget> budget_;  ///< null: none
  Frame reference_, current_;
  bool have_reference_ = false;
  MatchResult result_;
};

}  // namespace gms_ransac
