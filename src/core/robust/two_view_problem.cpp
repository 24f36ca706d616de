#include "robust/two_view_problem.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/LU>

#include "robust/residual.h"
#include "robust/solvers/essential_5pt.h"
#include "robust/solvers/fundamental_7pt.h"
#include "robust/solvers/homography_4pt.h"

namespace gms_ransac {

namespace {

using Column = std::vector<float> PointPairs::*;

/// Moves the centre of the points that have places to the origin and divides by `scale`.
Eigen::Matrix3d centring(const PointPairs& pairs, Column x, Column y, double scale) {
  double sum_x = 0, sum_y = 0, n = 0;
  for (size_t i = 0; i < pairs.x_reference.size(); ++i) {
    if (!pairs.hasPlaces(i)) continue;
    sum_x += (pairs.*x)[i];
    sum_y += (pairs.*y)[i];
    ++n;
  }
  n = std::max(1.0, n);
  Eigen::Matrix3d transform;
  transform << 1 / scale, 0, -sum_x / n / scale, 0, 1 / scale, -sum_y / n / scale, 0, 0, 1;
  return transform;
}

void transformColumns(const Eigen::Matrix3d& affine, const std::vector<float>& x, const std::vector<float>& y,
                      std::vector<float>& x_out, std::vector<float>& y_out) {
  for (size_t i = 0; i < x.size(); ++i) {
    x_out[i] = static_cast<float>(affine(0, 0) * x[i] + affine(0, 1) * y[i] + affine(0, 2));
    y_out[i] = static_cast<float>(affine(1, 0) * x[i] + affine(1, 1) * y[i] + affine(1, 2));
  }
}

/// Half the largest extent of the four columns, at least one pixel; of matches that have places.
double halfExtent(const PointPairs& pairs) {
  double extent = 2;
  for (const Column column :
       {&PointPairs::x_reference, &PointPairs::y_reference, &PointPairs::x_current, &PointPairs::y_current}) {
    double low = std::numeric_limits<double>::max(), high = std::numeric_limits<double>::lowest();
    for (size_t i = 0; i < pairs.x_reference.size(); ++i) {
      if (!pairs.hasPlaces(i)) continue;
      low = std::min<double>(low, (pairs.*column)[i]);
      high = std::max<double>(high, (pairs.*column)[i]);
    }
    extent = std::max(extent, high - low);
  }
  return 0.5 * extent;
}

template <int kSampleSize>
void gather(const OrderedPoints& points, const int* sample, double (&reference)[kSampleSize][2],
            double (&current)[kSampleSize][2]) {
  for (int i = 0; i < kSampleSize; ++i) {
    reference[i][0] = points.x_reference[sample[i]];
    reference[i][1] = points.y_reference[sample[i]];
    current[i][0] = points.x_current[sample[i]];
    current[i][1] = points.y_current[sample[i]];
  }
}

/// Plain loops over columns, so that the compiler vectorises them. A NaN residual is not an inlier.
void markSampson(const Eigen::Matrix3f& M, const OrderedPoints& points, float threshold_squared, uint8_t* inlier) {
  const float *xr = points.x_reference.data(), *yr = points.y_reference.data();
  const float *xc = points.x_current.data(), *yc = points.y_current.data();
  const int n = points.size();
  for (int i = 0; i < n; ++i) {
    const float a = M(0, 0) * xr[i] + M(0, 1) * yr[i] + M(0, 2);
    const float b = M(1, 0) * xr[i] + M(1, 1) * yr[i] + M(1, 2);
    const float c = M(2, 0) * xr[i] + M(2, 1) * yr[i] + M(2, 2);
    const float d = M(0, 0) * xc[i] + M(1, 0) * yc[i] + M(2, 0);
    const float e = M(0, 1) * xc[i] + M(1, 1) * yc[i] + M(2, 1);
    const float algebraic = xc[i] * a + yc[i] * b + c;
    inlier[i] = algebraic * algebraic < threshold_squared * (a * a + b * b + d * d + e * e) ? 1 : 0;
  }
}

void markTransfer(const Eigen::Matrix3f& H, const Eigen::Matrix3f& G, const OrderedPoints& points,
                  float threshold_squared, uint8_t* inlier) {
  const float *xr = points.x_reference.data(), *yr = points.y_reference.data();
  const float *xc = points.x_current.data(), *yc = points.y_current.data();
  const int n = points.size();
  for (int i = 0; i < n; ++i) {
    const float w = 1 / (H(2, 0) * xr[i] + H(2, 1) * yr[i] + H(2, 2));
    const float v = 1 / (G(2, 0) * xc[i] + G(2, 1) * yc[i] + G(2, 2));
    const float dx = (H(0, 0) * xr[i] + H(0, 1) * yr[i] + H(0, 2)) * w - xc[i];
    const float dy = (H(1, 0) * xr[i] + H(1, 1) * yr[i] + H(1, 2)) * w - yc[i];
    const float ex = (G(0, 0) * xc[i] + G(0, 1) * yc[i] + G(0, 2)) * v - xr[i];
    const float ey = (G(1, 0) * xc[i] + G(1, 1) * yc[i] + G(1, 2)) * v - yr[i];
    inlier[i] = 0.5f * (dx * dx + dy * dy + ex * ex + ey * ey) < threshold_squared ? 1 : 0;
  }
}

Eigen::Matrix3d inverseIfHomography(ModelType type, const Eigen::Matrix3d& model) {
  return type == ModelType::kHomography ? Eigen::Matrix3d(model.inverse()) : Eigen::Matrix3d::Zero();
}

}  // namespace

void OrderedPoints::resize(int n) {
  for (auto* column : {&x_reference, &y_reference, &x_current, &y_current}) column->resize(static_cast<size_t>(n));
}

void TwoViewProblem::set(const PointPairs& pairs, const Camera& camera, ModelType type, double threshold_px) {
  type_ = type;
  double scale = 1;
  if (type == ModelType::kEssential) {
    to_working_reference_ = to_working_current_ = camera.K().inverse();
    scale = camera.meanFocalLength();
  } else {
    scale = halfExtent(pairs);
    to_working_reference_ = centring(pairs, &PointPairs::x_reference, &PointPairs::y_reference, scale);
    to_working_current_ = centring(pairs, &PointPairs::x_current, &PointPairs::y_current, scale);
  }
  threshold_ = threshold_px / scale;
  all_.resize(pairs.size());
  transformColumns(to_working_reference_, pairs.x_reference, pairs.y_reference, all_.x_reference, all_.y_reference);
  transformColumns(to_working_current_, pairs.x_current, pairs.y_current, all_.x_current, all_.y_current);
  for (size_t i = 0; i < all_.x_reference.size(); ++i) {
    if (pairs.hasPlaces(i)) continue;
    // Finite, since sums over all matches follow that zero weights do not save from NaN.
    all_.x_reference[i] = all_.y_reference[i] = 0;
    all_.x_current[i] = kNowhere;
    all_.y_current[i] = -kNowhere;
  }
}

int TwoViewProblem::sampleSize() const {
  switch (type_) {
    case ModelType::kEssential:
      return 5;
    case ModelType::kFundamental:
      return 7;
    case ModelType::kHomography:
      break;
  }
  return 4;
}

void TwoViewProblem::arrange(const std::vector<int>& order, OrderedPoints& points) const {
  points.resize(static_cast<int>(order.size()));
  for (size_t k = 0; k < order.size(); ++k) {
    const auto i = static_cast<size_t>(order[k]);
    points.x_reference[k] = all_.x_reference[i];
    points.y_reference[k] = all_.y_reference[i];
    points.x_current[k] = all_.x_current[i];
    points.y_current[k] = all_.y_current[i];
  }
}

int TwoViewProblem::solve(const OrderedPoints& points, const int* sample, Eigen::Matrix3d models[kMaxModels]) const {
  int count = 0;
  if (type_ == ModelType::kEssential) {
    double reference[5][2], current[5][2];
    gather(points, sample, reference, current);
    count = solveEssential5(reference, current, models);
  } else if (type_ == ModelType::kFundamental) {
    double reference[7][2], current[7][2];
    gather(points, sample, reference, current);
    count = solveFundamental7(reference, current, models);
  } else {
    double reference[4][2], current[4][2];
    gather(points, sample, reference, current);
    count = solveHomography4(reference, current, models);
  }
  int finite = 0;
  for (int i = 0; i < count; ++i) {
    if (models[i].allFinite()) models[finite++] = models[i];
  }
  return finite;
}

bool TwoViewProblem::fits(const Eigen::Matrix3d& model, const OrderedPoints& points, int i) const {
  const auto k = static_cast<size_t>(i);
  const double xr = points.x_reference[k], yr = points.y_reference[k];
  const double xc = points.x_current[k], yc = points.y_current[k];
  const double squared = type_ == ModelType::kHomography ? transferSquared(model, model.inverse(), xr, yr, xc, yc)
                                                         : sampsonSquared(model, xr, yr, xc, yc);
  return squared < threshold_ * threshold_;
}

void TwoViewProblem::markInliers(const Eigen::Matrix3d& model, const OrderedPoints& points,
                                 std::vector<uint8_t>& inlier) const {
  const auto threshold_squared = static_cast<float>(threshold_ * threshold_);
  const Eigen::Matrix3f M = model.cast<float>();
  inlier.resize(static_cast<size_t>(points.size()));
  if (type_ == ModelType::kHomography) {
    markTransfer(M, model.inverse().cast<float>(), points, threshold_squared, inlier.data());
  } else {
    markSampson(M, points, threshold_squared, inlier.data());
  }
}

Eigen::Matrix3d TwoViewProblem::inResultUnits(const Eigen::Matrix3d& model) const {
  Eigen::Matrix3d result = model;
  if (type_ == ModelType::kFundamental) {
    result = to_working_current_.transpose() * model * to_working_reference_;
  } else if (type_ == ModelType::kHomography) {
    result = to_working_current_.inverse() * model * to_working_reference_;
  }
  return result / result.norm();
}

void markFinalInliers(const PointPairs& pairs, const Camera& camera, double threshold_px, RobustResult& result) {
  const bool essential = result.model_type == ModelType::kEssential;
  const double unit = essential ? camera.meanFocalLength() : 1;  ///< pixels per unit of the residual
  const Eigen::Matrix3d to_model = essential ? Eigen::Matrix3d(camera.K().inverse()) : Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d inverse = inverseIfHomography(result.model_type, result.model);
  result.inlier.assign(static_cast<size_t>(pairs.size()), 0);
  result.inlier_count = 0;
  double sum = 0;
  for (size_t i = 0; i < result.inlier.size(); ++i) {
    if (!pairs.hasPlaces(i)) continue;
    const Eigen::Vector3d r = to_model * Eigen::Vector3d(pairs.x_reference[i], pairs.y_reference[i], 1);
    const Eigen::Vector3d c = to_model * Eigen::Vector3d(pairs.x_current[i], pairs.y_current[i], 1);
    const double squared = unit * unit *
                           (result.model_type == ModelType::kHomography
                                ? transferSquared(result.model, inverse, r.x(), r.y(), c.x(), c.y())
                                : sampsonSquared(result.model, r.x(), r.y(), c.x(), c.y()));
    if (!(squared < threshold_px * threshold_px)) continue;
    result.inlier[i] = 1;
    ++result.inlier_count;
    sum += squared;
  }
  result.rms_error_px = result.inlier_count > 0 ? std::sqrt(sum / result.inlier_count) : 0;
}

}  // namespace gms_ransac
