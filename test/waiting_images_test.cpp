// Images that wait for what belongs to them: in order, each once, and never for long.
#include "waiting_images.h"

#include <cmath>
#include <string>
#include <utility>

#include <gtest/gtest.h>
#include <boost/make_shared.hpp>

namespace gms_ransac {
namespace {

/// Feeds images and writes down what comes out: the stamp in hundredths of a second, "i" for a camera_info and "m" with
/// the stamp of a mask.
class Bench {
 public:
  explicit Bench(const WaitingOptions& options) : images_(options) {}

  Bench& image(double stamp, bool with_info = false) {
    auto image = boost::make_shared<sensor_msgs::Image>();
    image->header.stamp = ros::Time(stamp);
    ImageWithInfo input;
    input.image = image;
    if (with_info) input.camera_info = boost::make_shared<sensor_msgs::CameraInfo>();
    images_.add(input, now_);
    return collect();
  }
  Bench& info() {
    images_.setCameraInfo(boost::make_shared<sensor_msgs::CameraInfo>());
    return collect();
  }
  Bench& mask(double stamp) {
    auto mask = boost::make_shared<sensor_msgs::Image>();
    mask->header.stamp = ros::Time(stamp);
    images_.addMask(mask);
    return collect();
  }
  Bench& wait(double seconds) {
    now_ += seconds;
    return collect();
  }
  /// What came out since the last call.
  std::string out() { return std::exchange(out_, std::string()); }
  WaitingImages* operator->() { return &images_; }

 private:
  Bench& collect() {
    for (const ImageWithInfo& input : images_.settled(now_)) {
      out_ += (out_.empty() ? "" : " ") + std::to_string(std::lround(100 * input.image->header.stamp.toSec())) +
              (input.camera_info ? "i" : "") +
              (input.mask ? "m" + std::to_string(std::lround(100 * input.mask->header.stamp.toSec())) : "");
    }
    return *this;
  }

  WaitingImages images_;
  double now_ = 0;
  std::string out_;
};

WaitingOptions forCameraInfo() {
  WaitingOptions options;
  options.for_camera_info = true;
  options.capacity = 3;
  return options;
}

TEST(WaitingImages, ThatNeedNothingComeOutAtOnce) {
  Bench bench{WaitingOptions()};
  EXPECT_EQ(bench.image(1).out(), "100");
  EXPECT_EQ(bench.info().image(2).out(), "200i");
  EXPECT_FALSE(bench->gaveUpCameraInfo());
}

TEST(WaitingImages, TheFirstWaitForCameraInfo) {
  Bench bench(forCameraInfo());
  EXPECT_EQ(bench.image(1).image(2).wait(0.9).out(), "");
  EXPECT_EQ(bench.info().out(), "100i 200i");
  EXPECT_EQ(bench.image(3).out(), "300i");
  EXPECT_FALSE(bench->gaveUpCameraInfo());
}

TEST(WaitingImages, WaitInVainForCameraInfoOnlyOnce) {
  Bench bench(forCameraInfo());
  EXPECT_EQ(bench.image(1).wait(0.5).image(2).wait(0.5).out(), "100 200");
  EXPECT_TRUE(bench->gaveUpCameraInfo());
  EXPECT_EQ(bench.image(3).out(), "300");
  EXPECT_EQ(bench.info().image(4).out(), "400i") << "it is taken when it comes after all";
}

TEST(WaitingImages, DoNotWaitWhenTooManyDo) {
  Bench bench(forCameraInfo());
  EXPECT_EQ(bench.image(1).image(2).image(3).out(), "");
  EXPECT_EQ(bench.image(4).out(), "100 200 300 400");
}

TEST(WaitingImages, KeepTheirOwnCameraInfo) {
  Bench bench(forCameraInfo());
  EXPECT_EQ(bench.image(1, true).out(), "100i");
}

TEST(WaitingImages, TakeTheNewestMask) {
  Bench bench{WaitingOptions()};
  EXPECT_EQ(bench.image(1).out(), "100");
  EXPECT_EQ(bench.mask(0).image(2).image(3).out(), "200m0 300m0");
  EXPECT_EQ(bench.mask(1).mask(2.5).image(4).out(), "400m250");
}

WaitingOptions forMask() {
  WaitingOptions options;
  options.for_mask = true;
  options.capacity = 3;
  return options;
}

TEST(WaitingImages, WaitForTheMaskOfTheirStamp) {
  Bench bench(forMask());
  EXPECT_EQ(bench.image(1).image(2).out(), "");
  EXPECT_EQ(bench.mask(1).out(), "100m100");
  EXPECT_EQ(bench.mask(2).mask(3).out(), "200m200");
  EXPECT_EQ(bench.image(3).out(), "300m300") << "the mask came first";
}

TEST(WaitingImages, DoNotWaitForAMaskThatWasSkipped) {
  Bench bench(forMask());
  EXPECT_EQ(bench.image(1).image(2).mask(2).out(), "100 200m200");
}

TEST(WaitingImages, DoNotWaitLongForAMask) {
  Bench bench(forMask());
  EXPECT_EQ(bench.image(1).wait(0.5).image(2).wait(0.5).out(), "100");
  EXPECT_EQ(bench.image(3).image(4).image(5).out(), "200");
  EXPECT_EQ(bench.mask(5).out(), "300 400 500m500");
}

TEST(WaitingImages, WaitAgainWhereTheStampsGoBack) {
  Bench bench(forMask());
  EXPECT_EQ(bench.image(9).mask(9).out(), "900m900");
  EXPECT_EQ(bench.mask(1).image(1).image(2).out(), "100m100");
  EXPECT_EQ(bench.mask(2).out(), "200m200");
}

TEST(WaitingImages, WaitForSensorsButNotForLong) {
  double reached = 0;
  WaitingOptions options;
  options.sensors_reach = [&](const std_msgs::Header& image) { return image.stamp.toSec() <= reached; };
  options.sensor_patience = 0.2;
  options.capacity = 3;
  Bench bench(options);
  EXPECT_EQ(bench.image(1).wait(0.1).out(), "");
  reached = 1;
  EXPECT_EQ(bench.wait(0).out(), "100");
  EXPECT_EQ(bench.image(2).wait(0.1).image(3).wait(0.15).out(), "200 300") << "what follows one in vain does not wait";
  EXPECT_TRUE(bench->gaveUpSensors());
  EXPECT_EQ(bench.wait(1).image(4).out(), "400");
  reached = 4;  // within the patience of image 4: late no more
  EXPECT_EQ(bench.wait(0.1).image(5).out(), "");
  EXPECT_FALSE(bench->gaveUpSensors());
  reached = 5;
  EXPECT_EQ(bench.wait(0.1).out(), "500");
}

TEST(WaitingImages, DoNotPileUpBehindSensors) {
  WaitingOptions options;
  options.sensors_reach = [](const std_msgs::Header&) { return false; };
  options.capacity = 2;
  Bench bench(options);
  EXPECT_EQ(bench.image(1).image(2).out(), "");
  EXPECT_EQ(bench.image(3).out(), "100 200 300");
}

TEST(WaitingImages, AreForgottenOnRequest) {
  Bench bench(forCameraInfo());
  bench.image(1)->clear();
  EXPECT_EQ(bench.info().out(), "");
}

}  // namespace
}  // namespace gms_ransac
