#include "gms_ransac/robust_result.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gms_ransac {

Effort& Effort::operator+=(const Effort& other) {
  hypotheses += other.hypotheses;
  models_scored += other.models_scored;
  point_evaluations += other.point_evaluations;
  search_seconds += other.search_seconds;
  search_cut = search_cut || other.search_cut;
  refinement_cut = refinement_cut || other.refinement_cut;
  return *this;
}

void Judgement::clear() {
  Judgement empty;
  empty.probability.swap(probability);
  empty.residual.swap(residual);
  empty.probability.clear();
  empty.residual.clear();
  *this = std::move(empty);
}

double Judgement::sigma(int octave, float scale_factor) const {
  return sigma_px * std::pow(static_cast<double>(scale_factor), noise_exponent * octave);
}

void RobustResult::clear() {
  RobustResult empty;
  empty.inlier.swap(inlier);
  std::swap(empty.judgement, judgement);
  empty.inlier.clear();
  empty.judgement.clear();
  *this = std::move(empty);
}

void RobustResult::reject() {
  model_found = false;
  std::fill(inlier.begin(), inlier.end(), 0);
  inlier_count = 0;
  rms_error_px = 0;
  model.setZero();
  judgement.clear();
}

}  // namespace gms_ransac
