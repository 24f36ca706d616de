// Plans and measurements of the tables as JSON, for their work folder.
#pragma once

#include <string>
#include <vector>

#include "tables/tables_measure.h"

namespace gms_ransac {

/// Everything that decides the figures, for telling whether two folders of measurements belong together.
std::string planText(const TablesPlan& plan);

std::string runsText(const std::vector<Measurement>& measurements);
/// From what runsText made. Throws std::exception when a key is missing.
std::vector<Measurement> measurementsOf(const std::string& runs);

}  // namespace gms_ransac
