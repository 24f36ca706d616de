// Plans and rows of `evaluate trust` as JSON, for their work folder, and as CSV.
#pragma once

#include <string>
#include <vector>

#include "trust/trust_plan.h"
#include "trust/trust_row.h"

namespace gms_ransac {

/// Everything that decides the figures, for telling whether two folders of measurements belong together.
std::string planText(const TrustPlan& plan);

/// A JSON array, an object each.
std::string runsText(const std::vector<TrustRow>& rows);

/// Header and a line for each row of what runsText made, cells of several numbers separated by blanks; numbers that are
/// none are empty. Throws std::exception when a key is missing.
std::string trustCsv(const std::vector<std::string>& runs);

}  // namespace gms_ransac
