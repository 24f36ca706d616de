// Plans and measurements as text: what stands in plan.json and in a line of measurements.jsonl.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tables/tables_measure.h"

namespace gms_ransac {

/// Everything that decides the figures, for telling whether two folders of measurements belong together.
std::string planText(const TablesPlan& plan);
/// The same plan as planText writes it, from however it is laid out; none when it is not JSON.
std::optional<std::string> planFrom(const std::string& text);
/// The same plan with a line for each key.
std::string planForReading(const std::string& plan);

std::string unitLine(int unit, const std::vector<Measurement>& measurements);
/// The number of the line's unit; none when the line was cut off.
std::optional<int> unitOf(const std::string& line);
/// Throws std::exception when a key is missing.
std::vector<Measurement> measurementsOf(const std::string& line);

}  // namespace gms_ransac
