// Images between nodelets of one manager are shared, not copied: what the publisher sent and what a subscriber in the
// same process got is one object, and the converter's grey image is that object's memory. Reports messages that do not
// arrive. The match image is drawn only for a subscriber.
#include <gtest/gtest.h>
#include <image_transport/image_transport.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <sensor_msgs/Image.h>

#include "input/image_conversion.h"
#include "input/image_input.h"
#include "output/outputs.h"
#include "processor_stream.h"

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

  const sensor_msgs::ImageConstPtr sent = imageMessage(cv::Mat(96, 128, CV_8UC1, cv::Scalar(7)), 1);
  const ros::WallTime end = ros::WallTime::now() + ros::WallDuration(30);
  while (!received.image && ros::WallTime::now() < end) {
    if (publisher.getNumSubscribers() > 0) publisher.publish(sent);
    ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.1));
  }
  ASSERT_TRUE(received.image);
  EXPECT_EQ(received.image.get(), sent.get());
  cv::Mat grey;
  ASSERT_EQ(toGrey(*received.image, grey), "");
  EXPECT_EQ(grey.data, sent->data.data());
  input.stop();
}

TEST(ImageInput, SaysWhatDoesNotArrive) {
  const std::string start = "start the camera or the bag, or remap ", to = " to its topic: no other ",
                    none = to + "images are published", no_length = "; images are answered without a length";
  Parameters exact, depth, pair;
  exact.camera_info_sync = CameraInfoSync::kExact;
  depth.scale = ScaleMode::kDepth;
  pair.input = InputKind::kPair;
  const struct {
    std::string name;
    Parameters parameters;
    std::vector<std::pair<std::string, double>> published;  ///< topics, with the stamp of their image; 0: without one
    std::string words;
  } rows[] = {
      {"a", {}, {}, "nobody publishes /a/image; " + start + "'image'" + none},
      {"b", {}, {{"image", 0}}, "no image arrives on /b/image, although it has a publisher; check it with rostopic hz"},
      {"c",
       exact,
       {{"image", 5}},
       "no image of /c/image has a camera_info of the same stamp on /c/camera_info: 1 images (last stamp 5.000000000) "
       "and 0 camera_info (last stamp 0.000000000) came; set ~camera_info_sync to latest if their stamps differ"},
      {"d",
       depth,
       {{"image", 5}},
       "nobody publishes /d/depth/image; " + start + "'depth/image'" + to + "topic with depth in its name has images" +
           no_length},
      {"e",
       depth,
       {{"image", 5}, {"depth/image", 6}},
       "no image of /e/image (last stamp 5.000000000) has a partner within 0.025 s on /e/depth/image" + no_length},
      {"f", pair, {{"reference/image", 5}}, "nobody publishes /f/current/image; " + start + "'current/image'" + none}};
  for (const auto& row : rows) {
    ros::NodeHandle nh("/" + row.name);
    ImageInput input(
        nh, nh, row.parameters, [](const ImageWithInfo&) {}, nullptr);
    input.start();
    std::vector<ros::Publisher> publishers;
    for (const auto& [topic, stamp] : row.published) publishers.push_back(nh.advertise<sensor_msgs::Image>(topic, 1));
    std::string said;
    const ros::WallTime end = ros::WallTime::now() + ros::WallDuration(30);
    while (said != row.words && ros::WallTime::now() < end) {
      for (size_t i = 0; i < publishers.size(); ++i) {
        const double stamp = row.published[i].second;
        if (stamp > 0 && publishers[i].getNumSubscribers() > 0)
          publishers[i].publish(imageMessage(cv::Mat(96, 128, CV_8UC1, cv::Scalar(7)), stamp));
      }
      ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.1));
      said = input.waitingFor({});
    }
    EXPECT_EQ(said, row.words);
    input.stop();
  }
}

TEST(ImageInput, LeavesAPublisherThatHasJustComeTimeToSend) {
  ros::NodeHandle nh("/late");
  ImageInput input(
      nh, nh, Parameters(), [](const ImageWithInfo&) {}, nullptr);
  input.start();
  EXPECT_NE(input.waitingFor({}).find("nobody publishes /late/image"), std::string::npos);
  const Topics published = {{"/late/image", "sensor_msgs/Image"}};
  EXPECT_EQ(input.waitingFor(published), "");
  EXPECT_NE(input.waitingFor(published).find("no image arrives on /late/image"), std::string::npos);
  input.stop();
}

/// Counts the images that OpenCV allocates.
struct CountingAllocator : cv::MatAllocator {
  cv::UMatData* allocate(int dimensions, const int* sizes, int type, void* data, size_t* step, cv::AccessFlag flags,
                         cv::UMatUsageFlags usage) const override {
    ++images;
    return cv::Mat::getStdAllocator()->allocate(dimensions, sizes, type, data, step, flags, usage);
  }
  bool allocate(cv::UMatData* data, cv::AccessFlag flags, cv::UMatUsageFlags usage) const override {
    return cv::Mat::getStdAllocator()->allocate(data, flags, usage);
  }
  void deallocate(cv::UMatData* data) const override { cv::Mat::getStdAllocator()->deallocate(data); }

  mutable int images = 0;
};

TEST(MatchImage, IsDrawnOnlyForASubscriber) {
  ros::NodeHandle nh, pnh("~");
  Outputs outputs(nh, pnh, Parameters(), [] {});
  auto frame = std::make_shared<PreparedFrame>();
  frame->image.grey = cv::Mat(480, 640, CV_8UC1, cv::Scalar(90));
  frame->image.camera = std::make_shared<CameraModel>();
  ProcessedFrame processed;
  processed.current = frame;
  CountingAllocator counter;
  cv::Mat::setDefaultAllocator(&counter);
  for (int i = 0; i < 10; ++i) outputs.publish(processed, {}, {});
  EXPECT_EQ(0, counter.images);
  sensor_msgs::ImageConstPtr picture;
  const ros::Subscriber subscriber = pnh.subscribe<sensor_msgs::Image>(
      "match_image", 1, [&](const sensor_msgs::ImageConstPtr& message) { picture = message; });
  const ros::WallTime end = ros::WallTime::now() + ros::WallDuration(30);
  while (!picture && ros::WallTime::now() < end) {
    outputs.publish(processed, {}, {});
    ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.1));
  }
  cv::Mat::setDefaultAllocator(cv::Mat::getStdAllocator());
  ASSERT_TRUE(picture);
  EXPECT_EQ("bgr8", picture->encoding);
  EXPECT_GT(picture->height, 480U);
  EXPECT_GT(counter.images, 0);
}

}  // namespace
}  // namespace gms_ransac

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "zero_copy_test");
  return RUN_ALL_TESTS();
}
