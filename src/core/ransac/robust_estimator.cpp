#include "gms_ransac/robust_estimator.h"

#include <algorithm>
#include <stdexcept>

#include "ransac/ordering.h"
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
  if (threshold_px > 0) return threshold_px;
  return model == ModelType::kHomography ? 3.0 : 1.0;
}

void RobustOptions::validate() const {
  requireInRange("threshold_px", threshold_px, 0.0, 100.0);
  requireInRange("confidence", confidence, 0.01, 1 - 1e-9);
  requireInRange("max_iterations", max_iterations, 1, 10000000);
  requireInRange("ratio", ratio, 0.01, 1.0);
  requireInRange("tdd_d", tdd_d, 1, 100);
  requireInRange("subset_count", subset_count, 1, 1000);
  requireInRange("subset_fraction", subset_fraction, 0.01, 1.0);
  requireInRange("split", split, 0.01, 1.0);
  requireInRange("target_ratio", target_ratio, 0.0, 1.0);
  if (!quality.empty()) parseQualityKey(quality);
}

void RobustResult::clear() {
  std::vector<uint8_t> storage;
  storage.swap(inlier);
  storage.clear();
  *this = RobustResult();
  inlier.swap(storage);
}

void RobustResult::reject() {
  model_found = pose_found = translation_observable = ambiguous = false;
  std::fill(inlier.begin(), inlier.end(), 0);
  inlier_count = 0;
  rms_error_px = 0;
}

ModelType parseModelType(const std::string& name) {
  for (ModelType model : {ModelType::kEssential, ModelType::kFundamental, ModelType::kHomography}) {
    if (name == toString(model)) return model;
  }
  throw std::invalid_argument("unknown model '" + name + "'; known are essential, fundamental, homography");
}

std::string toString(ModelType model) {
  switch (model) {
    case ModelType::kEssential:
      return "essential";
    case ModelType::kFundamental:
      return "fundamental";
    case ModelType::kHomography:
      break;
  }
  return "homography";
}

}  // namespace gms_ransac
