// The numbers of a record.
#include "run/record.h"

#include <cmath>
#include <cstring>

#include <gtest/gtest.h>
#include <opencv2/core/utility.hpp>

namespace gms_ransac {
namespace {

TEST(Record, NumbersHaveTheNineDigitsThatPrintfGivesThem) {
  cv::RNG random(1);
  for (int i = 0; i < 200000; ++i) {
    const auto bits = static_cast<uint32_t>(random.next());
    float value = 0;
    std::memcpy(&value, &bits, sizeof value);                                                         // of any size
    if (i % 2 == 0) value = std::ldexp(static_cast<float>(bits >> 8), -static_cast<int>(bits % 40));  // 2^-40 to 2^24
    if (!std::isfinite(value)) continue;
    ASSERT_EQ(shortest(value), std::stod(cv::format("%.9g", static_cast<double>(value)))) << value;
    ASSERT_EQ(static_cast<float>(shortest(value)), value);
  }
  EXPECT_EQ(shortest(0), 0);
}

}  // namespace
}  // namespace gms_ransac
