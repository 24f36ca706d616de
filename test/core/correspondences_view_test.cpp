// The consumer's view of a message: no copy, checked once, same numbers.
#include "gms_ransac/correspondences_view.h"

#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace gms_ransac {
namespace {

/// The fields of gms_ransac/Correspondences that the view reads.
struct Message {
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

TEST(CorrespondencesView, ShowsTheColumnsWithoutACopy) {
  const Message message;
  const CorrespondencesView<Message> view(message);
  ASSERT_EQ(view.size(), 3);
  const cv::Mat points = view.currentPoints();
  EXPECT_EQ(points.rows, 3);
  EXPECT_EQ(points.type(), CV_32FC2);
  EXPECT_EQ(points.ptr<float>(), message.current_points.data());
  EXPECT_EQ(points.at<cv::Point2f>(1), cv::Point2f(9, 10));
  EXPECT_EQ(view.referencePoints().at<cv::Point2f>(2), cv::Point2f(5, 6));
  EXPECT_EQ(view.reference().data(), message.reference_points.data());
  EXPECT_EQ(view.reference().col(2), Eigen::Vector2f(5, 6));
  EXPECT_EQ(view.current()(1, 0), 8);
  EXPECT_EQ(view.confidence()[2], 0.25f);
  EXPECT_EQ(view.probability()[1], 0.8f);
  EXPECT_EQ(view.referenceSigma()[2], 0.7f);
  EXPECT_EQ(view.currentSigma().data(), message.current_sigma.data());
}

TEST(CorrespondencesView, GivesCameraAndPose) {
  Message message;
  EXPECT_TRUE(CorrespondencesView<Message>(message).calibrated());
  EXPECT_EQ(CorrespondencesView<Message>(message).K()(0, 2), 320);
  EXPECT_EQ(CorrespondencesView<Message>(message).K()(1, 1), 501);
  const Eigen::Isometry3d pose = CorrespondencesView<Message>(message).currentInReference();
  EXPECT_LT((pose * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(0.6, 1, 0.8)).norm(), 1e-12);
  message.K.fill(0);
  EXPECT_FALSE(CorrespondencesView<Message>(message).calibrated());
}

TEST(CorrespondencesView, KnowsInliersWithAndWithoutTheStageColumn) {
  Message message;
  EXPECT_TRUE(CorrespondencesView<Message>(message).isInlier(1));
  message.stage = {2, 1, 0};
  EXPECT_TRUE(CorrespondencesView<Message>(message).isInlier(0));
  EXPECT_FALSE(CorrespondencesView<Message>(message).isInlier(1));
}

TEST(CorrespondencesView, NamesTheColumnThatDoesNotFit) {
  const auto complaint = [](const Message& message) -> std::string {
    try {
      CorrespondencesView<Message> view(message);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  Message message;
  message.current_points.pop_back();
  EXPECT_EQ(complaint(message), "Correspondences: current_points has 5 entries, but 6 belong to this many confidences");
  message = Message();
  message.track_id.push_back(1);
  EXPECT_NE(complaint(message).find("track_id"), std::string::npos);
  message = Message();
  message.probability.clear();
  EXPECT_NE(complaint(message).find("probability has 0 entries"), std::string::npos);
  message = Message();
  message.stage = {2};
  EXPECT_NE(complaint(message).find("stage"), std::string::npos);
  message.stage.clear();
  EXPECT_EQ(complaint(message), "");
}

TEST(CorrespondencesView, NormalizesRectifiedPointsByKAlone) {
  Message message;
  message.current_points = {320, 240, 820, 240, 320, 741};
  const CorrespondencesView<Message> view(message);
  const cv::Mat rays = view.normalized(view.currentPoints(), "plumb_bob", {0.5, 0.5, 0, 0, 0});  // not used
  EXPECT_LT(cv::norm(rays.at<cv::Point2f>(0) - cv::Point2f(0, 0)), 1e-6);
  EXPECT_LT(cv::norm(rays.at<cv::Point2f>(1) - cv::Point2f(1, 0)), 1e-6);
  EXPECT_LT(cv::norm(rays.at<cv::Point2f>(2) - cv::Point2f(0, 1)), 1e-6);
}

TEST(CorrespondencesView, UndoesTheDistortionOfRawPoints) {
  const std::vector<cv::Point2f> ideal = {{0.5f, 0.4f}, {-0.6f, 0.1f}, {0.f, 0.f}};
  const auto recovers = [&](const std::string& model, const std::vector<double>& D) {
    Message message;
    message.pixel_space = Message::PIXELS_RAW;
    const cv::Matx33d K(message.K.data());
    std::vector<cv::Point2f> pixels;
    if (model == "equidistant") {
      cv::fisheye::distortPoints(ideal, pixels, K, D);
    } else {
      std::vector<cv::Point3f> points;
      for (const cv::Point2f& p : ideal) points.emplace_back(p.x, p.y, 1.f);
      cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(), K, D, pixels);
    }
    for (size_t i = 0; i < ideal.size(); ++i) {
      message.reference_points[2 * i] = pixels[i].x;
      message.reference_points[2 * i + 1] = pixels[i].y;
    }
    const CorrespondencesView<Message> view(message);
    const cv::Mat rays = view.normalized(view.referencePoints(), model, D);
    for (size_t i = 0; i < ideal.size(); ++i) {
      EXPECT_LT(cv::norm(rays.at<cv::Point2f>(static_cast<int>(i)) - ideal[i]), 1e-4) << model << " " << i;
    }
  };
  recovers("plumb_bob", {-0.3, 0.1, 1e-3, -1e-3, 0});
  recovers("rational_polynomial", {-0.3, 0.1, 1e-3, -1e-3, 0, 0.05, 0.01, 0});
  recovers("equidistant", {-0.02, 0.01, -0.003, 0.001});
}

TEST(CorrespondencesView, RefusesRawPointsWithoutTheirDistortion) {
  Message message;
  message.pixel_space = Message::PIXELS_RAW;
  const CorrespondencesView<Message> view(message);
  EXPECT_THROW(view.normalized(view.currentPoints()), std::invalid_argument);
  // OpenCV's own assertion would be neither a plain sentence nor a std::invalid_argument.
  for (const auto& [model, count] : {std::make_pair("plumb_bob", 3), std::make_pair("fisheye", 5)}) {
    EXPECT_THROW(view.normalized(view.currentPoints(), model, std::vector<double>(static_cast<size_t>(count), 0.1)),
                 std::invalid_argument)
        << model;
  }
  message.K.fill(0);
  EXPECT_THROW(view.normalized(view.currentPoints(), "plumb_bob", {-0.3, 0.1, 0, 0, 0}), std::invalid_argument);
}

}  // namespace
}  // namespace gms_ransac
