// Two cameras: the right image and both camera_infos give depth, that of the scene, or a sentence says why they do not;
// the answers to a stream of such pairs are sound.
#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "fuzz_answers.h"
#include "fuzz_messages.h"
#include "input/stereo_depth.h"
#include "output/stereo_feature_stream.h"

namespace gms_ransac {
namespace {

constexpr double kFocalLength = 100;  // pixels

/// That of one camera of a rectified pair, `offset` metres to the right.
sensor_msgs::CameraInfoPtr rectifiedInfo(double offset) {
  auto info = boost::make_shared<sensor_msgs::CameraInfo>();
  info->width = kWallWidth;
  info->height = kWallHeight;
  info->distortion_model = "plumb_bob";
  const double f = kFocalLength;
  info->K = {f, 0, kWallWidth / 2.0, 0, f, kWallHeight / 2.0, 0, 0, 1};
  info->R = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info->P = {f, 0, kWallWidth / 2.0, -f * offset, 0, f, kWallHeight / 2.0, 0, 0, 0, 1, 0};
  return info;
}

/// Single fields break the rules.
sensor_msgs::CameraInfoPtr infoOf(FuzzInput& input, double offset) {
  if (input.byte() > 224) return fuzzedCameraInfo(input, kWallWidth, kWallHeight);
  const auto info = rectifiedInfo(offset);
  const double distortion = input.byte() > 128 ? input.number(-0.5, 0.5) : 0;
  info->D = {distortion, 0, 0, 0, 0};
  if (input.byte() > 160) {
    const double most = input.flag() ? M_PI : 0.5;
    const Eigen::AngleAxisd R(input.within(-most, most), Eigen::Vector3d::Unit(input.between(0, 2)));
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(info->R.data()) = R.toRotationMatrix();
  }
  for (int k = input.between(0, 3); k > 0 && input.byte() > 160; --k) {
    const int kind = input.between(0, 3);
    if (kind == 0) info->P[static_cast<size_t>(input.between(0, 11))] = input.number(-200, 200);
    if (kind == 1) info->R[static_cast<size_t>(input.between(0, 8))] = input.number(-1, 1);
    if (kind == 2) info->K[static_cast<size_t>(input.between(0, 8))] = input.number(0, 200);
    if (kind == 3) info->binning_x = input.byte();
  }
  return info;
}

struct FuzzedPair {
  ImageWithInfo images;
  bool right_is_wall = false, sound = false;  ///< sound: all that can be wrong is the baseline
  double baseline = 0.1;                      ///< metres
  int disparity = 0;                          ///< pixels
};

FuzzedPair fuzzedPair(FuzzInput& input, double stamp) {
  static const std::vector<std::string> kEncodings = {"mono8", "mono16", "bgr8"};
  FuzzedPair pair;
  ImageWithInfo& images = pair.images;
  const int shift = input.between(0, 30);
  pair.disparity = input.between(0, 20);
  const auto image = wallView(shift);
  image->header.frame_id = "camera";
  image->header.stamp = images.received = ros::Time(stamp);
  images.image = image;
  pair.sound = input.byte() < 96;
  if (pair.sound) pair.baseline = input.number(-0.2, 4);
  images.camera_info = pair.sound ? rectifiedInfo(0) : infoOf(input, 0);
  pair.right_is_wall = pair.sound || input.byte() < 232;
  const auto right = pair.right_is_wall ? wallView(shift + pair.disparity) : fuzzedImage(input, kEncodings, 160);
  right->header.stamp = image->header.stamp;
  if (pair.sound || input.byte() < 240) images.right = right;
  if (pair.sound || input.byte() < 240)
    images.right_info = pair.sound ? rectifiedInfo(pair.baseline) : infoOf(input, 0.1);
  return pair;
}

bool isCopy(const sensor_msgs::ImageConstPtr& before, const sensor_msgs::ImageConstPtr& image) {
  return before && before->data == image->data;
}

/// `frame` is usable, and its right image no copy.
void checkBaseline(const FuzzedPair& pair, const PreparedFrame& frame) {
  const std::vector<float>& depth = frame.stereo.depth;
  const bool possible = pair.baseline > 0 && std::isfinite(kFocalLength * pair.baseline);
  demand(possible || (depth.empty() && !frame.depth_problem.empty()), "no depth without a baseline");
  if (depth.empty()) return;
  const bool usual = pair.baseline >= 0.01 && pair.baseline <= 3;
  demand(usual == frame.doubt.empty(), "a baseline that no two cameras have is doubted, and no other: " + frame.doubt);
  std::vector<float> known;
  for (const float metres : depth) {
    if (metres > 0) known.push_back(metres);
  }
  if (!usual || pair.disparity < 2 || known.size() < 20) return;
  std::nth_element(known.begin(), known.begin() + known.size() / 2, known.end());
  const double ratio = known[known.size() / 2] * pair.disparity / (kFocalLength * pair.baseline);
  demand(std::abs(ratio - 1) < 0.05, "the wall is where it is: " + std::to_string(ratio));
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
  sensor_msgs::ImageConstPtr left_before, right_before;
  for (int i = 0; i < 4 && !input.empty(); ++i) {
    const FuzzedPair pair = fuzzedPair(input, 100 + 0.1 * i);
    const Prepared prepared = processor.prepare(processor.receive(pair.images));
    const PreparedFrame* frame = prepared.frame.get();
    const bool is_copy = isCopy(left_before, pair.images.image);
    demand(is_copy == !prepared.problem.empty(), "a copy is refused, and no other: " + prepared.problem);
    left_before = pair.images.image;
    if (pair.images.right) {
      const bool right_is_copy = pair.right_is_wall && isCopy(right_before, pair.images.right);
      const bool said = frame->depth_problem.find("copy of the image before it") != std::string::npos;
      demand(is_copy || !pair.right_is_wall || said == right_is_copy, "the same of the right image");
      right_before = pair.images.right;
      if (pair.sound && !is_copy && !right_is_copy) checkBaseline(pair, *frame);
    }
    for (const float metres : frame->stereo.depth) demand(std::isfinite(metres) && metres >= 0, "a depth is one, or 0");
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
