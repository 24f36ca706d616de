// Compares the residual kernels of every instruction set this processor has with the scalar ones, bit for bit. Free of
// OpenCV and of a test framework, so that it can be cross-compiled; exits with 1 at the first difference.
#include <cstdio>
#include <cstring>
#include <random>
#include <vector>

#include "residual_results.h"

namespace {

using namespace gms_ransac;  // NOLINT: one program, one file

bool check(SimdLevel level, int count, std::mt19937& random) {
  std::uniform_real_distribution<float> uniform(-1, 1);
  PointColumns columns;
  columns.resize(count);
  for (int i = 0; i < count; ++i) {
    columns.x1()[i] = 0.6f * uniform(random);
    columns.y1()[i] = 0.5f * uniform(random);
    columns.x2()[i] = columns.x1()[i] + 0.05f * uniform(random);
    columns.y2()[i] = columns.y1()[i] + 0.02f * uniform(random);
    columns.weight()[i] = 1e4f;
  }
  // A small rotation, a translation mostly along x, and their essential matrix.
  const float a = 0.02f * uniform(random), b = 0.02f * uniform(random), y = 0.2f * uniform(random);
  const PoseParameters pose = {
      {1, -b, a, b, 1, 0, -a, 0, 1},
      {0.9f, y, 0.3f},
      {-0.3f * b - y * a, -0.3f, y, 0.3f + 0.9f * a, -0.3f * b, 0.3f * a - 0.9f, 0.9f * b - y, 0.9f + y * b, -y * a}};
  const float inverse[9] = {1, b, -a, -b, 1, 0, a, 0, 1};
  const auto expected = allResults(residualKernels(SimdLevel::kScalar), columns.view(), pose, pose.R, inverse);
  const auto results = allResults(residualKernels(level), columns.view(), pose, pose.R, inverse);
  return expected.size() == results.size() &&
         std::memcmp(expected.data(), results.data(), expected.size() * sizeof(float)) == 0;
}

}  // namespace

int main() {
  std::mt19937 random(1);
  for (SimdLevel level : {SimdLevel::kNeon, SimdLevel::kAvx2, SimdLevel::kAvx512}) {
    if (!simdLevelSupported(level)) continue;
    for (int count : {0, 1, 7, 16, 33, 64, 65, 257, 1003}) {
      if (check(level, count, random)) continue;
      std::printf("%s differs from scalar at %d matches\n", toString(level).c_str(), count);
      return 1;
    }
    std::printf("%s equals scalar\n", toString(level).c_str());
  }
  return 0;
}
