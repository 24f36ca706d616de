// The topics of a graph in words: inputs of a wrong type, and where images are published.
#include "input/topics.h"

#include <gtest/gtest.h>

namespace gms_ransac {
namespace {

const Topics kPublished = {{"/camera/image", "sensor_msgs/Image"},
                           {"/camera/image/compressed", "sensor_msgs/CompressedImage"},
                           {"/camera/camera_info", "sensor_msgs/CameraInfo"},
                           {"/phone/image/compressed", "sensor_msgs/CompressedImage"},
                           {"/camera/depth/image", "sensor_msgs/Image"},
                           {"/filter/match_image", "sensor_msgs/Image"},
                           {"/filter/learned_mask", "sensor_msgs/Image"},
                           {"/filter/stats", "gms_ransac/MatchStats"},
                           {"/other/match_image/compressed", "sensor_msgs/CompressedImage"},
                           {"/other/stats", "gms_ransac/MatchStats"}};
const std::vector<InputTopic> kDepthInputs = {{"image", "/camera/image", "sensor_msgs/Image"},
                                              {"depth/image", "/depth/image", "sensor_msgs/Image"}};

TEST(Topics, ImagesElsewhereAreListedWithTheArgumentsThatReadThem) {
  EXPECT_EQ(imagesElsewhere(kPublished, "image", {}),
            "images are published on /camera/depth/image (image:=/camera/depth/image), /camera/image "
            "(image:=/camera/image), /phone/image/compressed (image:=/phone/image, ~image_transport compressed)");
  EXPECT_EQ(imagesElsewhere({}, "image", {}), "no other images are published");
  Topics many;
  for (int i = 0; i < 100; ++i) many["/camera" + std::to_string(i)] = "sensor_msgs/Image";
  const std::string text = imagesElsewhere(many, "image", {});
  EXPECT_LT(text.size(), 400u);
  EXPECT_EQ(text.substr(text.size() - 5), ", ...");
}

TEST(Topics, DepthIsNotSoughtWhereColourIs) {
  EXPECT_EQ(imagesElsewhere(kPublished, "depth/image", kDepthInputs),
            "images are published on /camera/depth/image (depth/image:=/camera/depth/image)");
  EXPECT_EQ(imagesElsewhere({{"/camera/image", "sensor_msgs/Image"}}, "depth/image", kDepthInputs),
            "no other topic with depth in its name has images");
  EXPECT_EQ(imagesElsewhere({{"/left", "sensor_msgs/Image"}, {"/right", "sensor_msgs/Image"}}, "right/image",
                            {{"left/image", "/left", "sensor_msgs/Image"}}),
            "images are published on /right (right/image:=/right)");
}

TEST(Topics, AWrongTypeIsNamedWithBothTypes) {
  EXPECT_EQ(wrongTypes({{"image", "/camera/image", "sensor_msgs/Image"}, {"~mask", "/nobody", "sensor_msgs/Image"}},
                       kPublished),
            "");
  EXPECT_EQ(
      wrongTypes({{"image", "/camera/camera_info", "sensor_msgs/Image"},
                  {"camera_info", "/camera/image", "sensor_msgs/CameraInfo"}},
                 kPublished),
      "input 'image' is remapped to /camera/camera_info, which is a sensor_msgs/CameraInfo; it must be a "
      "sensor_msgs/Image; input 'camera_info' is remapped to /camera/image, which is a sensor_msgs/Image; it must be a "
      "sensor_msgs/CameraInfo");
  const std::string compressed = wrongTypes({{"image", "/phone/image/compressed", "sensor_msgs/Image"}}, kPublished);
  EXPECT_NE(compressed.find("remap it to /phone/image and set ~image_transport to compressed"), std::string::npos)
      << compressed;
}

}  // namespace
}  // namespace gms_ransac
