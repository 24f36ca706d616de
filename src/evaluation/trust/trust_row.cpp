#include "trust/trust_row.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "run/pipeline_options.h"
#include "run/published.h"

namespace gms_ransac {

namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();  // null in JSON, an empty cell in CSV
constexpr double kDegrees = 180 / M_PI;

/// Standard deviation along the worst axis, degrees.
template <typename Matrix>
double worstDeviation(const Matrix& covariance) {
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(covariance, Eigen::EigenvaluesOnly);
  return kDegrees * std::sqrt(std::max(0.0, solver.eigenvalues().maxCoeff()));
}

/// What the truth says of an answer.
struct Verdict {
  double baseline = kNone;
  double rotation_error = kNone, direction_error = kNone;  ///< degrees
  Vector3d signed_error{kNone, kNone, kNone};              ///< degrees, of the estimate less the truth
  double nees_rotation = kNone, nees_direction = kNone;
  bool moved = false, right = false, wrong = false;
};

Verdict judged(const RobustResult& result, Status status, const PoseTruth& truth) {
  Verdict verdict;
  verdict.baseline = truth.pose.translation().norm();
  verdict.moved = hasMoved(verdict.baseline, truth.noise);
  if (!result.pose_found) return verdict;
  const RelativePose& pose = result.pose;
  const Vector3d error = rotationVector(truth.pose.linear(), pose.R);
  verdict.signed_error = kDegrees * error;
  verdict.rotation_error = verdict.signed_error.norm();
  const Matrix3d rotation_noise = std::pow(truth.noise.rotation, 2) * Matrix3d::Identity();
  verdict.nees_rotation = normalizedSquare(error, pose.covariance.bottomRightCorner<3, 3>() + rotation_noise);

  const bool ok = status == Status::kOk;
  const bool directed = verdict.moved && !pose.t.isZero();
  if (directed) {
    const Vector3d t = pose.t.normalized();
    const TangentError tangent =
        tangentError(t, truth.pose.translation() / verdict.baseline, pose.covariance.topLeftCorner<3, 3>());
    verdict.direction_error = kDegrees * tangent.error.norm();
    const Matrix2d noise = std::pow(truth.noise.translation / verdict.baseline, 2) * Matrix2d::Identity();
    if (ok) verdict.nees_direction = normalizedSquare(tangent.error, tangent.covariance + noise);
  }
  const bool rotation_right = verdict.rotation_error <= truth.limits.rotation;
  verdict.right = rotation_right && (!verdict.moved || verdict.direction_error <= truth.limits.direction);
  // An answer that is OK claims a direction: where the camera is known to have stood there is none.
  const bool stood = !verdict.moved && truth.noise.translation == 0;
  verdict.wrong = ok && (!verdict.right || stood);
  return verdict;
}

nlohmann::json toJson(const Reliability& reliability) {
  nlohmann::json numbers = nlohmann::json::array();
  for (const Reliability::Bin& bin : reliability.bins) {
    numbers.push_back(bin.count);
    numbers.push_back(std::round(1e4 * bin.probability) / 1e4);
    numbers.push_back(bin.right);
  }
  return numbers;
}

const std::string kHeader =
    "kind,set,gap,pair,method,status,survivors,inliers,has_truth,baseline_m,moved,right,wrong,rotation_error_deg,"
    "direction_error_deg,rx_deg,ry_deg,rz_deg,rotation_sigma_deg,direction_sigma_deg,uncertainty_deg,nees_rotation,"
    "nees_direction,parallax_px,sigma_px,covariance,reliability";

std::string cell(const nlohmann::json& value) {
  if (value.is_null()) return "";
  if (value.is_boolean()) return value.get<bool>() ? "1" : "0";
  if (value.is_string()) return '"' + value.get<std::string>() + '"';
  if (!value.is_array()) return value.dump();
  std::string text;
  for (const auto& number : value) text += (text.empty() ? "" : " ") + cell(number);
  return text;
}

}  // namespace

Vector3d rotationVector(const Matrix3d& from, const Matrix3d& to) {
  const Eigen::AngleAxisd turn(Matrix3d(to * from.transpose()));
  return turn.angle() * turn.axis();
}

double normalizedSquare(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance) {
  const Eigen::LDLT<Eigen::MatrixXd> factors(covariance);
  const bool invertible = factors.info() == Eigen::Success && factors.isPositive() && factors.vectorD().minCoeff() > 0;
  if (!invertible) return kNone;
  return error.dot(factors.solve(error)) / static_cast<double>(error.size());
}

TangentError tangentError(const Vector3d& estimate, const Vector3d& truth, const Matrix3d& covariance) {
  Eigen::Matrix<double, 3, 2> basis;
  basis.col(0) = estimate.unitOrthogonal();
  basis.col(1) = estimate.cross(basis.col(0));
  const double angle = std::atan2(estimate.cross(truth).norm(), estimate.dot(truth));
  const Vector2d across = basis.transpose() * truth;
  const double length = across.norm();
  // Exactly behind, any side will do.
  const Vector2d side = length > 0 ? Vector2d(across / length) : Vector2d(1, 0);
  return {angle * side, basis.transpose() * covariance * basis};
}

void Reliability::add(double probability, bool right) {
  const double clamped = std::clamp(probability, 0.0, 1.0);
  Bin& bin = bins[std::min<size_t>(kBins - 1, static_cast<size_t>(clamped * kBins))];
  ++bin.count;
  bin.probability += clamped;
  bin.right += right;
}

TrustRow makeTrustRow(const TrustContext& context, const RobustResult& result, const PoseTruth* truth,
                      const Reliability& reliability) {
  const bool answered = context.status == Status::kOk || context.status == Status::kLowParallax;
  const Verdict verdict = truth && answered ? judged(result, context.status, *truth) : Verdict();
  const auto& covariance = result.pose.covariance;
  const auto answeredOr = [&](double value) { return answered ? value : kNone; };
  double rotation_sigma = kNone, direction_sigma = kNone;
  if (answered) rotation_sigma = worstDeviation(Matrix3d(covariance.bottomRightCorner<3, 3>()));
  if (context.status == Status::kOk) direction_sigma = worstDeviation(Matrix3d(covariance.topLeftCorner<3, 3>()));

  TrustRow row;
  row["kind"] = context.kind;
  row["set"] = context.set;
  row["gap"] = context.gap;
  row["pair"] = context.pair;
  row["method"] = context.method;
  row["status"] = toString(context.status);
  row["survivors"] = context.survivors;
  row["inliers"] = result.inlier_count;
  row["has_truth"] = truth != nullptr;
  row["baseline_m"] = truth ? truth->pose.translation().norm() : kNone;
  row["moved"] = truth && hasMoved(truth->pose.translation().norm(), truth->noise);
  row["right"] = verdict.right;
  row["wrong"] = verdict.wrong;
  row["rotation_error_deg"] = verdict.rotation_error;
  row["direction_error_deg"] = verdict.direction_error;
  row["rx_deg"] = verdict.signed_error.x();
  row["ry_deg"] = verdict.signed_error.y();
  row["rz_deg"] = verdict.signed_error.z();
  row["rotation_sigma_deg"] = rotation_sigma;
  row["direction_sigma_deg"] = direction_sigma;
  row["uncertainty_deg"] = rotation_sigma + direction_sigma;
  row["nees_rotation"] = verdict.nees_rotation;
  row["nees_direction"] = verdict.nees_direction;
  row["parallax_px"] = answeredOr(result.median_parallax_px);
  row["sigma_px"] = answeredOr(sigmaOf(result));
  row["covariance"] = TrustRow::array();
  for (int i = 0; answered && i < 36; ++i) row["covariance"].push_back(covariance(i / 6, i % 6));
  row["reliability"] = toJson(reliability);
  return row;
}

std::string trustCsv(const std::vector<TrustRow>& rows) {
  const std::vector<std::string> columns = splitAtCommas(kHeader);
  std::ostringstream csv;
  csv << kHeader << '\n';
  for (const TrustRow& row : rows) {
    for (const std::string& column : columns) csv << (&column == &columns.front() ? "" : ",") << cell(row.at(column));
    csv << '\n';
  }
  return csv.str();
}

}  // namespace gms_ransac
