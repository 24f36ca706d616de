// One answer held against the truth and against what the answer says of itself.
#pragma once

#include <array>
#include <string>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

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
  ErrorLimits limits = kRealLimits;
};

/// Rotation vector of `to` relative to `from`: to = exp(vector) from. Radians.
Eigen::Vector3d rotationVector(const Eigen::Matrix3d& from, const Eigen::Matrix3d& to);

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

/// A value for each column of pairs.csv; numbers that do not apply are null.
using TrustRow = nlohmann::json;

struct TrustContext {
  const char* kind;  ///< "real", "rendered" or "drawn"
  std::string set, pair, method;
  int gap = 0;  ///< 0: drawn, or a listed pair
  Status status = Status::kOk;
  int survivors = 0;
};

/// The row of an answer; `truth` is null where there is none.
TrustRow makeTrustRow(const TrustContext& context, const RobustResult& result, const PoseTruth* truth,
                      const Reliability& reliability);

/// Header and a line for each row, cells of several numbers separated by blanks.
std::string trustCsv(const std::vector<TrustRow>& rows);

}  // namespace gms_ransac
