// Images that wait for what belongs to them: in order, each once, and never for long.
#include "input/waiting_images.h"

#include <cmath>
#include <string>
#include <utility>

#include <gtest/gtest.h>
#include <boost/make_shared.hpp>

namespace gms_ransac {
namespace {

/// Feeds images and writes down what comes out: the stamp in hundredths of a second, "i" for a camera_info, "r" for
/// that of the right camera, and "m" with the stamp of a mask.
class WaitingBench {
 public:
  explicit WaitingBench(const WaitingOptions& options) : images_(options) {}

  WaitingBench& image(double stamp, bool with_info = false) {
    ImageWithInfo input;
    input.image = stamped(stamp);
    if (with_info) input.camera_info = boost::make_shared<sensor_msgs::CameraInfo>();
    images_.add(input, now_);
    return collect();
  }
  WaitingBench& info() {
    images_.setCameraInfo(boost::make_shared<sensor_msgs::CameraInfo>());
    return collect();
  }
  WaitingBench& rightInfo() {
    images_.setRightInfo(boost::make_shared<sensor_msgs::CameraInfo>());
    return collect();
  }
  WaitingBench& mask(double stamp) {
    images_.addMask(stamped(stamp));
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
  static sensor_msgs::ImageConstPtr stamped(double stamp) {
    auto image = boost::make_shared<sensor_msgs::Image>();
    image->header.stamp = ros::Time(stamp);
    return image;
  }
  WaitingBench& collect() {
    for (const ImageWithInfo& input : images_.settled(now_)) {
      out_ += (out_.empty() ? "" : " ") + std::to_string(std::lround(100 * input.image->header.stamp.toSec())) +
              (input.camera_info ? "i" : "") + (input.right_info ? "r" : "") +
              (input.mask ? "m" + std::to_string(std::lround(100 * input.mask->header.stamp.toSec())) : "");
    }
    return *this;
  }

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

struct WaitForNothing : testing::Test {
  WaitingBench bench{WaitingOptions()};
};
struct WaitForCameraInfo : testing::Test {
  WaitingBench bench{waitFor(&WaitingOptions::for_camera_info)};
};
struct WaitForMask : testing::Test {
  WaitingBench bench{waitFor(&WaitingOptions::for_mask)};
};

TEST_F(WaitForNothing, ImagesComeOutAtOnce) {
  EXPECT_EQ(bench.image(1).out(), "100");
  EXPECT_EQ(bench.info().image(2).out(), "200i");
  EXPECT_FALSE(bench->gaveUpCameraInfo());
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

TEST_F(WaitForCameraInfo, ImagesKeepTheirOwn) { EXPECT_EQ(bench.image(1, true).out(), "100i"); }

TEST_F(WaitForNothing, ImagesTakeTheNewestMask) {
  EXPECT_EQ(bench.image(1).out(), "100");
  EXPECT_EQ(bench.mask(0).image(2).image(3).out(), "200m0 300m0");
  EXPECT_EQ(bench.mask(1).mask(2.5).image(4).out(), "400m250");
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

TEST_F(WaitForCameraInfo, ImagesAreForgottenOnRequest) {
  bench.image(1)->clear();
  EXPECT_EQ(bench.info().out(), "");
}

}  // namespace
}  // namespace gms_ransac
