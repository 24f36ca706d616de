// Compares the alignment of patches by every instruction set that this processor has with plain code. Free of OpenCV
// and of a test framework, so that it can be cross-compiled; exits with 1 if there is a difference.
#include <cmath>
#include <cstdio>
#include <cstring>
#include <iterator>
#include <random>
#include <vector>

#include "matching/patch_kernels.h"

namespace {

using namespace gms_ransac;  // NOLINT: one program, one file

constexpr int kImageSide = 64;

/// All that the kernels return of a few hundred places.
std::vector<float> numbersBy(const PatchKernels& kernels) {
  std::mt19937 random(3);
  const auto uniform = [&](float low, float high) {
    return low + (high - low) * static_cast<float>(random() % 10000) / 10000;
  };
  std::vector<uint8_t> image(kImageSide * kImageSide);
  for (uint8_t& pixel : image) pixel = static_cast<uint8_t>(random() % 256);
  std::vector<float> numbers;
  const auto add = [&](const auto& values) {
    const auto* first = reinterpret_cast<const float*>(&values);
    numbers.insert(numbers.end(), first, first + sizeof values / sizeof *first);
  };
  PatchNumbers before = {};
  for (int i = 0; i < 500; ++i) {
    PatchMap place = {uniform(20, 44), uniform(20, 44), {{1, 0}, {0, 1}}};
    if (i % 3 == 0) place.x = std::floor(place.x);
    for (auto& row : place.shape) {
      for (float& entry : row) entry += i % 2 == 0 ? 0 : uniform(-0.4F, 0.4F);
    }
    PatchNumbers levels, across, down;
    kernels.sampleWithDifferences(image.data(), kImageSide, place, levels, across, down);
    add(levels);
    add(across);
    add(down);
    kernels.sample(image.data(), kImageSide, place, levels);
    add(levels);
    add(kernels.normalize(levels));
    add(levels);
    add(kernels.moments(levels, before));
    before = levels;
    const PixelRows left = {&image[static_cast<size_t>(i)], kImageSide},
                    right = {&image[static_cast<size_t>(2 * i)], kImageSide};
    const RowSums sums = kernels.sumRows(left, right, static_cast<uint16_t>(i % 3 * 100));
    int whole[sizeof sums / sizeof(int)];
    std::memcpy(whole, &sums, sizeof sums);
    numbers.insert(numbers.end(), std::begin(whole), std::end(whole));
  }
  PatchNumbers flat = {};
  add(kernels.normalize(flat));
  add(flat);
  return numbers;
}

/// The grey level of every pixel where the image is linear, its differences, and the moments of ones.
bool isRight(const PatchKernels& kernels) {
  std::vector<uint8_t> image(kImageSide * kImageSide);
  for (int y = 0; y < kImageSide; ++y) {
    for (int x = 0; x < kImageSide; ++x) image[y * kImageSide + x] = static_cast<uint8_t>(2 * x + y);
  }
  const auto differs = [](float a, float b) { return std::abs(a - b) > 1e-3F; };
  for (const float skew : {0.F, 0.2F}) {
    const PatchMap place = {30.3F, 25.8F, {{1 + skew, -skew}, {skew / 2, 1}}};
    PatchNumbers levels, across, down;
    kernels.sampleWithDifferences(image.data(), kImageSide, place, levels, across, down);
    const auto slope = [&](int k) { return 2 * place.shape[0][k] + place.shape[1][k]; };
    for (int row = 0; row < kPatchSide; ++row) {
      for (int i = 0; i < kPatchLanes; ++i) {
        const auto dx = static_cast<float>(i - kPatchRadius), dy = static_cast<float>(row - kPatchRadius);
        const float x = place.x + place.shape[0][0] * dx + place.shape[0][1] * dy,
                    y = place.y + place.shape[1][0] * dx + place.shape[1][1] * dy;
        const bool inside = i < kPatchSide;
        if (differs(levels.at[row][i], inside ? 2 * x + y : 0)) return false;
        if (differs(across.at[row][i], inside ? 2 * slope(0) : 0)) return false;
        if (differs(down.at[row][i], inside ? 2 * slope(1) : 0)) return false;
      }
    }
  }
  PatchNumbers ones = {};
  for (auto& row : ones.at) {
    for (int i = 0; i < kPatchSide; ++i) row[i] = 1;
  }
  const PatchMoments sums = kernels.moments(ones, ones);
  const float squares = 2 * (1 + 4 + 9 + 16 + 25) * kPatchSide;
  if (sums.one != kPatchSide * kPatchSide || sums.x != 0 || sums.y != 0 || sums.xy != 0) return false;
  return sums.xx == squares && sums.yy == squares && !differs(kernels.normalize(ones), 0);
}

}  // namespace

int main() {
  bool ok = isRight(patchKernels(SimdLevel::kScalar));
  std::printf("scalar %s\n", ok ? "is right" : "is wrong");
  const std::vector<float> scalar = numbersBy(patchKernels(SimdLevel::kScalar));
  for (const SimdLevel level : {SimdLevel::kNeon, SimdLevel::kAvx2, SimdLevel::kAvx512}) {
    if (!simdLevelSupported(level)) continue;
    const std::vector<float> numbers = numbersBy(patchKernels(level));
    const bool equal = std::memcmp(numbers.data(), scalar.data(), scalar.size() * sizeof(float)) == 0;
    std::printf("%s %s\n", toString(level).c_str(), equal ? "equals scalar" : "differs");
    ok = ok && equal;
  }
  return ok ? 0 : 1;
}
