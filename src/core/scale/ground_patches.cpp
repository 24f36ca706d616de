#include "scale/ground_scale.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <opencv2/imgproc.hpp>

namespace gms_ransac {

namespace {

// Pixels between samples, smoothed by as much, and least between patches: they do not overlap.
constexpr int kStep = 2, kApart = 18;
// Patches at most, which bounds the time, and those of them that give scores.
constexpr int kMostPatches = 240, kMostScored = 80;
constexpr double kSmoothing = 1.2;
// Ground farther to the side, in camera heights, may be another: gutters, kerbs, grass.
constexpr double kAside = 1.5;
constexpr float kContrast = 1.5f;
// Correlation above which a patch lies on the plane.
constexpr double kAgrees = 0.6;
constexpr int kSkip = 4;  ///< of the samples one in so many gives the score

}  // namespace

bool GroundPatches::cut(const cv::Mat& image, const Camera& camera, int x, int y, Patch& patch) const {
  for (int i = 0; i < kSamples; ++i) {
    const int u = x + kStep * (i % kSide - kSide / 2), v = y + kStep * (i / kSide - kSide / 2);
    const Eigen::Vector2d ray = rayOf(camera, {static_cast<float>(u), static_cast<float>(v)});
    if (!ray.allFinite()) return false;
    patch.rays.col(i) = ray.homogeneous().cast<float>();
    patch.values[i] = image.at<float>(v, u);
  }
  patch.values.array() -= patch.values.mean();
  const float norm = patch.values.norm();
  patch.values /= std::max(norm, 1e-6f);
  return norm > kContrast * std::sqrt(static_cast<float>(kSamples));
}

void GroundPatches::set(const GroundImages& images, const Camera& camera, const RelativePose& pose,
                        const Eigen::Vector3d& down, double smallest_dip) {
  camera_ = camera;
  R_ = pose.R;
  t_ = pose.t.normalized();
  patches_.clear();
  if (images.reference.empty() || images.current.empty()) return;
  const auto smooth = [](const cv::Mat& image, cv::Mat& smoothed) {
    image.convertTo(smoothed, CV_32F);
    cv::GaussianBlur(smoothed, smoothed, cv::Size(), kSmoothing);
  };
  smooth(images.reference, reference_);
  smooth(images.current, current_);
  const CameraIntrinsics& k = camera.intrinsics();
  const Eigen::Vector3d sideways = down.cross(R_.transpose() * t_).normalized();
  constexpr int kMargin = kStep * (kSide / 2) + 1;
  const int apart = std::max(kApart, static_cast<int>(std::sqrt(0.5 * current_.cols * current_.rows / kMostPatches)));
  Patch patch;
  for (int y = current_.rows - 1 - kMargin; y >= kMargin; y -= apart) {
    for (int x = kMargin; x + kMargin < current_.cols; x += apart) {
      const Eigen::Vector3d ray((x - k.cx) / k.fx, (y - k.cy) / k.fy, 1);
      if (down.dot(ray) < smallest_dip * ray.norm() || std::abs(sideways.dot(ray)) > kAside * down.dot(ray)) continue;
      if (cut(current_, camera, x, y, patch)) patches_.push_back(patch);
    }
  }
}

cv::Point2f GroundPatches::toReceived(const cv::Point2f& ideal) const {
  if (!camera_.distorts()) return ideal;
  cv::Point2f pixel = ideal;
  constexpr int kIterations = 4;
  for (int i = 0; i < kIterations; ++i) {
    // The table ends at the border of the image, and no sample is taken beyond.
    if (!(pixel.x >= 0 && pixel.y >= 0 && pixel.x < static_cast<float>(reference_.cols) &&
          pixel.y < static_cast<float>(reference_.rows))) {
      return {-1, -1};
    }
    pixel += ideal - camera_.undistort(pixel);
  }
  return pixel;
}

bool GroundPatches::look(const Eigen::Vector3d& m, const Eigen::Vector3d& ray, float& value,
                         Eigen::RowVector3d* derivative) const {
  // X = ray / (m . ray), seen from the reference as R X + t, or as anything along it.
  const Eigen::Vector3d seen = R_ * ray + m.dot(ray) * t_;
  if (!(seen.z() > 1e-3)) return false;
  const CameraIntrinsics& k = camera_.intrinsics();
  const Eigen::Vector2d at = seen.head<2>() / seen.z();
  const cv::Point2f pixel =
      toReceived(cv::Point2f(static_cast<float>(k.fx * at.x() + k.cx), static_cast<float>(k.fy * at.y() + k.cy)));
  // Asked of the numbers as they are: NaN, where the lens has no inverse, and what is far away are no index.
  const bool inside = pixel.x >= 0 && pixel.y >= 0 && pixel.x < static_cast<float>(reference_.cols - 1) &&
                      pixel.y < static_cast<float>(reference_.rows - 1);
  if (!inside) return false;
  const int u = static_cast<int>(pixel.x), v = static_cast<int>(pixel.y);
  const float a = pixel.x - static_cast<float>(u), b = pixel.y - static_cast<float>(v);
  const float* top = reference_.ptr<float>(v) + u;
  const float* bottom = reference_.ptr<float>(v + 1) + u;
  value = (1 - b) * ((1 - a) * top[0] + a * top[1]) + b * ((1 - a) * bottom[0] + a * bottom[1]);
  if (derivative == nullptr) return true;
  const double by_u = (1 - b) * (top[1] - top[0]) + b * (bottom[1] - bottom[0]);
  const double by_v = (1 - a) * (bottom[0] - top[0]) + a * (bottom[1] - top[1]);
  const double by_inverse =
      (k.fx * by_u * (t_.x() - at.x() * t_.z()) + k.fy * by_v * (t_.y() - at.y() * t_.z())) / seen.z();
  *derivative = by_inverse * ray.transpose();
  return true;
}

double GroundPatches::score(const Eigen::Vector3d& m) const {
  double sum = 0;
  const size_t stride = 1 + patches_.size() / kMostScored;
  for (size_t k = 0; k < patches_.size(); k += stride) {
    const Patch& patch = patches_[k];
    double products = 0, squares = 0, total = 0, own = 0, own_squares = 0;
    int count = 0;
    for (int i = 0; i < kSamples; i += kSkip, ++count) {
      float value;
      if (!look(m, patch.rays.col(i).cast<double>(), value, nullptr)) break;
      products += static_cast<double>(value) * patch.values[i];
      squares += static_cast<double>(value) * value;
      total += value;
      own += patch.values[i];
      own_squares += static_cast<double>(patch.values[i]) * patch.values[i];
    }
    if (count * kSkip < kSamples) continue;
    const double variance = squares - total * total / count, own_variance = own_squares - own * own / count;
    const double correlation = (products - total * own / count) / std::sqrt(std::max(variance * own_variance, 1e-12));
    sum += std::max(0.0, correlation - 0.5 * kAgrees);
  }
  return sum;
}

PlaneEquations GroundPatches::linearize(const Eigen::Vector3d& m) const {
  PlaneEquations equations;
  double squares = 0, samples = 0;
  Eigen::Matrix<double, kSamples, 3> J;
  Eigen::Matrix<double, kSamples, 1> values;
  for (const Patch& patch : patches_) {
    bool inside = true;
    for (int i = 0; i < kSamples && inside; ++i) {
      float value;
      Eigen::RowVector3d derivative;
      inside = look(m, patch.rays.col(i).cast<double>(), value, &derivative);
      values[i] = value;
      J.row(i) = derivative;
    }
    if (!inside) continue;
    values.array() -= values.mean();
    J.rowwise() -= J.colwise().mean().eval();
    const double norm = values.norm();
    if (!(norm > 1e-6)) continue;
    values /= norm;
    J /= norm;
    const double correlation = values.dot(patch.values.cast<double>());
    if (correlation < kAgrees) continue;
    const double weight = (correlation - kAgrees) / (1 - kAgrees);
    const Eigen::Matrix<double, kSamples, 1> residual = patch.values.cast<double>() - values;
    const Eigen::Vector3d gradient = weight * J.transpose() * residual;
    equations.H += weight * J.transpose() * J;
    equations.b += gradient;
    equations.spread += gradient * gradient.transpose();
    squares += weight * residual.squaredNorm();
    samples += weight * kSamples;
    ++equations.patches;
  }
  if (equations.patches == 0) return equations;
  const double variance = std::max(squares / std::max(1.0, samples), 1e-9);
  equations.H /= variance;
  equations.b /= variance;
  equations.spread /= variance * variance;
  return equations;
}

}  // namespace gms_ransac
