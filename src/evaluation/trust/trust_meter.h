// Runs the methods over a piece of work and holds every answer against the truth.
#pragma once

#include <vector>

#include "trust/trust_plan.h"
#include "trust/trust_row.h"

namespace gms_ransac {

/// The rows of every pair and method of a unit: pairs in order, methods in that of the plan. Depends on
/// nothing but its arguments, so units may be measured in any order and side by side. Throws DatasetError when an image
/// cannot be read.
std::vector<TrustRow> measureTrust(const TrustPlan& plan, const TrustUnit& unit);

}  // namespace gms_ransac
