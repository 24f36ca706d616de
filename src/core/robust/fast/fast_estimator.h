// The method `fast`: confidence-ordered, spread samples, SIMD scoring, local optimisation and a final refinement.
#pragma once

#include <memory>
#include <vector>

#include "gms_ransac/robust_estimator.h"

namespace gms_ransac {

std::unique_ptr<RobustEstimator> makeFastEstimator(const RobustOptions& options);

}  // namespace gms_ransac
