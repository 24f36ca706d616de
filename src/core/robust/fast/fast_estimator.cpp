#include "robust/fast/fast_estimator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "pose/pose_judge.h"
#include "pose/pose_recovery.h"
#include "robust/acceptance.h"
#include "robust/fast/fundamental_model.h"
#include "robust/fast/homography_model.h"
#include "robust/fast/motion_starts.h"
#include "robust/fast/plane_motion.h"
#include "robust/fast/point_columns.h"
#include "robust/fast/pose_model.h"
#include "robust/fast/search.h"
#include "robust/ordering.h"
#include "robust/two_view_problem.h"

namespace gms_ransac {

namespace {

// Noise of a keypoint grows with its pyramid level as scale_factor^(kNoiseExponent * octave). The full 1 of a position
// rounded on its own level overstates it (doc/estimator.md).
constexpr double kNoiseExponent = 0.5;

constexpr Loss kFinalLoss = {4, 1};
constexpr int kFinalIterations = 10;

class FastEstimator : public RobustEstimator {
 public:
  explicit FastEstimator(const RobustOptions& options)
      : options_(options), kernels_(residualKernels(options.simd)), pose_recovery_(options.simd), judge_(kernels_) {}

  void estimate(const PointPairs& pairs, const Camera& camera, RobustResult& result) override;
  void reset() override { has_previous_ = false; }
  void setSeed(uint64_t seed) override { options_.seed = seed; }

 private:
  void arrange(const PointPairs& pairs, const Camera& camera, ModelType type);
  /// The model in working coordinates; false when there is none.
  template <class Model>
  bool findMatrix(RobustResult& result, Eigen::Matrix3d& matrix);
  bool findPose(RobustResult& result);

  RobustOptions options_;
  const ResidualKernels& kernels_;
  Ordering ordering_;
  TwoViewProblem problem_;
  StratifiedSampler sampler_;
  Acceptance acceptance_;
  PoseRecovery pose_recovery_;
  PoseJudge judge_;

  // The pair at hand. Columns hold the matches in an order unrelated to the image's, so that any part of them is a
  // random part; `place_` is the column of each match.
  std::vector<int> arrangement_, place_;
  std::vector<int> confidence_order_, order_;  // most confident first: matches, and their columns
  std::vector<int32_t> cells_;
  OrderedPoints arranged_;
  PointColumns points_;
  std::vector<float> residuals_;
  std::vector<TwoViewPose> starts_;
  std::vector<OtherMotion> others_;
  TwoViewPose pose_;          // most likely; gives the model and the direction of translation
  Eigen::Matrix3d rotation_;  // most probable under the prior of the parallax

  bool has_previous_ = false;
  TwoViewPose previous_;
};

void FastEstimator::arrange(const PointPairs& pairs, const Camera& camera, ModelType type) {
  const int n = pairs.size();
  strideOver(n, arrangement_);
  problem_.set(pairs, camera, type, options_.inlierThreshold());
  problem_.arrange(arrangement_, arranged_);
  points_.resize(n);
  std::copy(arranged_.x_reference.begin(), arranged_.x_reference.end(), points_.x1());
  std::copy(arranged_.y_reference.begin(), arranged_.y_reference.end(), points_.y1());
  std::copy(arranged_.x_current.begin(), arranged_.x_current.end(), points_.x2());
  std::copy(arranged_.y_current.begin(), arranged_.y_current.end(), points_.y2());

  std::array<double, 256> variance;  // by octave, in squared thresholds
  for (size_t octave = 0; octave < variance.size(); ++octave) {
    variance[octave] = std::pow(static_cast<double>(pairs.scale_factor),
                                2 * kNoiseExponent * std::min<double>(static_cast<double>(octave), 31));
  }
  place_.resize(static_cast<size_t>(n));
  cells_.resize(static_cast<size_t>(n));
  const double squared_threshold = problem_.threshold() * problem_.threshold();
  for (int p = 0; p < n; ++p) {
    const auto match = static_cast<size_t>(arrangement_[static_cast<size_t>(p)]);
    place_[match] = p;
    cells_[static_cast<size_t>(p)] =
        spreadCell({pairs.x_reference[match], pairs.y_reference[match]}, pairs.image_reference);
    const double scale = 0.5 * (variance[pairs.octave_reference[match]] + variance[pairs.octave_current[match]]);
    points_.weight()[p] = static_cast<float>(1 / (squared_threshold * scale));
  }
  residuals_.resize(static_cast<size_t>(points_.view().size));

  ordering_.sort(pairs, QualityKey::kRatio, confidence_order_);
  order_.resize(static_cast<size_t>(n));
  for (size_t k = 0; k < order_.size(); ++k) order_[k] = place_[static_cast<size_t>(confidence_order_[k])];
  sampler_.begin(order_, cells_, problem_.sampleSize());
}

template <class Model>
bool FastEstimator::findMatrix(RobustResult& result, Eigen::Matrix3d& matrix) {
  const Model model(kernels_, points_.view());
  Search<Model> search(model, points_.count(), result);
  search.run(options_, order_, sampler_, residuals_);
  if (!search.found()) return false;
  matrix = search.best();
  result.point_evaluations +=
      static_cast<int64_t>(points_.count()) * model.refine(kFinalLoss, kFinalIterations, matrix);
  return true;
}

bool FastEstimator::findPose(RobustResult& result) {
  const PoseModel model(kernels_, points_.view(), kParallaxPrior);
  Search<PoseModel> search(model, points_.count(), result);
  if (has_previous_) search.offer(previous_);
  findMotionStarts(kernels_, points_.view(), starts_, result.point_evaluations);
  others_.clear();
  for (const TwoViewPose& start : starts_) {
    search.offer(start);
    others_.push_back({start});
  }
  search.run(options_, order_, sampler_, residuals_);
  if (!search.found()) return false;
  TwoViewPose other;
  if (findOtherPlaneMotion(points_.view(), search.best(), residuals_, other, result.point_evaluations)) {
    others_.push_back({search.best(), true});
    float cost;
    other = model.withBetterSign(other, cost, result.point_evaluations);
    others_.push_back({other, true});
    search.offer(other);
  }
  pose_ = search.best();
  int passes = model.refine(kFinalLoss, kFinalIterations, pose_, kEnough);
  rotation_ = pose_.R;
  passes += PoseModel(kernels_, points_.view()).refine(kFinalLoss, kFinalIterations, pose_, kEnough);
  result.point_evaluations += static_cast<int64_t>(points_.count()) * passes;
  return true;
}

void FastEstimator::estimate(const PointPairs& pairs, const Camera& camera, RobustResult& result) {
  result.clear();
  const bool essential = options_.model == ModelType::kEssential && camera.calibrated();
  result.model_type = options_.model == ModelType::kEssential && !essential ? ModelType::kFundamental : options_.model;
  result.inlier.assign(static_cast<size_t>(pairs.size()), 0);
  arrange(pairs, camera, result.model_type);
  if (pairs.size() < problem_.sampleSize()) return;

  Eigen::Matrix3d matrix;
  bool found = false;
  if (essential) {
    found = findPose(result);
    matrix = pose_.essential();
  } else if (result.model_type == ModelType::kFundamental) {
    found = findMatrix<FundamentalModel>(result, matrix);
  } else {
    found = findMatrix<HomographyModel>(result, matrix);
  }
  has_previous_ = false;
  if (!found) return;
  result.model = problem_.inResultUnits(matrix);
  markFinalInliers(pairs, camera, options_.inlierThreshold(), result);
  result.model_found =
      acceptance_.accepts(pairs, problem_.sampleSize(), options_.inlierThreshold(), result, &confidence_order_);
  if (!result.model_found) return result.refuse();
  if (essential) {
    // The direction in the reference camera is that of the optimum.
    const TwoViewPose pose = {rotation_, rotation_ * pose_.R.transpose() * pose_.t};
    judge_.judge({points_.view(), &cells_, camera.meanFocalLength()}, pose_, pose, others_, result);
    previous_ = pose_;
    has_previous_ = true;
  } else {
    pose_recovery_.recover(pairs, camera, options_.inlierThreshold(), true, result);
  }
}

}  // namespace

std::unique_ptr<RobustEstimator> makeFastEstimator(const RobustOptions& options) {
  return std::make_unique<FastEstimator>(options);
}

}  // namespace gms_ransac
