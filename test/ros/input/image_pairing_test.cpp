// Images and their partners of about the same stamp: nothing is lost, kept for ever or taken twice.
#include "input/image_pairing.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <boost/make_shared.hpp>

namespace gms_ransac {
namespace {

sensor_msgs::ImageConstPtr at(double stamp) {
  auto image = boost::make_shared<sensor_msgs::Image>();
  image->header.stamp = ros::Time(stamp);
  return image;
}

/// Feeds a pairing and writes down what comes out, as "first+second" or "first" in hundredths of a second.
class Bench {
 public:
  explicit Bench(const PairingOptions& options = {}) : pairing_(options) {}

  Bench& first(double stamp) {
    pairing_.addFirst(at(stamp), now_);
    return collect();
  }
  Bench& second(double stamp) {
    pairing_.addSecond(at(stamp));
    return collect();
  }
  Bench& wait(double seconds) {
    now_ += seconds;
    return collect();
  }
  /// The output since the last call.
  std::string out() { return std::exchange(out_, std::string()); }
  ImagePairing* operator->() { return &pairing_; }

 private:
  Bench& collect() {
    for (const ImagePair& pair : pairing_.settled(now_)) {
      out_ += (out_.empty() ? "" : " ") + text(pair.first) + (pair.second ? "+" + text(pair.second) : "");
    }
    return *this;
  }
  static std::string text(const sensor_msgs::ImageConstPtr& image) {
    return std::to_string(std::lround(100 * image->header.stamp.toSec()));
  }

  ImagePairing pairing_;
  double now_ = 0;
  std::string out_;
};

TEST(ImagePairing, WhicheverComesFirst) {
  Bench bench;
  EXPECT_EQ(bench.first(1.00).out(), "");
  EXPECT_EQ(bench.second(1.01).out(), "100+101");
  EXPECT_EQ(bench.second(1.03).out(), "");
  EXPECT_EQ(bench.first(1.03).out(), "103+103");
}

TEST(ImagePairing, TakesTheNearest) {
  Bench bench;
  bench.first(1.00).second(0.98);
  EXPECT_EQ(bench.out(), "") << "a nearer one may come";
  EXPECT_EQ(bench.second(1.01).out(), "100+101");
  // Not the one that is nearer to the next image.
  EXPECT_EQ(bench.first(2.00).first(2.03).second(2.02).out(), "200 203+202");
}

TEST(ImagePairing, AnImageWithoutPartnerGoesAloneOnceTheOthersHavePassed) {
  Bench bench;
  bench.first(1.00).first(1.03).first(1.07);
  EXPECT_EQ(bench.second(1.07).out(), "100 103 107+107");
}

TEST(ImagePairing, OrOnceItHasWaitedLongEnough) {
  Bench bench;
  EXPECT_EQ(bench.first(1.00).wait(0.9).out(), "");
  EXPECT_EQ(bench.first(1.03).wait(0.2).out(), "100");
  EXPECT_TRUE(bench->pending()) << "somebody has to ask again";
  EXPECT_EQ(bench.wait(0.9).out(), "103");
  EXPECT_FALSE(bench->pending());
  EXPECT_EQ(bench.second(1.00).second(1.03).first(1.07).second(1.07).out(), "107+107") << "too late for two";
}

TEST(ImagePairing, OrOnceTooManyWait) {
  PairingOptions options;
  options.capacity = 3;
  Bench bench(options);
  for (int i = 0; i < 3; ++i) bench.first(1 + 0.1 * i);
  EXPECT_EQ(bench.out(), "");
  EXPECT_EQ(bench.first(1.3).out(), "100");
  EXPECT_EQ(bench.second(1.2).out(), "110 120+120");
  for (int i = 0; i < 1000; ++i) bench.second(2 + 0.1 * i);  // bounded as well
  EXPECT_EQ(bench.out(), "130");
}

TEST(ImagePairing, SlowPartnersCostTheOthersNothing) {
  Bench bench;
  for (int i = 0; i < 9; ++i) {
    if (i % 3 == 0) bench.second(1 + 0.03 * i);
    bench.first(1 + 0.03 * i);
  }
  EXPECT_EQ(bench.out(), "100+100 103 106 109+109 112 115 118+118");
  EXPECT_EQ(bench.wait(1).out(), "121 124");
}

TEST(ImagePairing, StreamsThatStartAgain) {
  Bench bench;
  bench.first(60.00).second(60.00).second(60.03).first(60.06);
  EXPECT_EQ(bench.out(), "6000+6000");
  EXPECT_EQ(bench.first(1.00).out(), "6006") << "of before, and its partner has not come";
  EXPECT_EQ(bench.second(1.00).out(), "100+100");
  EXPECT_EQ(bench.first(1.03).second(1.03).out(), "103+103");
  // The partner's stream first.
  EXPECT_EQ(bench.second(0.50).first(0.50).out(), "50+50");
}

TEST(ImagePairing, StampsFurtherApartThanADurationHolds) {
  Bench bench;
  bench.first(0).second(4.2e9).first(4.2e9).second(0);
  EXPECT_EQ(bench.wait(1).out(), "0+0 420000000000");
}

TEST(ImagePairing, EveryImageOnceAndInOrder) {
  uint32_t random = 1;
  const auto chance = [&](int percent) {
    random = random * 1664525u + 1013904223u;
    return static_cast<int>((random >> 16) % 100) < percent;
  };
  ImagePairing pairing{PairingOptions()};
  std::vector<double> sent, received;
  const auto collect = [&](double now) {
    for (const ImagePair& pair : pairing.settled(now)) {
      received.push_back(pair.first->header.stamp.toSec());
      if (!pair.second) continue;
      EXPECT_LE(std::abs((pair.first->header.stamp - pair.second->header.stamp).toSec()), 0.025);
    }
  };
  for (int i = 0; i < 3000; ++i) {
    const double stamp = 1 + i / 30.0;
    if (chance(90)) {
      pairing.addFirst(at(stamp), stamp);
      sent.push_back(at(stamp)->header.stamp.toSec());
    }
    if (chance(70)) pairing.addSecond(at(stamp + (chance(50) ? 0.01 : -0.01)));
    collect(stamp);
  }
  collect(1e6);
  EXPECT_EQ(received, sent);
}

}  // namespace
}  // namespace gms_ransac
