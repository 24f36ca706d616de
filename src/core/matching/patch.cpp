#include "matching/patch.h"

#include <algorithm>

#include <Eigen/LU>

namespace gms_ransac {

namespace {

// Standard deviation of the intensities, grey levels, below which there is nothing but noise to align.
constexpr float kLeastContrast = 3;
// Steps of a shift alone bring the guess near, then the shape may change.
constexpr int kShiftSteps = 6, kAffineSteps = 8;
constexpr float kNearStep = 0.5F, kLastStep = 0.1F;  // pixels; what follows is a tenth of it
constexpr float kRounding = 1e-6F;                   // of a correlation in single precision

/// 1 at each pixel of a patch.
constexpr PatchNumbers makeOnes() {
  PatchNumbers ones = {};
  for (int y = 0; y < kPatchSide; ++y) {
    for (int x = 0; x < kPatchSide; ++x) ones.at[y][x] = 1;
  }
  return ones;
}
constexpr PatchNumbers kOnes = makeOnes();

/// Pixels of the right and lower border that are left out, so that rounding keeps a patch inside.
constexpr float kRim = 0.01F;

bool inside(const cv::Mat& image, const PatchPlace& place, int radius) {
  const Eigen::Vector2f half = static_cast<float>(radius) * place.shape.cwiseAbs().rowwise().sum();
  const Eigen::Vector2f first = place.centre - half, last = place.centre + half;
  return first.x() >= 0 && first.y() >= 0 && last.x() < static_cast<float>(image.cols - 1) - kRim &&
         last.y() < static_cast<float>(image.rows - 1) - kRim;
}

PatchMap mapOf(const PatchPlace& place) {
  return {place.centre.x(),
          place.centre.y(),
          {{place.shape(0, 0), place.shape(0, 1)}, {place.shape(1, 0), place.shape(1, 1)}}};
}

}  // namespace

bool Patch::sample(const cv::Mat& image, const PatchPlace& place, PatchNumbers& levels) const {
  if (!inside(image, place, kPatchRadius)) return false;
  kernels_->sample(image.data, static_cast<ptrdiff_t>(image.step), mapOf(place), levels);
  return kernels_->normalize(levels) >= kLeastContrast * kPatchSide;
}

bool Patch::cut(const cv::Mat& image, const Eigen::Vector2f& centre) {
  const PatchPlace place = {centre, Eigen::Matrix2f::Identity()};
  if (!inside(image, place, kPatchRadius + 1)) return false;
  kernels_->sampleWithDifferences(image.data, static_cast<ptrdiff_t>(image.step), mapOf(place), intensity_, gradient_x_,
                                  gradient_y_);
  const float length = kernels_->normalize(intensity_);
  if (length < kLeastContrast * kPatchSide) return false;
  for (PatchNumbers* gradient : {&gradient_x_, &gradient_y_}) {
    Eigen::Map<Eigen::Array<float, kPatchSide * kPatchLanes, 1>>(gradient->at[0]) /= 2 * length;
  }
  const Eigen::Vector2f sum = projectToShift(kOnes), x = projectToShift(gradient_x_), y = projectToShift(gradient_y_);
  gain_ = projectToShift(intensity_);
  Eigen::Matrix2f normal;
  normal << x, y;
  // Normalizing removes mean and gain.
  normal -= sum * sum.transpose() / (kPatchSide * kPatchSide) + gain_ * gain_.transpose();
  shift_.compute(normal);
  return shift_.info() == Eigen::Success;
}

Patch::Affine Patch::affine() const {
  const PatchMoments xx = kernels_->moments(gradient_x_, gradient_x_), xy = kernels_->moments(gradient_x_, gradient_y_),
                     yy = kernels_->moments(gradient_y_, gradient_y_);
  Matrix6f normal;
  normal << xx.one, xy.one, xx.x, xx.y, xy.x, xy.y,  //
      xy.one, yy.one, xy.x, xy.y, yy.x, yy.y,        //
      xx.x, xy.x, xx.xx, xx.xy, xy.xx, xy.xy,        //
      xx.y, xy.y, xx.xy, xx.yy, xy.xy, xy.yy,        //
      xy.x, yy.x, xy.xx, xy.xy, yy.xx, yy.xy,        //
      xy.y, yy.y, xy.xy, xy.yy, yy.xy, yy.yy;
  const Vector6f sum = project(kOnes);
  Affine affine;
  affine.gain = project(intensity_);
  normal -= sum * sum.transpose() / (kPatchSide * kPatchSide) + affine.gain * affine.gain.transpose();
  affine.normal.compute(normal);
  return affine;
}

Eigen::Vector2f Patch::projectToShift(const PatchNumbers& numbers) const {
  return {kernels_->product(gradient_x_, numbers), kernels_->product(gradient_y_, numbers)};
}

Patch::Vector6f Patch::project(const PatchNumbers& numbers) const {
  const PatchMoments x = kernels_->moments(gradient_x_, numbers), y = kernels_->moments(gradient_y_, numbers);
  return (Vector6f() << x.one, y.one, x.x, x.y, y.x, y.y).finished();
}

float Patch::shapeGain(const Affine& shape, const PatchNumbers& seen, float alike) const {
  constexpr float kPixels = kPatchSide * kPatchSide, kUnknowns = 6, kOfShape = 4, kOfLight = 2;
  const Vector6f pull = project(seen) - shape.gain;
  const Eigen::Vector2f of_shift = pull.head<2>();
  const float both = pull.dot(shape.normal.solve(pull)), shift = of_shift.dot(shift_.solve(of_shift));
  const float rest = std::max(1 - alike * alike - both, kRounding);
  return (both - shift) / kOfShape / (rest / (kPixels - kUnknowns - kOfLight));
}

std::optional<PatchPlace> Patch::find(const cv::Mat& image, const PatchPlace& guess, const PatchSearch& search) const {
  PatchPlace place = guess;
  PatchNumbers seen;
  float alike = 0;
  std::optional<Affine> shape;  // once it may change
  const float near = search.shape_gain > 0 ? kLastStep : kNearStep;
  for (int i = 0; i < kShiftSteps + kAffineSteps; ++i) {
    if (!sample(image, place, seen)) return std::nullopt;
    alike = kernels_->product(seen, intensity_);
    Vector6f step = Vector6f::Zero();
    if (shape) {
      step = shape->normal.solve(project(seen) - shape->gain);
    } else {
      step.head<2>() = shift_.solve(projectToShift(seen) - gain_);
    }
    // The patch moved by the step looks like what is seen here, so here is moved back by it.
    Eigen::Matrix2f change;
    change << 1 + step[2], step[3], step[4], 1 + step[5];
    const Eigen::Matrix2f back = change.inverse();
    place.centre -= place.shape * back * step.head<2>();
    place.shape = (place.shape * back).eval();
    if (!((place.centre - guess.centre).norm() <= search.reach)) return std::nullopt;
    const float length = step.head<2>().norm();
    if (shape && length < kLastStep) break;
    if (shape || (length >= near && i + 1 < kShiftSteps)) continue;
    shape = affine();
    if (shape->normal.info() != Eigen::Success) return std::nullopt;
    if (search.shape_gain > 0 && shapeGain(*shape, seen, alike) < search.shape_gain) break;
  }
  return alike >= search.likeness ? std::optional(place) : std::nullopt;
}

std::optional<PatchPlace> Patch::find(const cv::Mat& image, const std::vector<PatchPlace>& guesses,
                                      const PatchSearch& search) const {
  const PatchPlace* best = nullptr;
  float most = 0;
  PatchNumbers seen;
  for (const PatchPlace& guess : guesses) {
    if (!sample(image, guess, seen)) continue;
    const float alike = kernels_->product(seen, intensity_);
    if (alike <= most) continue;
    most = alike;
    best = &guess;
  }
  return best == nullptr ? std::nullopt : find(image, *best, search);
}

}  // namespace gms_ransac
