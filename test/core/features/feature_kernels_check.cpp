// Compares the extractor's inner loops of every instruction set that this processor has with the scalar ones. Free of
// OpenCV and of a test framework, so that it can be cross-compiled; exits with 1 if there is a difference.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "features/kernels.h"
#include "features/plane.h"

namespace {

using namespace gms_ransac;  // NOLINT: one program, one file

/// Random rows, smooth ones and ones of few values: corners of every kind, ties and flat stretches.
Plane image(int width, int height, std::mt19937& random) {
  Plane plane;
  plane.resize(width, height);
  const int step = 1 + static_cast<int>(random() % 64);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const unsigned noise = random() % 256;
      plane.row(y)[x] = static_cast<uint8_t>(y / 8 % 2 ? noise : noise / step * step / 2 + (x / 7 + y / 5) % 2 * 90);
    }
  }
  return plane;
}

/// The contrasts of a whole image, then the maxima of its rows with their strengths, in order.
struct CornerRows {
  CornerRows(const FeatureKernels& kernels, const Plane& plane, const CornerFloors& floors) {
    const int width = plane.width(), height = plane.height();
    contrast.resize(width, height);
    std::vector<std::vector<uint8_t>> passed_over(height, std::vector<uint8_t>(width + 2));
    std::vector<std::vector<uint16_t>> candidates(height, std::vector<uint16_t>(width + 2));
    const auto blocks = [&](int y) { return BlockRow{&passed_over[y][1], candidates[y].data()}; };
    std::vector<int> candidate_count(height);
    for (int y = 3; y < height - 3; ++y) {
      candidate_count[y] =
          kernels.contrastRow(plane.row(y), plane.stride(), width - 3, floors, contrast.row(y), blocks(y));
    }
    std::vector<uint16_t> columns(width + 16);
    std::vector<uint8_t> strength(width + Plane::kSlack);
    for (int y = 4; y < height - 4; ++y) {
      const int count =
          kernels
              .maximaRow(plane.row(y), contrast.row(y), plane.stride(), {blocks(y - 1), blocks(y), blocks(y + 1)},
                         candidate_count[y], floors, 4, width - 4, columns.data(), strength.data())
              .strong;
      for (int i = 0; i < count; ++i) {
        const int x = columns[i];
        corners.insert(corners.end(), {x, y, strength[x]});
        for (int row = -1; row <= 1; ++row) {
          corners.insert(corners.end(), contrast.row(y + row) + x - 1, contrast.row(y + row) + x + 2);
        }
      }
    }
  }

  Plane contrast;
  std::vector<int> corners;  ///< column, row, strength and the contrasts about it of each
};

/// Corners stronger than a floor of the strength are found with all their values, whichever blocks are skipped.
bool findsStrongCorners(const FeatureKernels& kernels, const std::vector<int>& all, const Plane& plane, int floor) {
  constexpr size_t kNumbers = 3 + 9;
  for (int strength : {1, 10, 30, 60, 100, 200, 254}) {
    std::vector<int> strong;
    for (auto corner = all.begin(); corner != all.end(); corner += kNumbers) {
      if (corner[2] > strength) strong.insert(strong.end(), corner, corner + kNumbers);
    }
    if (CornerRows(kernels, plane, {floor, strength}).corners != strong) return false;
  }
  return true;
}

/// Output of the other kernels, in order.
struct Written {
  std::vector<double> numbers;

  template <typename T>
  void add(const T* first, int count) {
    numbers.insert(numbers.end(), first, first + count);
  }
};

std::vector<double> resize(const FeatureKernels& kernels, const Plane& plane, int target) {
  Written written;
  ResizeTable table;
  table.build(plane.width(), target);
  std::vector<uint16_t> rows[2];
  std::vector<uint8_t> blended(target + Plane::kSlack);
  for (int y = 0; y < 2; ++y) {
    rows[y].resize(target + ResizeTable::kPadding);
    kernels.resizeRow(plane.row(y), table, target, rows[y].data());
    written.add(rows[y].data(), target);
  }
  for (int weight : {0, 1, 77, 128, 255, 256}) {
    kernels.blendRows(rows[0].data(), rows[1].data(), weight, target, blended.data());
    written.add(blended.data(), target);
  }
  return written.numbers;
}

std::vector<double> blur(const FeatureKernels& kernels, const Plane& plane) {
  const int width = plane.width();
  std::vector<float> wide[2], rows[kBlurTaps + 1];
  float* row_pointers[kBlurTaps + 1];
  for (int k = 0; k <= kBlurTaps; ++k) {
    rows[k].resize(width + 64);
    for (int x = 0; x < width; ++x) rows[k][x] = plane.row(k)[x] / 3.f;
    row_pointers[k] = rows[k].data();
  }
  std::vector<uint8_t> blurred[2];
  for (int k = 0; k < 2; ++k) {
    wide[k].assign(width + 64, 1.f);
    kernels.widenRow(plane.row(k), width, wide[k].data() + kBlurRadius);
    std::fill(wide[k].begin() + kBlurRadius + width, wide[k].end(), 1.f);
    blurred[k].resize(width + Plane::kSlack);
  }
  const float* const pixels[2] = {wide[0].data() + kBlurRadius, wide[1].data() + kBlurRadius};
  uint8_t* const targets[2] = {blurred[0].data(), blurred[1].data()};
  kernels.blurTwoRows(pixels, row_pointers, width, targets);
  Written written;
  for (const auto& row : blurred) written.add(row.data(), width);
  return written.numbers;
}

std::vector<double> describe(const FeatureKernels& kernels, const Plane& plane) {
  Written written;
  std::mt19937 random(2);
  for (int i = 0; i < 50; ++i) {
    const int x = kDescriptorRadius + static_cast<int>(random() % (plane.width() - 2 * kDescriptorRadius));
    const int y = kDescriptorRadius + static_cast<int>(random() % (plane.height() - 2 * kDescriptorRadius));
    const float angle = static_cast<float>(random() % 62832) / 10000;
    uint8_t descriptor[32];
    int moments[2];
    kernels.moments(plane.row(y) + x, plane.stride(), moments[0], moments[1]);
    kernels.describe(plane.row(y) + x, plane.stride(), std::cos(angle), std::sin(angle), descriptor);
    written.add(moments, 2);
    written.add(descriptor, 32);
  }
  return written.numbers;
}

std::vector<double> compareRows(const FeatureKernels& kernels, const Plane& plane) {
  const int width = plane.width(), places = width - kRowWindowWidth + 1;
  Written written;
  Plane gradients;
  gradients.resize(width, kRowWindowHeight);
  for (int y = 0; y < kRowWindowHeight; ++y) {
    kernels.gradientRow(plane.row(y), width, gradients.row(y));
    written.add(gradients.row(y), width);
  }
  std::vector<int16_t> sums(places + Plane::kSlack);
  for (int x = 0; x < places; x += 5) {
    kernels.compareRow(gradients.row(0) + x, gradients.row(0), gradients.stride(), places, sums.data());
    written.add(sums.data(), places);
  }
  return written.numbers;
}

/// The name of the first loop that differs, or null.
const char* difference(const FeatureKernels& kernels, const FeatureKernels& scalar) {
  std::mt19937 random(1);
  for (int width : {37, 48, 63, 64, 65, 100, 129, 200}) {
    const Plane plane = image(width, 60, random);
    for (int floor : {0, 7, 40}) {
      const CornerRows all(scalar, plane, {floor, 0}), found(kernels, plane, {floor, 0});
      for (int y = 3; y < plane.height() - 3; ++y) {
        const uint8_t *a = found.contrast.row(y), *b = all.contrast.row(y);
        if (!std::equal(a + 3, a + width - 3, b + 3)) return "contrastRow";
      }
      if (found.corners != all.corners || !findsStrongCorners(kernels, all.corners, plane, floor)) return "maximaRow";
    }
    for (double scale : {1.0, 1.2, 1.44, 1.9, 2.0}) {
      const int target = static_cast<int>(std::lrint(width / scale));
      if (resize(kernels, plane, target) != resize(scalar, plane, target)) return "resizeRow or blendRows";
    }
    if (blur(kernels, plane) != blur(scalar, plane)) return "blurTwoRows";
    if (describe(kernels, plane) != describe(scalar, plane)) return "moments or describe";
    if (compareRows(kernels, plane) != compareRows(scalar, plane)) return "gradientRow or compareRow";
  }
  return nullptr;
}

bool report(const std::string& name, const FeatureKernels& kernels) {
  const char* differs = difference(kernels, featureKernels(SimdLevel::kScalar));
  std::printf("%s %s\n", name.c_str(), differs ? (std::string("differs in ") + differs).c_str() : "equals scalar");
  return differs == nullptr;
}

}  // namespace

int main() {
  bool ok = true;
  for (SimdLevel level : {SimdLevel::kScalar, SimdLevel::kNeon, SimdLevel::kAvx2, SimdLevel::kAvx512}) {
    if (simdLevelSupported(level)) ok = report(toString(level), featureKernels(level)) && ok;
  }
#if defined(__x86_64__)
  for (const bool intel : {false, true}) {  // whichever this processor is
    if (!simdLevelSupported(SimdLevel::kAvx512)) continue;
    ok = report(intel ? "avx512 for Intel" : "avx512 for AMD", detail::avx512FeatureKernels(intel)) && ok;
  }
#endif
  return ok ? 0 : 1;
}
