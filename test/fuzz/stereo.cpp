// Two cameras: the right image and both camera_infos give depth, or a sentence says why they do not; the answers to a
// stream of such pairs are sound.
#include "fuzz_answers.h"
#include "fuzz_messages.h"
#include "input/stereo_depth.h"
#include "output/stereo_feature_stream.h"

namespace gms_ransac {
namespace {

/// That of one camera of a rectified pair; single fields break the rules.
sensor_msgs::CameraInfoPtr infoOf(FuzzInput& input, double offset) {
  if (input.byte() > 224) return fuzzedCameraInfo(input, kWallWidth, kWallHeight);
  auto info = boost::make_shared<sensor_msgs::CameraInfo>();
  info->width = kWallWidth;
  info->height = kWallHeight;
  info->distortion_model = "plumb_bob";
  const double distortion = input.byte() > 128 ? input.number(-0.5, 0.5) : 0;
  info->D = {distortion, 0, 0, 0, 0};
  const double f = 100;
  info->K = {f, 0, kWallWidth / 2.0, 0, f, kWallHeight / 2.0, 0, 0, 1};
  info->R = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  if (input.byte() > 160) {  // a rotation about x
    const double angle = input.within(-0.5, 0.5);
    info->R = {1, 0, 0, 0, std::cos(angle), -std::sin(angle), 0, std::sin(angle), std::cos(angle)};
  }
  info->P = {f, 0, kWallWidth / 2.0, -f * offset, 0, f, kWallHeight / 2.0, 0, 0, 0, 1, 0};
  for (int k = input.between(0, 3); k > 0 && input.byte() > 160; --k) {
    const int kind = input.between(0, 3);
    if (kind == 0) info->P[static_cast<size_t>(input.between(0, 11))] = input.number(-200, 200);
    if (kind == 1) info->R[static_cast<size_t>(input.between(0, 8))] = input.number(-1, 1);
    if (kind == 2) info->K[static_cast<size_t>(input.between(0, 8))] = input.number(0, 200);
    if (kind == 3) info->binning_x = input.byte();
  }
  return info;
}

ImageWithInfo fuzzedPair(FuzzInput& input, double stamp) {
  static const std::vector<std::string> kEncodings = {"mono8", "mono16", "bgr8"};
  ImageWithInfo pair;
  const int shift = input.between(0, 30), disparity = input.between(0, 20);
  const auto image = wallView(shift);
  image->header.frame_id = "camera";
  image->header.stamp = pair.received = ros::Time(stamp);
  pair.image = image;
  pair.camera_info = infoOf(input, 0);
  if (input.byte() < 240)
    pair.right = input.byte() > 232 ? fuzzedImage(input, kEncodings, 160) : wallView(shift + disparity);
  if (input.byte() < 240) pair.right_info = infoOf(input, 0.1);
  return pair;
}

}  // namespace

void check(FuzzInput input) {
  quietRos();
  Parameters parameters;
  parameters.input = InputKind::kStereo;
  parameters.input_is_rectified = static_cast<Rectified>(input.between(0, 2));
  FrameProcessor processor(parameters, "/left/image", "/left/camera_info", nullptr, "/right/image",
                           "/right/camera_info");
  ProcessorOptions options;
  options.core.extractor.features = 200;
  options.core.robust.max_iterations = 50;
  processor.setOptions(options);
  StereoFeatureStream stream;
  for (int i = 0; i < 4 && !input.empty(); ++i) {
    const Prepared prepared = processor.prepare(processor.receive(fuzzedPair(input, 100 + 0.1 * i)));
    const PreparedFrame* frame = prepared.frame.get();
    demand(frame->depth_problem.size() < 1000, "a sentence is short whatever the messages say");
    demand(frame->stereo.depth.empty() || frame->stereo.depth.size() == frame->frame.features.keypoints.size(),
           "a depth of each keypoint");
    const ProcessedFrame processed = processor.process(prepared);
    demandSound(processed);
    if (const auto features = stream.next(processed, FeatureOptions())) {
      for (const StereoFeature& feature : features->features) {
        demand(std::isfinite(feature.u0 + feature.v0 + feature.u1 + feature.v1), "a ray is finite");
      }
    }
  }
}

}  // namespace gms_ransac
