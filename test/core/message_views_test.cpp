// The consumer's view of a message: no copy, checked once with a sentence for what is malformed, same numbers.
#include "gms_ransac/camera.h"
#include "gms_ransac/correspondences_view.h"
#include "gms_ransac/keypoints_view.h"

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "gms_ransac/hamming_matcher.h"
#include "says.h"

namespace gms_ransac {
namespace {

/// How a message is spoilt, and the words of the view of it.
template <typename Message>
using Complaints = std::vector<std::pair<std::function<void(Message&)>, std::string>>;

template <typename View, typename Message>
void expectComplaints(const Complaints<Message>& cases) {
  for (const auto& [spoil, complaint] : cases) {
    Message message;
    spoil(message);
    try {
      View view(message);
      ADD_FAILURE() << "no complaint: " << complaint;
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(complaint), std::string::npos) << error.what();
    }
  }
}

/// The fields of gms_ransac/Keypoints that the view reads.
struct KeypointsMessage {
  enum { PIXELS_RAW = 0, PIXELS_RECTIFIED = 1 };
  enum { DESCRIPTOR_BINARY = 0, DESCRIPTOR_FLOAT32 = 1 };
  uint32_t width = 640, height = 480;
  uint8_t pixel_space = PIXELS_RECTIFIED;
  std::array<double, 9> K{{500, 0, 320, 0, 501, 240, 0, 0, 1}};
  float scale_factor = 1.2f;
  std::vector<float> u{-0.5f, 100, 639.5f}, v{0, 50.25f, 479.5f};
  std::vector<uint8_t> octave{0, 3, 15};
  std::vector<float> size{31, 44, 60}, angle{0, 90, 359}, response{10, 20, 30}, sigma{0.3f, 0.4f, 0}, depth{2, 0, 5};
  std::vector<uint32_t> track_id{0, 7, 8};
  uint8_t descriptor_type = DESCRIPTOR_BINARY;
  uint32_t descriptor_size = kDescriptorBytes;
  std::vector<uint8_t> descriptors = std::vector<uint8_t>(3 * kDescriptorBytes);
};

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

TEST(KeypointsView, ShowsDescriptorsOfAnyLengthAndFloats) {
  KeypointsMessage message;
  message.descriptor_size = 61;
  message.descriptors.assign(3 * 61, 0);
  message.descriptors[2 * 61 + 5] = 9;
  const KeypointsView<KeypointsMessage> view(message);
  ASSERT_EQ(view.descriptors().cols, 61);
  EXPECT_EQ(view.descriptors().at<uint8_t>(2, 5), 9);
  EXPECT_EQ(view.features().descriptors.kind(), "61 bytes");

  message.descriptor_type = KeypointsMessage::DESCRIPTOR_FLOAT32;
  message.descriptor_size = 8;
  const float numbers[] = {1, 2, 3, 4, 5, -0.5f};
  const auto* bytes = reinterpret_cast<const uint8_t*>(numbers);
  message.descriptors.assign(bytes, bytes + sizeof(numbers));
  ASSERT_EQ(view.descriptors().cols, 2);
  EXPECT_EQ(view.descriptors().at<float>(2, 1), -0.5f);
  EXPECT_EQ(view.features().descriptors.kind(), "2 floats");
}

TEST(KeypointsView, NeedsNoMoreThanPlacesAndDescriptors) {
  KeypointsMessage message;
  for (auto* column : {&message.size, &message.angle, &message.response, &message.sigma, &message.depth})
    column->clear();
  message.octave.clear();
  message.track_id.clear();
  const Features features = KeypointsView<KeypointsMessage>(message).features();
  ASSERT_EQ(features.size(), 3);
  EXPECT_EQ(features.keypoints[1].octave, 0);
  EXPECT_EQ(features.keypoints[1].angle, -1);
  EXPECT_EQ(KeypointsView<KeypointsMessage>(message).sigma().size(), 0);
}

TEST(KeypointsView, WrapsNegativeAngles) {
  KeypointsMessage message;
  message.angle = {-90, -180, -1};
  const Features features = KeypointsView<KeypointsMessage>(message).features();
  const float expected[] = {270, 180, -1};  // -1: unknown
  for (size_t i = 0; i < 3; ++i) EXPECT_EQ(features.keypoints[i].angle, expected[i]);
}

TEST(KeypointsView, TakesAnEmptyMessage) {
  KeypointsMessage message;
  for (auto* column :
       {&message.u, &message.v, &message.size, &message.angle, &message.response, &message.sigma, &message.depth}) {
    column->clear();
  }
  for (auto* column : {&message.octave, &message.descriptors}) column->clear();
  message.track_id.clear();
  const KeypointsView<KeypointsMessage> view(message);
  EXPECT_EQ(view.size(), 0);
  EXPECT_FALSE(view.hasDepth());
  EXPECT_EQ(view.depth().size(), 0);
  EXPECT_EQ(view.features().size(), 0);
}

TEST(KeypointsView, NamesWhatIsMalformed) {
  using Message = KeypointsMessage;
  Complaints<Message> cases = {
      {[](Message& m) { m.v.pop_back(); }, "Keypoints: v has 2 entries, but 3 belong to this many keypoints (u)"},
      {[](Message& m) { m.octave.push_back(0); }, "octave has 4"},
      {[](Message& m) { m.size.pop_back(); }, "size has 2"},
      {[](Message& m) { m.angle.pop_back(); }, "angle has 2"},
      {[](Message& m) { m.response.pop_back(); }, "response has 2"},
      {[](Message& m) { m.sigma.pop_back(); }, "sigma has 2"},
      {[](Message& m) { m.track_id.pop_back(); }, "track_id has 2"},
      {[](Message& m) { m.depth.pop_back(); }, "depth has 2"},
      {[](Message& m) { m.descriptors.pop_back(); }, "descriptors has 95 entries, but 96"},
      {[](Message& m) { m.descriptor_size = 0; }, "Keypoints: descriptor_size is 0; it must be the bytes of one"},
      {[](Message& m) { m.descriptor_size = 33; }, "descriptors has 96 entries, but 99"},
      {[](Message& m) { m.descriptor_size = 0x55555560; }, "Keypoints: descriptor_size is 1431655776"},
      {[](Message& m) { m.descriptor_type = 2; }, "Keypoints: descriptor_type is 2; it must be DESCRIPTOR_BINARY (0)"},
      {[](Message& m) {
         m.descriptor_type = Message::DESCRIPTOR_FLOAT32;
         m.descriptor_size = 30;
       },
       "descriptor_size is 30; it must be the bytes of one descriptor, four for each number"},
      {[](Message& m) { m.angle[2] = std::nanf(""); }, "Keypoints: keypoint 2 has no angle within 360 degrees"},
      {[](Message& m) { m.angle[2] = -361; }, "Keypoints: keypoint 2 has no angle within 360 degrees"},
      {[](Message& m) { m.octave[1] = 16; }, "Keypoints: keypoint 1 has no possible octave"},
      {[](Message& m) { m.width = 4000000000u; }, "Keypoints: the image is larger than 32768 pixels a side"},
      {[](Message& m) { m.height = 32769; }, "Keypoints: the image is larger than 32768 pixels a side"},
      {[](Message& m) { m.scale_factor = 0; }, "Keypoints: scale_factor is not above 1"}};
  for (const float outside : {std::numeric_limits<float>::quiet_NaN(), -1.f, 640.f, 1e30f}) {
    cases.emplace_back([=](Message& m) { m.u[2] = outside; }, "Keypoints: keypoint 2 lies outside the image");
    cases.emplace_back([=](Message& m) { m.v[0] = outside; }, "Keypoints: keypoint 0 lies outside the image");
  }
  expectComplaints<KeypointsView<Message>>(cases);
}

/// The fields of gms_ransac/Correspondences that the view reads.
struct CorrespondencesMessage {
  enum { STAGE_RAW = 0, STAGE_GMS = 1, STAGE_INLIER = 2 };
  enum { PIXELS_RAW = 0, PIXELS_RECTIFIED = 1 };
  uint8_t pixel_space = PIXELS_RECTIFIED;
  std::vector<float> reference_points{1, 2, 3, 4, 5, 6}, current_points{7, 8, 9, 10, 11, 12};
  std::vector<float> confidence{0.5f, 1.f, 0.25f};
  std::vector<uint16_t> distance{1, 2, 3}, track_length{2, 2, 2};
  std::vector<uint32_t> track_id{4, 5, 6};
  std::vector<uint8_t> stage;
  std::vector<float> probability{0.9f, 0.8f, 0.1f}, reference_sigma{0.5f, 0.6f, 0.7f}, current_sigma{0.6f, 0.5f, 0.5f};
  std::array<double, 9> K{{500, 0, 320, 0, 501, 240, 0, 0, 1}};
  struct {
    struct {
      struct {
        double x = 0.6, y = 0, z = 0.8;
      } position;
      struct {
        double x = 0, y = 0, z = std::sqrt(0.5), w = std::sqrt(0.5);
      } orientation;
    } pose;
  } current_in_reference;
};

using View = CorrespondencesView<CorrespondencesMessage>;

TEST(CorrespondencesView, ShowsTheColumnsWithoutACopy) {
  const CorrespondencesMessage message;
  const View view(message);
  ASSERT_EQ(view.size(), 3);
  const cv::Mat points = view.currentPoints();
  EXPECT_EQ(points.rows, 3);
  EXPECT_EQ(points.type(), CV_32FC2);
  EXPECT_EQ(points.ptr<float>(), message.current_points.data());
  EXPECT_EQ(view.referencePoints().at<cv::Point2f>(2), cv::Point2f(5, 6));
  EXPECT_EQ(view.reference().col(2), Eigen::Vector2f(5, 6));
  EXPECT_EQ(view.current()(1, 0), 8);
  EXPECT_EQ(view.confidence()[2], 0.25f);
  EXPECT_EQ(view.probability()[1], 0.8f);
  EXPECT_EQ(view.referenceSigma()[2], 0.7f);
  EXPECT_EQ(view.currentSigma().data(), message.current_sigma.data());
}

TEST(CorrespondencesView, GivesCameraPoseAndInliers) {
  CorrespondencesMessage message;
  const View view(message);
  EXPECT_TRUE(view.calibrated());
  EXPECT_EQ(view.K()(0, 2), 320);
  EXPECT_EQ(view.K()(1, 1), 501);
  EXPECT_LT((view.currentInReference() * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(0.6, 1, 0.8)).norm(), 1e-12);
  EXPECT_TRUE(view.isInlier(1)) << "without the column of stages all are";
  message.stage = {2, 1, 0};
  EXPECT_TRUE(view.isInlier(0));
  EXPECT_FALSE(view.isInlier(1));
  message.K.fill(0);
  EXPECT_FALSE(view.calibrated());
}

/// The fields of a camera_info that the view reads.
struct Info {
  std::string distortion_model;
  std::vector<double> D;
};

TEST(CorrespondencesView, RefusesLensesThatOpenCvCannotUndo) {
  CorrespondencesMessage message;
  message.pixel_space = CorrespondencesMessage::PIXELS_RAW;
  const View view(message);
  for (const char* model : {"omnidirectional", "mei", "omni-radtan", "double_sphere", "ds"}) {
    EXPECT_THROW(view.normalized(view.currentPoints(), Info{model, {0.5, 0.1, 0, 0, 0}}), std::invalid_argument)
        << model;
  }
  EXPECT_NO_THROW(view.normalized(view.currentPoints(), Info{"plumb_bob", {0.1, 0.1, 0, 0, 0}}));
  try {
    view.normalized(view.currentPoints(), Info{"brown", {0.1, 0.1, 0, 0, 0}});
    FAIL() << "a model that nobody knows passed for plumb_bob";
  } catch (const std::invalid_argument& error) {
    EXPECT_TRUE(says(error.what(), {"'brown' is no known distortion model; it must be plumb_bob"}));
  }
}

TEST(CorrespondencesView, NamesTheColumnThatDoesNotFit) {
  using Message = CorrespondencesMessage;
  expectComplaints<View, Message>(
      {{[](Message& m) { m.current_points.pop_back(); },
        "Correspondences: current_points has 5 entries, but 6 belong to this many confidences"},
       {[](Message& m) { m.track_id.push_back(1); }, "track_id has 4"},
       {[](Message& m) { m.probability.clear(); }, "probability has 0"},
       {[](Message& m) { m.stage = {2}; }, "stage has 1"}});
}

TEST(CorrespondencesView, NormalizesRectifiedPointsByKAlone) {
  CorrespondencesMessage message;
  message.current_points = {320, 240, 820, 240, 320, 741};
  const View view(message);
  const cv::Mat rays = view.normalized(view.currentPoints(), Info{"brown", {0.5}});  // not used
  EXPECT_LT(cv::norm(rays.at<cv::Point2f>(0) - cv::Point2f(0, 0)), 1e-6);
  EXPECT_LT(cv::norm(rays.at<cv::Point2f>(1) - cv::Point2f(1, 0)), 1e-6);
  EXPECT_LT(cv::norm(rays.at<cv::Point2f>(2) - cv::Point2f(0, 1)), 1e-6);
  EXPECT_EQ(cv::norm(rays, view.normalized(view.currentPoints())), 0);
}

TEST(CorrespondencesView, UndoesTheDistortionOfRawPoints) {
  const Eigen::Vector2d rays[] = {{0.5, 0.4}, {-0.6, 0.1}, {0, 0}};
  for (const CameraIntrinsics& k :
       {CameraIntrinsics{500, 501, 320, 240, "plumb_bob", {-0.3, 0.1, 1e-3, -1e-3, 0}},
        CameraIntrinsics{500, 501, 320, 240, "rational_polynomial", {-0.3, 0.1, 1e-3, -1e-3, 0, 0.05, 0.01, 0}},
        CameraIntrinsics{500, 501, 320, 240, "equidistant", {-0.02, 0.01, -0.003, 0.001}}}) {
    CorrespondencesMessage message;
    message.pixel_space = CorrespondencesMessage::PIXELS_RAW;
    message.reference_points.clear();
    for (const Eigen::Vector2d& ray : rays) {
      const cv::Point2f pixel = pixelOf(Camera(k, {640, 480}), ray);
      message.reference_points.insert(message.reference_points.end(), {pixel.x, pixel.y});
    }
    const View view(message);
    std::vector<double> filled = k.distortion;
    if (k.distortion_model == "equidistant") filled.push_back(0);  // as some drivers have it
    const cv::Mat found = view.normalized(view.referencePoints(), Info{k.distortion_model, filled});
    for (int i = 0; i < 3; ++i) {
      EXPECT_LT(std::hypot(found.at<cv::Point2f>(i).x - rays[i].x(), found.at<cv::Point2f>(i).y - rays[i].y()), 1e-4)
          << k.distortion_model << " " << i;
    }
  }
}

TEST(CorrespondencesView, RefusesRawPointsWithoutTheirDistortion) {
  CorrespondencesMessage message;
  message.pixel_space = CorrespondencesMessage::PIXELS_RAW;
  const View view(message);
  EXPECT_THROW(view.normalized(view.currentPoints()), std::invalid_argument);
  // OpenCV's own assertion would be neither a plain sentence nor a std::invalid_argument.
  for (const auto& [model, count] : {std::make_pair("plumb_bob", 3), std::make_pair("fisheye", 5)}) {
    EXPECT_THROW(
        view.normalized(view.currentPoints(), Info{model, std::vector<double>(static_cast<size_t>(count), 0.1)}),
        std::invalid_argument)
        << model;
  }
  message.K.fill(0);
  EXPECT_THROW(view.normalized(view.currentPoints(), Info{"plumb_bob", {-0.3, 0.1, 0, 0, 0}}), std::invalid_argument);
}

}  // namespace
}  // namespace gms_ransac
