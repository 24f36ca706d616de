#include "tables/paper_figures.h"

#include <algorithm>
#include <iterator>
#include <map>

namespace gms_ransac {

namespace {

constexpr const char* kRatios[] = {"1/5", "1/4", "1/3", "1/2", "2/3", "3/4", "4/5"};

struct PaperRow {
  int matches[7];
  double milliseconds[7];
};

const std::map<int, PaperRow> kRatioTables = {
    {1000, {{47, 47, 51, 45, 47, 40, 52}, {1.06, 1.38, 1.44, 2.11, 2.52, 3.48, 2.05}}},
    {2000, {{92, 128, 85, 126, 105, 125, 116}, {3.13, 4.23, 4.31, 2.58, 2.67, 4.06, 4.23}}},
    {3000, {{111, 128, 133, 138, 146, 136, 146}, {5.34, 4.18, 7.95, 7.31, 6.39, 8.29, 5.89}}},
    {4000, {{124, 148, 152, 154, 160, 163, 154}, {6.91, 5.5, 7.13, 7.43, 9.23, 8.5, 7.69}}},
    {5000, {{132, 152, 171, 160, 168, 175, 170}, {8.03, 8.34, 7.68, 7.5, 8.24, 10.91, 12.38}}},
    {6000, {{199, 190, 156, 195, 184, 203, 209}, {7.01, 9.56, 7.7, 7.55, 8.17, 8.81, 8.62}}},
    {7000, {{159, 217, 210, 213, 219, 222, 233}, {4.2, 6.33, 8.22, 7.63, 8.58, 10.16, 8.54}}},
    {8000, {{179, 264, 234, 229, 246, 230, 215}, {4.64, 7.46, 7.79, 7.73, 8.65, 10.01, 10.5}}},
    {9000, {{231, 234, 252, 237, 270, 242, 260}, {4.54, 8.96, 7.91, 7.98, 9.28, 11.41, 13.46}}},
    {10000, {{262, 284, 264, 274, 285, 272, 268}, {4.23, 9.87, 9.46, 8.93, 10.97, 8.62, 12.76}}},
};

const std::map<int, PaperPreset> kPresetTable = {
    {1000, {45, 2.11}},  {2000, {126, 2.58}}, {2500, {131, 4.31}}, {3000, {138, 7.31}},
    {3500, {144, 7.37}}, {4000, {154, 7.43}}, {5000, {160, 7.50}}, {6000, {195, 7.55}},
    {7000, {213, 7.63}}, {8000, {229, 7.73}}, {9000, {237, 7.98}}, {10000, {274, 8.93}},
};

}  // namespace

const PaperPreset* paperPreset(int preset) {
  const auto found = kPresetTable.find(preset);
  return found == kPresetTable.end() ? nullptr : &found->second;
}

PaperPreset paperRatio(int preset, const std::string& ratio) {
  const auto row = kRatioTables.find(preset);
  const auto column = std::find(std::begin(kRatios), std::end(kRatios), ratio) - std::begin(kRatios);
  if (row == kRatioTables.end() || column == std::end(kRatios) - std::begin(kRatios)) return {};
  return {static_cast<double>(row->second.matches[column]), row->second.milliseconds[column]};
}

std::string paperReduction(const std::string& baseline) {
  if (baseline == "gms_ransac") return "37.19 / 28.32 / 30.48; 32.00";
  if (baseline == "lan") return "18.26 / 24.22 / 6.29; 16.26";
  return "-";
}

}  // namespace gms_ransac
