// Compares the extractor's inner loops of every instruction set that this processor has with the scalar ones. Free of
// OpenCV and of a test framework, so that it can be cross-compiled; exits with 1 at the first difference.
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

bool same(const char* name, bool equal) {
  if (!equal) std::printf("%s differs\n", name);
  return equal;
}

template <typename T>
bool sameRow(const char* name, const T* a, const T* b, int n) {
  return same(name, std::equal(a, a + n, b));
}

/// The contrasts of a whole image, then the maxima of its rows with their strengths, in order.
struct CornerRows {
  CornerRows(const FeatureKernels& kernels, const Plane& plane, const CornerFloors& floors) {
    const int width = plane.width(), height = plane.height();
    contrast.resize(width, height);
    std::vector<std::vector<uint8_t>> passed_over(height, std::vector<uint8_t>(width + 2));
    for (int y = 3; y < height - 3; ++y) {
      kernels.contrastRow(plane.row(y), plane.stride(), width - 3, floors, contrast.row(y), &passed_over[y][1]);
    }
    std::vector<uint16_t> columns(width + 16);
    std::vector<uint8_t> strength(width + Plane::kSlack);
    for (int y = 4; y < height - 4; ++y) {
      uint8_t* const about[3] = {&passed_over[y - 1][1], &passed_over[y][1], &passed_over[y + 1][1]};
      const int count = kernels
                            .maximaRow(plane.row(y), contrast.row(y), plane.stride(), about, floors, 4, width - 4,
                                       columns.data(), strength.data())
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

bool checkCorners(const FeatureKernels& kernels, const FeatureKernels& scalar, const Plane& plane, int floor) {
  const CornerRows all(scalar, plane, {floor, 0}), found(kernels, plane, {floor, 0});
  for (int y = 3; y < plane.height() - 3; ++y) {
    if (!sameRow("contrastRow", found.contrast.row(y) + 3, all.contrast.row(y) + 3, plane.width() - 6)) return false;
  }
  if (!same("maximaRow", found.corners == all.corners)) return false;
  // Corners stronger than a floor of the strength are found with all their values, whichever blocks are skipped.
  constexpr size_t kNumbers = 3 + 9;
  for (int strength : {1, 10, 30, 60, 100, 200, 254}) {
    std::vector<int> strong;
    for (auto corner = all.corners.begin(); corner != all.corners.end(); corner += kNumbers) {
      if (corner[2] > strength) strong.insert(strong.end(), corner, corner + kNumbers);
    }
    for (const FeatureKernels* used : {&kernels, &scalar}) {
      if (!same("strong corners", CornerRows(*used, plane, {floor, strength}).corners == strong)) return false;
    }
  }
  return true;
}

bool checkResize(const FeatureKernels& kernels, const FeatureKernels& scalar, const Plane& plane, int target) {
  ResizeTable table;
  table.build(plane.width(), target);
  std::vector<uint16_t> rows[2][2];
  std::vector<uint8_t> blended[2];
  for (int i = 0; i < 2; ++i) {
    const FeatureKernels& used = i ? scalar : kernels;
    for (int y = 0; y < 2; ++y) {
      rows[i][y].resize(target + ResizeTable::kPadding);
      used.resizeRow(plane.row(y), table, target, rows[i][y].data());
    }
    if (i && !sameRow("resizeRow", rows[0][0].data(), rows[1][0].data(), target)) return false;
  }
  for (int weight : {0, 1, 77, 128, 255, 256}) {
    for (int i = 0; i < 2; ++i) {
      blended[i].resize(target + Plane::kSlack);
      (i ? scalar : kernels).blendRows(rows[1][0].data(), rows[1][1].data(), weight, target, blended[i].data());
    }
    if (!sameRow("blendRows", blended[0].data(), blended[1].data(), target)) return false;
  }
  return true;
}

bool checkBlur(const FeatureKernels& kernels, const FeatureKernels& scalar, const Plane& plane) {
  const int width = plane.width();
  std::vector<float> wide[2], rows[kBlurTaps + 1];
  std::vector<uint8_t> blurred[2][2];
  for (int i = 0; i < 2; ++i) {
    const FeatureKernels& used = i ? scalar : kernels;
    float* row_pointers[kBlurTaps + 1];
    for (int k = 0; k <= kBlurTaps; ++k) {
      rows[k].resize(width + 64);
      for (int x = 0; x < width; ++x) rows[k][x] = plane.row(k)[x] / 3.f;
      row_pointers[k] = rows[k].data();
    }
    for (int k = 0; k < 2; ++k) {
      wide[k].assign(width + 64, 1.f);
      used.widenRow(plane.row(k), width, wide[k].data() + kBlurRadius);
      std::fill(wide[k].begin() + kBlurRadius + width, wide[k].end(), 1.f);
      blurred[i][k].resize(width + Plane::kSlack);
    }
    const float* const pixels[2] = {wide[0].data() + kBlurRadius, wide[1].data() + kBlurRadius};
    uint8_t* const targets[2] = {blurred[i][0].data(), blurred[i][1].data()};
    used.blurTwoRows(pixels, row_pointers, width, targets);
  }
  return sameRow("blurTwoRows", blurred[0][0].data(), blurred[1][0].data(), width) &&
         sameRow("blurTwoRows", blurred[0][1].data(), blurred[1][1].data(), width);
}

bool checkDescription(const FeatureKernels& kernels, const FeatureKernels& scalar, const Plane& plane,
                      std::mt19937& random) {
  for (int i = 0; i < 50; ++i) {
    const int x = kDescriptorRadius + static_cast<int>(random() % (plane.width() - 2 * kDescriptorRadius));
    const int y = kDescriptorRadius + static_cast<int>(random() % (plane.height() - 2 * kDescriptorRadius));
    const float angle = static_cast<float>(random() % 62832) / 10000;
    uint8_t descriptor[2][32];
    int m10[2], m01[2];
    for (int j = 0; j < 2; ++j) {
      const FeatureKernels& used = j ? scalar : kernels;
      used.moments(plane.row(y) + x, plane.stride(), m10[j], m01[j]);
      used.describe(plane.row(y) + x, plane.stride(), std::cos(angle), std::sin(angle), descriptor[j]);
    }
    if (!same("moments", m10[0] == m10[1] && m01[0] == m01[1])) return false;
    if (!sameRow("describe", descriptor[0], descriptor[1], 32)) return false;
  }
  return true;
}

bool check(const FeatureKernels& kernels, const FeatureKernels& scalar) {
  std::mt19937 random(1);
  for (int width : {37, 48, 63, 64, 65, 100, 129, 200}) {
    const Plane plane = image(width, 60, random);
    for (int floor : {0, 7, 40}) {
      if (!checkCorners(kernels, scalar, plane, floor)) return false;
    }
    for (double scale : {1.0, 1.2, 1.44, 1.9, 2.0}) {
      if (!checkResize(kernels, scalar, plane, static_cast<int>(std::lrint(width / scale)))) return false;
    }
    if (!checkBlur(kernels, scalar, plane) || !checkDescription(kernels, scalar, plane, random)) return false;
  }
  return true;
}

}  // namespace

int main() {
  const FeatureKernels& scalar = featureKernels(SimdLevel::kScalar);
  for (SimdLevel level : {SimdLevel::kNeon, SimdLevel::kAvx2, SimdLevel::kAvx512}) {
    if (!simdLevelSupported(level)) continue;
    if (!check(featureKernels(level), scalar)) {
      std::printf("%s differs from scalar\n", toString(level).c_str());
      return 1;
    }
    std::printf("%s equals scalar\n", toString(level).c_str());
  }
#if defined(__x86_64__)
  for (const bool intel : {false, true}) {  // whichever this processor is
    if (!simdLevelSupported(SimdLevel::kAvx512) || check(detail::avx512FeatureKernels(intel), scalar)) continue;
    std::printf("avx512, for %s, differs from scalar\n", intel ? "Intel" : "AMD");
    return 1;
  }
#endif
  return 0;
}
