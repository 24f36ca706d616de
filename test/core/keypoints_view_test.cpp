// The consumer's view of ~keypoints: no copy, features to match by, and one sentence for every malformed message.
#include "gms_ransac/keypoints_view.h"

#include <array>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "gms_ransac/hamming_matcher.h"

namespace gms_ransac {
namespace {

/// The fields of gms_ransac/Keypoints that the view reads.
struct KeypointsMessage {
  enum { PIXELS_RAW = 0, PIXELS_RECTIFIED = 1 };
  uint32_t width = 640, height = 480;
  uint8_t pixel_space = PIXELS_RECTIFIED;
  std::array<double, 9> K{{500, 0, 320, 0, 501, 240, 0, 0, 1}};
  float scale_factor = 1.2f;
  std::vector<float> u{-0.5f, 100, 639.5f}, v{0, 50.25f, 479.5f};
  std::vector<uint8_t> octave{0, 3, 15};
  std::vector<float> size{31, 44, 60}, angle{0, 90, 359}, response{10, 20, 30}, sigma{0.3f, 0.4f, 0}, depth{2, 0, 5};
  std::vector<uint32_t> track_id{0, 7, 8};
  std::vector<uint8_t> descriptors = std::vector<uint8_t>(3 * kDescriptorBytes);
};

std::string complaint(const std::function<void(KeypointsMessage&)>& spoil) {
  KeypointsMessage message;
  spoil(message);
  try {
    KeypointsView<KeypointsMessage> view(message);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(KeypointsView, ShowsTheColumnsWithoutACopy) {
  const KeypointsMessage message;
  const KeypointsView<KeypointsMessage> view(message);
  ASSERT_EQ(view.size(), 3);
  EXPECT_EQ(view.u().data(), message.u.data());
  EXPECT_EQ(view.sigma()[1], 0.4f);
  EXPECT_EQ(view.depth()[2], 5);
  EXPECT_EQ(view.descriptors().rows, 3);
  EXPECT_EQ(view.descriptors().ptr(), message.descriptors.data());
  EXPECT_EQ(view.keypoint(1).pt, cv::Point2f(100, 50.25f));
  EXPECT_EQ(view.keypoint(1).class_id, 7);
  EXPECT_TRUE(view.calibrated());
  EXPECT_TRUE(view.isRectified());
  EXPECT_EQ(view.K()(1, 1), 501);
}

TEST(KeypointsView, MakesFeaturesToMatchBy) {
  KeypointsMessage message;
  message.descriptors[0] = 1;
  message.descriptors[kDescriptorBytes] = 2;
  message.descriptors[2 * kDescriptorBytes] = 12;
  const Features features = KeypointsView<KeypointsMessage>(message).features();
  EXPECT_EQ(features.image_size, cv::Size(640, 480));
  EXPECT_EQ(features.keypoints[2].octave, 15);
  std::vector<Match> matches;
  HammingMatcher().match(features.descriptors, features.descriptors, matches);
  ASSERT_EQ(matches.size(), 3u);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(matches[static_cast<size_t>(i)].current, i);
  EXPECT_EQ(matches[0].second_distance, 2);
}

TEST(KeypointsView, TakesAnEmptyMessage) {
  KeypointsMessage message;
  message.u.clear();
  message.v.clear();
  message.octave.clear();
  message.track_id.clear();
  message.descriptors.clear();
  for (auto* column : {&message.size, &message.angle, &message.response, &message.sigma, &message.depth})
    column->clear();
  const KeypointsView<KeypointsMessage> view(message);
  EXPECT_EQ(view.size(), 0);
  EXPECT_FALSE(view.hasDepth());
  EXPECT_EQ(view.depth().size(), 0);
  EXPECT_EQ(view.features().size(), 0);
}

TEST(KeypointsView, NamesWhatIsMalformed) {
  EXPECT_EQ(complaint([](KeypointsMessage&) {}), "");
  EXPECT_EQ(complaint([](KeypointsMessage& m) { m.v.pop_back(); }),
            "Keypoints: v has 2 entries, but 3 belong to this many keypoints (u)");
  EXPECT_NE(complaint([](KeypointsMessage& m) { m.octave.push_back(0); }).find("octave has 4"), std::string::npos);
  EXPECT_NE(complaint([](KeypointsMessage& m) { m.size.clear(); }).find("size has 0"), std::string::npos);
  EXPECT_NE(complaint([](KeypointsMessage& m) { m.angle.clear(); }).find("angle has 0"), std::string::npos);
  EXPECT_NE(complaint([](KeypointsMessage& m) { m.response.clear(); }).find("response has 0"), std::string::npos);
  EXPECT_NE(complaint([](KeypointsMessage& m) { m.sigma.clear(); }).find("sigma has 0"), std::string::npos);
  EXPECT_NE(complaint([](KeypointsMessage& m) { m.track_id.clear(); }).find("track_id has 0"), std::string::npos);
  EXPECT_NE(complaint([](KeypointsMessage& m) { m.depth.pop_back(); }).find("depth has 2"), std::string::npos);
  EXPECT_NE(complaint([](KeypointsMessage& m) { m.descriptors.pop_back(); }).find("descriptors has 95 entries, but 96"),
            std::string::npos);
  EXPECT_EQ(complaint([](KeypointsMessage& m) { m.octave[1] = 16; }), "Keypoints: keypoint 1 has no possible octave");
  EXPECT_EQ(complaint([](KeypointsMessage& m) { m.width = 4000000000u; }),
            "Keypoints: the image has an impossible size");
  EXPECT_EQ(complaint([](KeypointsMessage& m) { m.scale_factor = 0; }), "Keypoints: scale_factor is not above 1");
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const float outside : {nan, -1.f, 640.f, 1e30f}) {
    EXPECT_EQ(complaint([=](KeypointsMessage& m) { m.u[2] = outside; }),
              "Keypoints: keypoint 2 lies outside the image");
    EXPECT_EQ(complaint([=](KeypointsMessage& m) { m.v[0] = outside; }),
              "Keypoints: keypoint 0 lies outside the image");
  }
}

}  // namespace
}  // namespace gms_ransac
