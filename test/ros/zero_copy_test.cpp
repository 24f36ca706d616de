// Images between nodelets of one manager are shared, not copied: what the publisher sent and what a subscriber in the
// same process got is one object, and the converter's grey image is that object's memory.
#include <gtest/gtest.h>
#include <image_transport/image_transport.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <sensor_msgs/Image.h>

#include "input/image_conversion.h"
#include "input/image_input.h"

namespace gms_ransac {
namespace {

TEST(ZeroCopy, FromThePublishersHandsToTheExtractor) {
  ros::NodeHandle nh, pnh("~");
  image_transport::ImageTransport transport(nh);
  image_transport::Publisher publisher = transport.advertise("image", 1);
  ImageWithInfo received;
  ImageInput input(
      nh, pnh, Parameters(), [&](const ImageWithInfo& image) { received = image; }, nullptr);
  input.start();

  auto sent = boost::make_shared<sensor_msgs::Image>();
  sent->width = 128;
  sent->height = 96;
  sent->step = 128;
  sent->encoding = "mono8";
  sent->data.resize(128 * 96, 7);
  const ros::WallTime end = ros::WallTime::now() + ros::WallDuration(30);
  while (!received.image && ros::WallTime::now() < end) {
    if (publisher.getNumSubscribers() > 0) publisher.publish(sensor_msgs::ImageConstPtr(sent));
    ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.1));
  }
  ASSERT_TRUE(received.image);
  EXPECT_EQ(received.image.get(), sent.get());
  cv::Mat grey;
  ASSERT_EQ(ImageConverter().toGrey(*received.image, grey), "");
  EXPECT_EQ(grey.data, sent->data.data());
  input.stop();
}

}  // namespace
}  // namespace gms_ransac

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "zero_copy_test");
  return RUN_ALL_TESTS();
}
