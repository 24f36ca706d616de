// Images that wait for what belongs to them: in order, each once, nothing taken twice or kept for ever.
#include "input/waiting_images.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <boost/make_shared.hpp>

namespace gms_ransac {
namespace {

template <typename Message>
boost::shared_ptr<Message> stamped(double stamp) {
  auto message = boost::make_shared<Message>();
  message->header.stamp = ros::Time(stamp);
  return message;
}

/// Feeds images and writes down what comes out: the stamp in hundredths of a second, "+" with that of the one of the
/// second stream, "i" for a camera_info, "r" for that of the right camera, and "m" with the stamp of a mask.
class WaitingBench {
 public:
  explicit WaitingBench(const WaitingOptions& options = {}) : second_(options.second), images_(options) {}

  WaitingBench& image(double stamp) {
    images_.add(stamped<sensor_msgs::Image>(stamp), ros::Time(1), now_);
    return collect();
  }
  WaitingBench& second(double stamp) {
    images_.addSecond(stamped<sensor_msgs::Image>(stamp));
    return collect();
  }
  WaitingBench& info(double stamp = 0) {
    images_.addCameraInfo(stamped<sensor_msgs::CameraInfo>(stamp));
    return collect();
  }
  WaitingBench& rightInfo() {
    images_.setRightInfo(boost::make_shared<sensor_msgs::CameraInfo>());
    return collect();
  }
  WaitingBench& mask(double stamp) {
    images_.addMask(stamped<sensor_msgs::Image>(stamp));
    return collect();
  }
  WaitingBench& wait(double seconds) {
    now_ += seconds;
    return collect();
  }
  /// The output since the last call.
  std::string out() { return std::exchange(out_, std::string()); }
  WaitingImages* operator->() { return &images_; }

 private:
  static std::string text(const sensor_msgs::ImageConstPtr& image) {
    return std::to_string(std::lround(100 * image->header.stamp.toSec()));
  }
  WaitingBench& collect() {
    for (const ImageWithInfo& input : images_.settled(now_)) {
      const sensor_msgs::ImageConstPtr partner = second_ != nullptr ? input.*second_ : nullptr;
      out_ += (out_.empty() ? "" : " ") + text(input.image) + (partner ? "+" + text(partner) : "") +
              (input.camera_info ? "i" : "") + (input.right_info ? "r" : "") +
              (input.mask ? "m" + text(input.mask) : "");
    }
    return *this;
  }

  sensor_msgs::ImageConstPtr ImageWithInfo::*second_;
  WaitingImages images_;
  double now_ = 0;
  std::string out_;
};

/// Three at most wait for that.
WaitingOptions waitFor(bool WaitingOptions::*what) {
  WaitingOptions options;
  options.*what = true;
  options.capacity = 3;
  return options;
}

WaitingOptions waitForDepth(size_t capacity = 10) {
  WaitingOptions options;
  options.second = &ImageWithInfo::depth;
  options.capacity = capacity;
  return options;
}

struct WaitForNothing : testing::Test {
  WaitingBench bench;
};
struct WaitForCameraInfo : testing::Test {
  WaitingBench bench{waitFor(&WaitingOptions::for_camera_info)};
};
struct WaitForInfoOfEach : testing::Test {
  WaitingBench bench{waitFor(&WaitingOptions::info_of_each)};
};
struct WaitForMask : testing::Test {
  WaitingBench bench{waitFor(&WaitingOptions::for_mask)};
};
struct WaitForDepth : testing::Test {
  WaitingBench bench{waitForDepth()};
};

TEST_F(WaitForNothing, ImagesComeOutAtOnceWithTheNewest) {
  EXPECT_EQ(bench.image(1).out(), "100");
  EXPECT_EQ(bench.info().image(2).out(), "200i");
  EXPECT_FALSE(bench->gaveUpCameraInfo());
  EXPECT_EQ(bench.mask(0).image(2).image(3).out(), "200im0 300im0");
  EXPECT_EQ(bench.mask(1).mask(2.5).image(4).out(), "400im250");
}

TEST_F(WaitForCameraInfo, TheFirstOfAStereoPairWaitForBothCameras) {
  WaitingOptions options = waitFor(&WaitingOptions::for_camera_info);
  options.for_right_info = true;
  WaitingBench both(options);
  EXPECT_EQ(both.image(1).info().image(2).out(), "");
  EXPECT_EQ(both.rightInfo().out(), "100ir 200ir");
  WaitingBench left_alone(options);
  EXPECT_EQ(left_alone.info().image(1).wait(1).out(), "100i");
  EXPECT_EQ(left_alone.image(2).out(), "200i") << "not again";
}

TEST_F(WaitForCameraInfo, TheFirstImagesWait) {
  EXPECT_EQ(bench.image(1).image(2).wait(0.9).out(), "");
  EXPECT_EQ(bench.info().out(), "100i 200i");
  EXPECT_EQ(bench.image(3).out(), "300i");
  EXPECT_FALSE(bench->gaveUpCameraInfo());
}

TEST_F(WaitForCameraInfo, ImagesWaitInVainOnlyOnce) {
  EXPECT_EQ(bench.image(1).wait(0.5).image(2).wait(0.4).out(), "");
  EXPECT_TRUE(bench->pending()) << "somebody has to ask again";
  EXPECT_EQ(bench.wait(0.1).out(), "100 200");
  EXPECT_FALSE(bench->pending());
  EXPECT_TRUE(bench->gaveUpCameraInfo());
  EXPECT_EQ(bench.image(3).out(), "300");
  EXPECT_EQ(bench.info().image(4).out(), "400i") << "it is taken when it comes after all";
}

TEST_F(WaitForCameraInfo, NoImageWaitsWhenTooManyDo) {
  EXPECT_EQ(bench.image(1).image(2).image(3).out(), "");
  EXPECT_EQ(bench.image(4).out(), "100 200 300 400");
}

TEST_F(WaitForCameraInfo, ImagesAreForgottenOnRequest) {
  bench.image(1)->clear();
  EXPECT_EQ(bench.info().out(), "");
}

TEST_F(WaitForInfoOfEach, AndAreDroppedWithout) {
  EXPECT_EQ(bench.info(1).image(1).image(2).out(), "100i");
  EXPECT_EQ(bench.image(3).out(), "");
  EXPECT_EQ(bench.info(3).out(), "300i") << "that of 2 was lost";
  EXPECT_EQ(bench->unpaired(), 1);
  EXPECT_EQ(bench.image(4).wait(1).out(), "");
  EXPECT_EQ(bench.image(5).image(6).image(7).image(8).info(8).out(), "800i");
  EXPECT_EQ(bench->unpaired(), 5);
  EXPECT_EQ(bench->matched(), 3);
  EXPECT_EQ(bench.image(7.5).info(7.5).out(), "750i") << "overtaken, both";
  EXPECT_EQ(bench.image(1).info(1).out(), "100i") << "the stream starts again";
  EXPECT_FALSE(bench->pending());
}

TEST_F(WaitForMask, ImagesWaitForThatOfTheirStamp) {
  EXPECT_EQ(bench.image(1).image(2).out(), "");
  EXPECT_EQ(bench.mask(1).out(), "100m100");
  EXPECT_EQ(bench.mask(2).mask(3).out(), "200m200");
  EXPECT_EQ(bench.image(3).out(), "300m300") << "the mask came first";
}

TEST_F(WaitForMask, NoImageWaitsForOneThatWasSkipped) {
  EXPECT_EQ(bench.image(1).image(2).mask(2).out(), "100 200m200");
}

TEST_F(WaitForMask, NoImageWaitsLong) {
  EXPECT_EQ(bench.image(1).wait(0.5).image(2).wait(0.5).out(), "100");
  EXPECT_EQ(bench.image(3).image(4).image(5).out(), "200");
  EXPECT_EQ(bench.mask(5).out(), "300 400 500m500");
}

TEST_F(WaitForMask, ImagesWaitAgainWhereTheStampsGoBack) {
  EXPECT_EQ(bench.image(9).mask(9).out(), "900m900");
  EXPECT_EQ(bench.mask(1).image(1).image(2).out(), "100m100");
  EXPECT_EQ(bench.mask(2).out(), "200m200");
}

TEST(WaitForSensors, ButNotForLong) {
  double reached = 0;
  WaitingOptions options;
  options.sensors_reach = [&](const std_msgs::Header& image) { return image.stamp.toSec() <= reached; };
  options.sensor_patience = 0.2;
  options.capacity = 3;
  WaitingBench bench(options);
  EXPECT_EQ(bench.image(1).wait(0.1).out(), "");
  reached = 1;
  EXPECT_EQ(bench.wait(0).out(), "100");
  EXPECT_EQ(bench.image(2).wait(0.1).image(3).wait(0.15).out(), "200 300") << "what follows one in vain does not wait";
  EXPECT_TRUE(bench->gaveUpSensors());
  EXPECT_TRUE(bench->pending()) << "whether they are late still";
  EXPECT_EQ(bench.wait(1).image(4).out(), "400");
  reached = 4;  // within the patience of image 4: late no more
  EXPECT_EQ(bench.wait(0.1).image(5).out(), "");
  EXPECT_FALSE(bench->gaveUpSensors());
  reached = 5;
  EXPECT_EQ(bench.wait(0.1).out(), "500");
  EXPECT_FALSE(bench->pending());
}

TEST(WaitForSensors, WithoutPilingUp) {
  WaitingOptions options;
  options.sensors_reach = [](const std_msgs::Header&) { return false; };
  options.capacity = 2;
  WaitingBench bench(options);
  EXPECT_EQ(bench.image(1).image(2).out(), "");
  EXPECT_EQ(bench.image(3).out(), "100 200 300");
}

TEST_F(WaitForDepth, WhicheverComesFirst) {
  EXPECT_EQ(bench.image(1.00).out(), "");
  EXPECT_EQ(bench.second(1.01).out(), "100+101");
  EXPECT_EQ(bench.second(1.03).out(), "");
  EXPECT_EQ(bench.image(1.03).out(), "103+103");
  EXPECT_EQ(bench->matched(), 2);
}

TEST_F(WaitForDepth, TakesTheNearest) {
  bench.image(1.00).second(0.98);
  EXPECT_EQ(bench.out(), "") << "a nearer one may come";
  EXPECT_EQ(bench.second(1.01).out(), "100+101");
  // Not the one that is nearer to the next image.
  EXPECT_EQ(bench.image(2.00).image(2.03).second(2.02).out(), "200 203+202");
}

TEST_F(WaitForDepth, AnImageWithoutPartnerGoesAloneOnceTheOthersHavePassed) {
  bench.image(1.00).image(1.03).image(1.07);
  EXPECT_EQ(bench.second(1.07).out(), "100 103 107+107");
}

TEST_F(WaitForDepth, OrOnceItHasWaitedLongEnough) {
  EXPECT_EQ(bench.image(1.00).wait(0.9).out(), "");
  EXPECT_EQ(bench.image(1.03).wait(0.2).out(), "100");
  EXPECT_TRUE(bench->pending()) << "somebody has to ask again";
  EXPECT_EQ(bench.wait(0.9).out(), "103");
  EXPECT_FALSE(bench->pending());
  EXPECT_EQ(bench.second(1.00).second(1.03).image(1.07).second(1.07).out(), "107+107") << "too late for two";
}

TEST(WaitForDepthOfFew, OrOnceTooManyWait) {
  WaitingBench bench(waitForDepth(3));
  for (int i = 0; i < 3; ++i) bench.image(1 + 0.1 * i);
  EXPECT_EQ(bench.out(), "");
  EXPECT_EQ(bench.image(1.3).out(), "100");
  EXPECT_EQ(bench.second(1.2).out(), "110 120+120");
  for (int i = 0; i < 1000; ++i) bench.second(2 + 0.1 * i);  // bounded as well
  EXPECT_EQ(bench.out(), "130");
}

TEST(WaitForDepthOfFew, APartnerOnceFoundIsKept) {
  bool reached = false;
  WaitingOptions options = waitForDepth(3);
  options.sensors_reach = [&](const std_msgs::Header&) { return reached; };
  WaitingBench bench(options);
  bench.image(1.00).second(1.00).image(1.03);
  for (int i = 0; i < 10; ++i) bench.second(1.03 + 0.01 * i);  // of a faster camera
  EXPECT_EQ(bench.out(), "");
  reached = true;
  EXPECT_EQ(bench.wait(0.1).out(), "100+100 103+103");
}

TEST(WaitForPartner, HalfOfAPairIsDropped) {
  WaitingOptions options = waitForDepth();
  options.first = &ImageWithInfo::reference;
  options.second = &ImageWithInfo::image;
  EXPECT_EQ(WaitingBench(options).image(1.97).image(2).second(2.01).out(), "201+201");
}

TEST_F(WaitForDepth, SlowPartnersCostTheOthersNothing) {
  for (int i = 0; i < 9; ++i) {
    if (i % 3 == 0) bench.second(1 + 0.03 * i);
    bench.image(1 + 0.03 * i);
  }
  EXPECT_EQ(bench.out(), "100+100 103 106 109+109 112 115 118+118");
  EXPECT_EQ(bench.wait(1).out(), "121 124");
}

TEST_F(WaitForDepth, StreamsThatStartAgain) {
  bench.image(60.00).second(60.00).second(60.03).image(60.06);
  EXPECT_EQ(bench.out(), "6000+6000");
  EXPECT_EQ(bench.image(1.00).out(), "6006") << "of before, and its partner has not come";
  EXPECT_EQ(bench.second(1.00).out(), "100+100");
  EXPECT_EQ(bench.image(1.03).second(1.03).out(), "103+103");
  // The partner's stream first.
  EXPECT_EQ(bench.second(0.50).image(0.50).out(), "50+50");
}

TEST_F(WaitForDepth, StampsFurtherApartThanADurationHolds) {
  bench.image(0).second(4.2e9).image(4.2e9).second(0);
  EXPECT_EQ(bench.wait(1).out(), "0+0 420000000000");
}

TEST(WaitForDepthOfMany, EveryImageOnceAndInOrder) {
  uint32_t random = 1;
  const auto chance = [&](int percent) {
    random = random * 1664525u + 1013904223u;
    return static_cast<int>((random >> 16) % 100) < percent;
  };
  WaitingImages images(waitForDepth());
  std::vector<ros::Time> sent, received;
  const auto collect = [&](double now) {
    for (const ImageWithInfo& input : images.settled(now)) {
      received.push_back(input.image->header.stamp);
      if (!input.depth) continue;
      EXPECT_LE(std::abs((received.back() - input.depth->header.stamp).toSec()), 0.025);
    }
  };
  for (int i = 0; i < 3000; ++i) {
    const double stamp = 1 + i / 30.0;
    if (chance(90)) {
      sent.emplace_back(stamp);
      images.add(stamped<sensor_msgs::Image>(stamp), ros::Time(), stamp);
    }
    if (chance(70)) images.addSecond(stamped<sensor_msgs::Image>(stamp + (chance(50) ? 0.01 : -0.01)));
    collect(stamp);
  }
  collect(1e6);
  EXPECT_EQ(received, sent);
}

}  // namespace
}  // namespace gms_ransac
