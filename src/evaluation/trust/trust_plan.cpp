#include "trust/trust_plan.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "run/experiment.h"

namespace gms_ransac {

namespace {

namespace fs = std::filesystem;

constexpr double kDegree = M_PI / 180;
/// Pairs of a unit: enough that neighbours share most of their extracted images, few enough to spread over cores and to
/// lose little to an interruption.
constexpr int kPairsOfUnit = 24;

/// The stamp of a camera of 30 Hz that nothing triggers may be of any time between two frames, seconds.
const double kFrameClock = 1 / 30. / std::sqrt(12.);

struct KindOfTruth {
  const char* word;  ///< in the set's name, in small letters
  TruthNoise noise;
};
const KindOfTruth kKinds[] = {
    {"rendered", {0, 0, 0, 0}},
    {"kitti", {0.01 * kDegree, 0.005, 0, 0.1 * kDegree}},
    {"euroc", {0.05 * kDegree, 0.001, 0, 0}},
    {"7scenes", {0.2 * kDegree, 0.01, kFrameClock, 0}},
    {"tum", {0.2 * kDegree, 0.001, kFrameClock, 0}},
    {"freiburg", {0.2 * kDegree, 0.001, kFrameClock, 0}},
};

bool isSet(const fs::path& path) {
  const auto holds = [&](const char* name) { return fs::exists(path / name); };
  return holds("rgb.txt") || holds("pairs.txt") || holds("image_0") || holds("image_l");
}

}  // namespace

std::vector<TrustUnit> trustUnits(const TrustPlan& plan, std::vector<std::string>& notes) {
  std::vector<TrustUnit> units;
  const auto add = [&](TrustUnit unit) {
    unit.index = static_cast<int>(units.size());
    units.push_back(unit);
  };
  for (size_t s = 0; s < plan.sets.size(); ++s) {
    const Dataset dataset = Dataset::open(plan.sets[s].path, plan.dataset);
    const bool listed = dataset.kind() == DatasetKind::kImagePairs;
    if (!plan.pipelines.empty()) {
      if (const auto note = unappliedOption(dataset, plan.pipelines.front())) notes.push_back(*note);
    }
    for (const int gap : listed ? std::vector<int>{0} : plan.gaps) {
      const int pairs = static_cast<int>(dataset.pairs(std::max(1, gap), plan.stride).size());
      if (pairs == 0) notes.push_back(dataset.name() + " has no images " + std::to_string(gap) + " apart");
      for (int first = 0; first < pairs; first += kPairsOfUnit) {
        add({0, static_cast<int>(s), -1, gap, first, std::min(kPairsOfUnit, pairs - first)});
      }
    }
  }
  for (size_t s = 0; s < plan.scenes.size(); ++s) add({0, -1, static_cast<int>(s), 0, 0, plan.drawn_pairs});
  return units;
}

std::vector<std::string> setsIn(const std::string& folder) {
  if (!fs::is_directory(folder) || isSet(folder)) return {folder};  // a bag, or a set
  std::vector<std::string> sets;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.is_directory() && isSet(entry.path())) sets.push_back(entry.path().string());
  }
  std::sort(sets.begin(), sets.end());
  if (sets.empty()) return {folder};  // whose opening says what is missing
  return sets;
}

std::string setName(const std::string& path) {
  const fs::path plain(path);
  std::string name = (plain.has_filename() ? plain : plain.parent_path()).filename().string();
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
  return name;
}

TruthNoise defaultTruthNoise(const std::string& path) {
  const std::string name = setName(path);
  for (const KindOfTruth& kind : kKinds) {
    if (name.find(kind.word) != std::string::npos) return kind.noise;
  }
  const bool kitti = fs::exists(fs::path(path) / "poses.txt");
  return defaultTruthNoise(kitti ? "kitti" : "tum");
}

}  // namespace gms_ransac
