#include "matching/patch.h"

#include <cmath>
#include <numeric>

#include <Eigen/LU>

namespace gms_ransac {

namespace {

// Standard deviation of the intensities, grey levels, below which there is nothing but noise to align.
constexpr float kLeastContrast = 3;
// Steps of a shift alone bring the guess near, then the shape may change.
constexpr int kShiftSteps = 6, kAffineSteps = 8;
constexpr float kNearStep = 0.5F, kLastStep = 0.03F;  // pixels
// Correlation of the patch with what was found; 0.7 to 0.85 make next to no difference (doc/inside/tracks.md).
constexpr float kLikeness = 0.8F;

}  // namespace

bool Patch::sample(const cv::Mat& image, const PatchPlace& place, Samples& samples) {
  const Eigen::Vector2f half(kRadius * place.shape.row(0).cwiseAbs().sum(),
                             kRadius * place.shape.row(1).cwiseAbs().sum());
  const Eigen::Vector2f first = place.centre - half, last = place.centre + half;
  const bool inside = first.x() >= 0 && first.y() >= 0 && last.x() < static_cast<float>(image.cols - 1) &&
                      last.y() < static_cast<float>(image.rows - 1);
  if (!inside) return false;
  const size_t step = image.step;
  float* out = samples.data();
  for (int dy = -kRadius; dy <= kRadius; ++dy) {
    Eigen::Vector2f at = place.centre + place.shape * Eigen::Vector2f(-kRadius, static_cast<float>(dy));
    for (int dx = 0; dx < kSide; ++dx, at += place.shape.col(0)) {
      const int x = static_cast<int>(at.x()), y = static_cast<int>(at.y());
      const float u = at.x() - static_cast<float>(x), v = at.y() - static_cast<float>(y);
      const uint8_t* p = image.data + static_cast<size_t>(y) * step + static_cast<size_t>(x);
      const float above = static_cast<float>(p[0]) + u * static_cast<float>(p[1] - p[0]);
      const float below = static_cast<float>(p[step]) + u * static_cast<float>(p[step + 1] - p[step]);
      *out++ = above + v * (below - above);
    }
  }
  return true;
}

float Patch::normalize(Samples& samples) {
  Eigen::Map<Eigen::Array<float, kPixels, 1>> values(samples.data());
  values -= values.mean();
  const float length = std::sqrt(values.square().sum());
  if (length < kLeastContrast * kSide) return 0;
  values /= length;
  return length;
}

bool Patch::cut(const cv::Mat& image, const Eigen::Vector2f& centre) {
  const auto at = [&](float dx, float dy, Samples& samples) {
    PatchPlace place;
    place.centre = centre + Eigen::Vector2f(dx, dy);
    return sample(image, place, samples);
  };
  Samples right, left, below, above;
  if (!at(1, 0, right) || !at(-1, 0, left) || !at(0, 1, below) || !at(0, -1, above) || !at(0, 0, intensity_))
    return false;
  const float length = normalize(intensity_);
  if (length == 0) return false;
  using Column = Eigen::Map<Eigen::Array<float, kPixels, 1>>;
  Column(gradient_x_.data()) = (Column(right.data()) - Column(left.data())) / (2 * length);
  Column(gradient_y_.data()) = (Column(below.data()) - Column(above.data())) / (2 * length);
  weighGradients();
  return inverse_affine_.allFinite() && inverse_shift_.allFinite();
}

void Patch::weighGradients() {
  Matrix6f normal = Matrix6f::Zero();
  Vector6f sum = Vector6f::Zero(), gain = Vector6f::Zero();
  size_t i = 0;
  for (int dy = -kRadius; dy <= kRadius; ++dy) {
    for (int dx = -kRadius; dx <= kRadius; ++dx, ++i) {
      const float gx = gradient_x_[i], gy = gradient_y_[i];
      const auto x = static_cast<float>(dx), y = static_cast<float>(dy);
      Vector6f row;
      row << gx, gy, gx * x, gx * y, gy * x, gy * y;
      normal += row * row.transpose();
      sum += row;
      gain += intensity_[i] * row;
    }
  }
  // Normalizing removes mean and gain.
  normal -= sum * sum.transpose() / kPixels + gain * gain.transpose();
  inverse_shift_ = normal.topLeftCorner<2, 2>().inverse();
  inverse_affine_ = normal.inverse();
}

Patch::Vector6f Patch::project(const Samples& difference) const {
  Vector6f sum = Vector6f::Zero();
  size_t i = 0;
  for (int dy = -kRadius; dy <= kRadius; ++dy) {
    float x = 0, y = 0, x_dx = 0, y_dx = 0;
    for (int dx = -kRadius; dx <= kRadius; ++dx, ++i) {
      const float gx = gradient_x_[i] * difference[i], gy = gradient_y_[i] * difference[i];
      x += gx;
      y += gy;
      x_dx += gx * static_cast<float>(dx);
      y_dx += gy * static_cast<float>(dx);
    }
    const auto row = static_cast<float>(dy);
    sum += (Vector6f() << x, y, x_dx, x * row, y_dx, y * row).finished();
  }
  return sum;
}

std::optional<PatchPlace> Patch::find(const cv::Mat& image, const PatchPlace& guess, float reach) const {
  using Column = Eigen::Map<Eigen::Array<float, kPixels, 1>>;
  using ConstColumn = Eigen::Map<const Eigen::Array<float, kPixels, 1>>;
  PatchPlace place = guess;
  Samples seen;
  bool affine = false;
  for (int i = 0; i < kShiftSteps + kAffineSteps; ++i) {
    if (!sample(image, place, seen) || normalize(seen) == 0) return std::nullopt;
    Column(seen.data()) -= ConstColumn(intensity_.data());
    const Vector6f sums = project(seen);
    Vector6f step = Vector6f::Zero();
    if (affine) {
      step = inverse_affine_ * sums;
    } else {
      step[0] = inverse_shift_.row(0).dot(sums.head<2>());
      step[1] = inverse_shift_.row(1).dot(sums.head<2>());
    }
    // The patch moved by the step looks like what is seen here, so here is moved back by it.
    Eigen::Matrix2f change;
    change << 1 + step[2], step[3], step[4], 1 + step[5];
    const Eigen::Matrix2f back = change.inverse();
    place.centre -= place.shape * back * step.head<2>();
    place.shape = (place.shape * back).eval();
    if (!((place.centre - guess.centre).norm() <= reach)) return std::nullopt;
    const float length = step.head<2>().norm();
    if (affine && length < kLastStep) break;
    affine = affine || length < kNearStep || i + 1 >= kShiftSteps;
  }
  if (!sample(image, place, seen) || normalize(seen) == 0) return std::nullopt;
  const float likeness = (ConstColumn(seen.data()) * ConstColumn(intensity_.data())).sum();
  return likeness >= kLikeness ? std::optional(place) : std::nullopt;
}

std::optional<PatchPlace> Patch::find(const cv::Mat& image, const std::vector<PatchPlace>& guesses, float reach) const {
  const PatchPlace* best = nullptr;
  float most = 0;
  Samples seen;
  for (const PatchPlace& guess : guesses) {
    if (!sample(image, guess, seen) || normalize(seen) == 0) continue;
    const float likeness = std::inner_product(seen.begin(), seen.end(), intensity_.begin(), 0.F);
    if (likeness <= most) continue;
    most = likeness;
    best = &guess;
  }
  return best == nullptr ? std::nullopt : find(image, *best, reach);
}

}  // namespace gms_ransac
