// `lan` (Lan et al. 2020): mutual nearest neighbours, GMS, RANSAC, and GMS once more on the inliers.
#include <cmath>

#include "methods/ransac_method.h"

namespace gms_ransac {

namespace {

class Lan : public TextbookMethod {
 public:
  explicit Lan(const MatchFilterOptions& options)
      : TextbookMethod(options),
        mutual_(options.lan_mutual),
        second_threshold_factor_(options.lan_second_threshold_factor),
        second_gms_(gms_.options()) {}

  bool wantsMutualMatches() const override { return mutual_; }

  /// A survivor's verdict stands only if the motion statistics of the inliers alone support it, too.
  void postFilter(const Features& reference, const Features& current, MatchResult& result) override {
    RobustResult& robust = result.robust;
    if (!robust.model_found) return;
    inliers_.clear();
    for (size_t row = 0; row < result.matches.size(); ++row) {
      if (robust.inlier[row]) inliers_.push_back(result.matches[row]);
    }
    // The thinned set has fewer supporters: without a lower threshold it would lose its sparse cells.
    const double kept = static_cast<double>(inliers_.size()) / static_cast<double>(result.raw.size());
    const double scaled = *gms_.options().threshold_factor * std::sqrt(kept);
    second_gms_.setThresholdFactor(second_threshold_factor_.value_or(scaled));
    second_gms_.compute(reference, current, inliers_, of_inliers_);
    size_t next = 0;
    for (uint8_t& inlier : robust.inlier) {
      if (inlier) inlier = of_inliers_.accepted[next++];
    }
    robust.inlier_count = of_inliers_.accepted_count;
  }

 private:
  bool mutual_;
  std::optional<double> second_threshold_factor_;
  MotionStatisticsFilter second_gms_;
  std::vector<Match> inliers_;
  MotionStatistics of_inliers_;
};

}  // namespace

const MethodEntry kLan = {"lan", "Lan et al. 2020",
                          "mutual nearest neighbours, GMS, uniform samples, GMS once more on the inliers", false,
                          &make<Lan>};

}  // namespace gms_ransac
