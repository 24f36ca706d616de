// Plans and measurements of the tables as JSON, for their work folder, which scripts/tables_report.py reads.
#pragma once

#include <string>
#include <vector>

#include "tables/tables_measure.h"

namespace gms_ransac {

/// Everything that decides the figures, for telling whether two folders of measurements belong together.
std::string planText(const TablesPlan& plan);

/// A JSON array, an object each.
std::string runsText(const std::vector<Measurement>& measurements);

}  // namespace gms_ransac
