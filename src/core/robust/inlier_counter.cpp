#include "robust/inlier_counter.h"

#include <algorithm>
#include <limits>

#include <Eigen/LU>

#include "robust/fast/fundamental_model.h"
#include "robust/fast/homography_model.h"

namespace gms_ransac {

namespace {

struct RowMajorFloats {
  float values[9];
  explicit RowMajorFloats(const Eigen::Matrix3d& m) {
    Eigen::Map<Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(values, 3, 3) = m.cast<float>();
  }
};

}  // namespace

void InlierCounter::set(const TwoViewProblem& problem, const OrderedPoints& points, int begin, int end) {
  type_ = problem.type();
  columns_.resize(end - begin);
  std::copy(points.x_reference.begin() + begin, points.x_reference.begin() + end, columns_.x1());
  std::copy(points.y_reference.begin() + begin, points.y_reference.begin() + end, columns_.y1());
  std::copy(points.x_current.begin() + begin, points.x_current.begin() + end, columns_.x2());
  std::copy(points.y_current.begin() + begin, points.y_current.begin() + end, columns_.y2());
  const double threshold = problem.threshold();
  std::fill_n(columns_.weight(), end - begin, static_cast<float>(1 / (threshold * threshold)));
}

Score InlierCounter::score(const Eigen::Matrix3d& model) const {
  constexpr float kNoBound = std::numeric_limits<float>::max();
  Score score;
  if (columns_.count() == 0) return score;
  const RowMajorFloats M(model);
  if (type_ == ModelType::kHomography) {
    const RowMajorFloats G(model.inverse());
    kernels_->scoreHomography(columns_.view(), M.values, G.values, kNoBound, score);
  } else {
    kernels_->scoreEpipolar(columns_.view(), M.values, kNoBound, score);
  }
  return score;
}

void InlierCounter::mark(const Eigen::Matrix3d& model, std::vector<uint8_t>& inlier) {
  const RowMajorFloats M(model);
  residuals_.resize(static_cast<size_t>(columns_.view().size));
  if (type_ == ModelType::kHomography) {
    kernels_->transferResiduals(columns_.view(), M.values, residuals_.data());
  } else {
    kernels_->epipolarResiduals(columns_.view(), M.values, residuals_.data());
  }
  inlier.resize(static_cast<size_t>(columns_.count()));
  for (size_t i = 0; i < inlier.size(); ++i) inlier[i] = residuals_[i] < 1;
}

int InlierCounter::refine(Eigen::Matrix3d& model) const {
  if (type_ == ModelType::kHomography) {
    return HomographyModel(*kernels_, columns_.view()).refine(kRefinementLoss, kRefinementIterations, model);
  }
  return FundamentalModel(*kernels_, columns_.view()).refine(kRefinementLoss, kRefinementIterations, model);
}

}  // namespace gms_ransac
