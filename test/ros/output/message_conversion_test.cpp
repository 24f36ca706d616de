// Results as messages: what a consumer finds in them must lead to the rays that the core has.
#include "output/message_conversion.h"

#include <cmath>
#include <limits>
#include <memory>

#include <gtest/gtest.h>

#include "frames.h"
#include "stream/pair_pose.h"

namespace gms_ransac {
namespace {

TEST(MessageConversion, KIsThatOfTheReceivedImageWhateverTheLens) {
  const cv::Size size(640, 480);
  for (const CameraIntrinsics& lens : {CameraIntrinsics{300, 310, 322, 241, "omnidirectional", {1, 0, 0, 0, 0}},
                                       CameraIntrinsics{300, 310, 322, 241, "double_sphere", {-0.2, 0.6}},
                                       CameraIntrinsics{300, 310, 322, 241, "equidistant", {0, 0, 0, 0}},
                                       CameraIntrinsics{300, 310, 322, 241, "", {}}}) {
    auto frame = std::make_shared<PreparedFrame>();
    auto model = std::make_shared<CameraModel>();
    model->camera = Camera(lens, size);
    frame->image.camera = model;
    frame->frame.features.image_size = size;
    ProcessedFrame processed;
    processed.current = frame;
    Keypoints message;
    toMessage(processed, message);
    EXPECT_EQ(message.K, (boost::array<double, 9>{300, 0, 322, 0, 310, 241, 0, 0, 1})) << lens.distortion_model;
    EXPECT_EQ(message.pixel_space == Keypoints::PIXELS_RECTIFIED, lens.distortion_model.empty());

    // As a consumer would: K of the message, model and coefficients of camera_info.
    const Camera read({message.K[0], message.K[4], message.K[2], message.K[5], lens.distortion_model, lens.distortion},
                      size);
    EXPECT_EQ(rayOf(read, {400, 100}), rayOf(model->camera, {400, 100})) << lens.distortion_model;
  }
}

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// The message of a pair whose likeliest motion has this translation and variance.
Correspondences uncertainMessage(Status status, const Eigen::Vector3d& t = {1, 0, 0}, double variance = 0.01) {
  auto camera = std::make_shared<CameraModel>();
  camera->camera = Camera({500, 500, 319.5, 239.5, "", {}}, cv::Size(640, 480));
  auto frame = std::make_shared<PreparedFrame>();
  frame->image.camera = camera;
  auto pair = std::make_shared<ComparedPair>();
  pair->reference = frame;
  Judgement& judgement = pair->result.robust.judgement;
  judgement.motion.R = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitY()).toRotationMatrix();
  judgement.motion.t = t;
  judgement.motion.covariance = variance * Covariance6d::Identity();
  judgement.pose_probability = 0.25;
  ProcessedFrame processed;
  processed.status = static_cast<uint8_t>(status);
  processed.current = frame;
  processed.pair = pair;
  processed.uncertain = uncertainPose(processed, SigmaFloor{0, 0.1});
  Correspondences message;
  toMessage(processed, false, message);
  return message;
}

TEST(UncertainPose, IsTheLikeliestMotionWithItsCovarianceAndProbability) {
  const Correspondences message = uncertainMessage(Status::kMotionUnknown);
  EXPECT_TRUE(message.pose_valid);
  EXPECT_FALSE(message.metric_scale);
  EXPECT_EQ(message.pose_probability, 0.25f);
  EXPECT_EQ(message.current_in_reference.pose.position.x, 1);
  EXPECT_DOUBLE_EQ(message.current_in_reference.pose.orientation.y, std::sin(0.25));
  EXPECT_DOUBLE_EQ(message.current_in_reference.covariance[0], 0.01);
  EXPECT_DOUBLE_EQ(message.current_in_reference.covariance[35], 0.01 + 0.1 * 0.1) << "and the floor";
}

TEST(UncertainPose, NoOtherStatusHasIt) {
  for (const Status status : {Status::kOk, Status::kLowParallax}) {
    EXPECT_EQ(uncertainMessage(status).current_in_reference.pose.position.x, 0) << "its own pose";
  }
  for (const Status status : {Status::kRansacFailed, Status::kUncalibrated, Status::kTooFewMatches}) {
    EXPECT_FALSE(uncertainMessage(status).pose_valid);
  }
}

TEST(UncertainPose, WithoutATranslationItsVarianceIsThatOfAnUnknownOne) {
  const Correspondences message = uncertainMessage(Status::kMotionUnknown, Eigen::Vector3d::Zero());
  EXPECT_TRUE(message.pose_valid);
  EXPECT_EQ(message.current_in_reference.covariance[0], kUnknownTranslationVariance);
}

TEST(UncertainPose, IsNotPublishedIfUnfit) {
  for (const double variance : {kNan, -1.0}) {
    EXPECT_FALSE(uncertainMessage(Status::kMotionUnknown, {1, 0, 0}, variance).pose_valid) << variance;
  }
}

}  // namespace
}  // namespace gms_ransac
