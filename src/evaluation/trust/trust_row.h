// One answer held against the truth and against what the answer says of itself.
#pragma once

#include <array>
#include <limits>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "gms_ransac/match_filter.h"
#include "trust/match_label.h"

namespace gms_ransac {

/// From here on an answer is wrong, degrees.
struct ErrorLimits {
  double rotation, direction;
};
constexpr ErrorLimits kExactLimits = {1, 20};  ///< where the truth is exact
constexpr ErrorLimits kRealLimits = {3, 30};   ///< where it has noise of its own

/// The true motion of a pair, current_in_reference.
struct PoseTruth {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  TruthNoise noise;
  ClockStep clock_step;
  ErrorLimits limits = kRealLimits;
};

/// e^T S^-1 e over the dimension: 1 on average where S is the covariance of e. NaN where S has no inverse.
double normalizedSquare(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance);

/// The two sides of the tangent plane of a direction: error of `truth` against `estimate` in it, radians, and the
/// part of a covariance of the estimate that lies in it.
struct TangentError {
  Eigen::Vector2d error;
  Eigen::Matrix2d covariance;
};
TangentError tangentError(const Eigen::Vector3d& estimate, const Eigen::Vector3d& truth,
                          const Eigen::Matrix3d& covariance);

/// Matches by their probability, in ten bins of equal width.
struct Reliability {
  struct Bin {
    int count = 0;
    double probability = 0;  ///< sum
    int right = 0;
  };
  static constexpr int kBins = 10;
  std::array<Bin, kBins> bins;

  void add(double probability, bool right);
};

struct TrustContext {
  std::string kind;  ///< "real", "rendered" or "drawn"
  std::string set, pair, method;
  int gap = 0;  ///< 0: drawn, or a listed pair
  Status status = Status::kOk;
  int survivors = 0;
};

/// A line of pairs.csv; numbers that do not apply are NaN.
struct TrustRow {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  std::string kind, set, pair, method, status;
  int gap = 0, survivors = 0, inliers = 0;
  bool has_truth = false, moved = false, right = false, wrong = false;
  double baseline_m = kNone;
  double rotation_error_deg = kNone, direction_error_deg = kNone;
  double rx_deg = kNone, ry_deg = kNone, rz_deg = kNone;  ///< rotation of the estimate less that of the truth
  double rotation_sigma_deg = kNone, direction_sigma_deg = kNone, uncertainty_deg = kNone;  ///< the sum
  double nees_rotation = kNone, nees_direction = kNone;
  double parallax_px = kNone, sigma_px = kNone;
  std::vector<double> covariance;  ///< 6 x 6; empty without an answer
  Reliability reliability;
};

/// The row of an answer; `truth` is null where there is none.
TrustRow makeTrustRow(const TrustContext& context, const RobustResult& result, const PoseTruth* truth,
                      const Reliability& reliability);

}  // namespace gms_ransac
