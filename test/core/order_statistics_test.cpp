#include "support/order_statistics.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace gms_ransac {
namespace {

void expectSorted(const std::vector<float>& values) {
  std::vector<float> sorted = values, rearranged = values;
  std::sort(sorted.begin(), sorted.end());
  for (size_t n = 0; n < values.size(); ++n) ASSERT_EQ(nthSmallest(rearranged, n), sorted[n]) << n;
  const std::array<size_t, 3> places = {values.size() / 3, values.size() / 3, values.size() - 1};
  const std::array<float, 3> several = smallest<3>(rearranged, places);
  for (size_t k = 0; k < 3; ++k) EXPECT_EQ(several[k], sorted[places[k]]);
  std::sort(rearranged.begin(), rearranged.end());
  EXPECT_EQ(rearranged, sorted);  // none is lost
}

TEST(NthSmallest, IsThatOfTheSortedValues) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  for (const int size : {1, 2, 3, 100, 777}) {
    std::vector<float> wide, narrow, alike;
    for (int i = 0; i < size; ++i) {
      wide.push_back(std::exp(10 * normal(random)) * (random() % 2 ? 1.f : -1.f));
      narrow.push_back(3 + 0.01f * normal(random));
      alike.push_back(static_cast<float>(random() % 3));
    }
    for (const auto* values : {&wide, &narrow, &alike}) expectSorted(*values);
  }
}

TEST(NthSmallest, TakesZerosAndWhatIsBeyondAllNumbers) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity(), kTiny = std::numeric_limits<float>::denorm_min();
  expectSorted({kInfinity, 1, 0, -kInfinity, kTiny, -kTiny, std::numeric_limits<float>::max(), 0, -1});
}

}  // namespace
}  // namespace gms_ransac
