// Results as messages: what a consumer finds in them must lead to the rays that the core has.
#include "output/message_conversion.h"

#include <memory>

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace gms_ransac
