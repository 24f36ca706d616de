#include "gms_ransac/robust_estimator.h"

#include <algorithm>
#include <cmath>

#include "validation.h"

namespace gms_ransac {

namespace {

/// Also for a position that is not a number, which lands in the first cell.
int spreadColumn(float position, int length) {
  const float column = position * static_cast<float>(kSpreadGridSide) / static_cast<float>(std::max(1, length));
  return static_cast<int>(std::min(std::max(0.f, column), static_cast<float>(kSpreadGridSide - 1)));
}

}  // namespace

int32_t spreadCell(const cv::Point2f& pixel, const cv::Size& image) {
  return spreadColumn(pixel.y, image.height) * kSpreadGridSide + spreadColumn(pixel.x, image.width);
}

double RobustOptions::inlierThreshold() const {
  return inlier_threshold_px.value_or(model == ModelType::kHomography ? 3.0 : 1.0);
}

Effort& Effort::operator+=(const Effort& other) {
  hypotheses += other.hypotheses;
  models_scored += other.models_scored;
  point_evaluations += other.point_evaluations;
  search_seconds += other.search_seconds;
  search_cut = search_cut || other.search_cut;
  refinement_cut = refinement_cut || other.refinement_cut;
  return *this;
}

void RobustOptions::validate() const { requireInRanges(*this); }

double RobustResult::sigma(int octave, float scale_factor) const {
  return sigma_px * std::pow(static_cast<double>(scale_factor), noise_exponent * octave);
}

void RobustResult::clear() {
  std::vector<uint8_t> inliers;
  std::vector<float> probabilities;
  inliers.swap(inlier);
  probabilities.swap(probability);
  inliers.clear();
  probabilities.clear();
  *this = RobustResult();
  inlier.swap(inliers);
  probability.swap(probabilities);
}

void RobustResult::reject() {
  model_found = pose_found = translation_observable = false;
  doubt = DirectionDoubt::kNone;
  std::fill(inlier.begin(), inlier.end(), 0);
  inlier_count = 0;
  rms_error_px = sigma_px = camera_misfit = 0;
  camera_errors = CameraErrors();
  probability.clear();
}

}  // namespace gms_ransac
