// A depth image belongs to an image or is refused with a sentence. Pose and length from it are fit to publish, and so
// are the length from features seen three times, the triangulated points and the tracks.
#include "fuzz_messages.h"
#include "fuzz_pairs.h"
#include "input/image_conversion.h"
#include "invariants.h"
#include "methods/method.h"
#include "scale/depth_pose.h"
#include "scale/translation_scale.h"
#include "stream/pair_pose.h"

namespace gms_ransac {
namespace {

cv::Mat fuzzedDepth(FuzzInput& input, cv::Size size, sensor_msgs::ImagePtr& message) {
  static const std::vector<std::string> kEncodings = {"32FC1", "16UC1", "mono16", "mono8"};
  message = fuzzedImage(input, kEncodings, 200);
  if (input.byte() < 224) {  // one that fits
    const bool metres = message->encoding == "32FC1";
    message->width = static_cast<uint32_t>(size.width);
    message->height = static_cast<uint32_t>(size.height);
    message->step = message->width * (metres ? 4 : 2);
    message->data.assign(size_t{message->step} * message->height, 0);
    const double near = input.number(0, 20), slope = input.within(-1, 1);
    const auto odd = static_cast<float>(input.number(-1, 1e4) > 1 ? 5 : 0);
    for (size_t i = 0; i < message->data.size() / (metres ? 4 : 2); ++i) {
      const double depth = near + slope * static_cast<double>(i) / static_cast<double>(message->data.size());
      const float value = i % 7 == 0             ? odd
                          : std::isfinite(depth) ? static_cast<float>(std::clamp(depth, -1e30, 1e30))
                                                 : std::numeric_limits<float>::quiet_NaN();
      if (metres) {
        std::memcpy(&message->data[4 * i], &value, 4);
      } else {
        const auto millimetres = static_cast<uint16_t>(std::isnan(value) ? 0 : std::clamp(1000 * value, 0.f, 65535.f));
        std::memcpy(&message->data[2 * i], &millimetres, 2);
      }
    }
  }
  cv::Mat depth;
  const std::string problem = toDepth(*message, size, depth);
  demand(problem.size() < 1000, "a refusal is short whatever the message says");
  demand(problem.empty() != depth.empty(), "depth or a sentence");
  demand(depth.empty() || (depth.type() == CV_32FC1 && depth.size() == size), "depth has the image's size");
  return depth;
}

/// As MatchFilter has it, but for the filter.
MatchResult estimated(const FuzzedPair& pair, Method& method) {
  MatchResult result;
  result.clear(Status::kOk);
  result.keypoints_reference = pair.reference.features.size();
  result.keypoints_current = pair.current.features.size();
  result.raw = result.matches = pair.matches;
  result.pairs = pair.columns(1);
  for (const Match& match : result.matches) {
    result.current_pixel.push_back(pair.current.features.keypoints[static_cast<size_t>(match.current)].pt);
  }
  result.confidence.assign(pair.matches.size(), 1);
  method.estimate(result.pairs, pair.camera, result.robust);
  result.inlier = result.robust.inlier;
  result.inliers = result.robust.inlier_count;
  return result;
}

void checkPublishable(const RelativePose& pose, bool translation_known) {
  RelativePose published = pose;
  makePublishable(translation_known, SigmaFloor(), published);
  if (poseDefect(published).empty()) demandEmpty(brokenPose(published, kPublishedRounding));
}

}  // namespace

void check(FuzzInput input) {
  quietRos();
  MatchFilterOptions options;
  options.robust.max_iterations = 50;
  options.robust.judge = input.byte() < 192;
  const std::unique_ptr<Method> method = makeMethod(options);
  ScalePropagator propagator;
  TrackTable tracks;
  KeyFrame key;
  Triangulation points;
  for (int i = 0; i < 3; ++i) {
    const FuzzedPair pair = fuzzedPair(input, 2000);
    const Features &reference = pair.reference.features, &current = pair.current.features;
    // As the messages are bounded, and before them the fuzzer's patience.
    const cv::Size size(std::clamp(current.image_size.width, 1, 200), std::clamp(current.image_size.height, 1, 200));
    sensor_msgs::ImagePtr messages[2];  // the depth may share their memory
    const cv::Mat reference_depth = fuzzedDepth(input, size, messages[0]);
    const cv::Mat current_depth = input.flag() ? fuzzedDepth(input, size, messages[1]) : cv::Mat();
    const MatchResult result = estimated(pair, *method);
    tracks.link(result);
    demandEmpty(brokenTracks(tracks, result));
    tracks.advance();
    triangulateInliers(reference, result, pair.camera, points);
    demandEmpty(brokenTriangulation(points));
    if (!result.robust.judgement.pose_found) continue;

    const ScaleEstimate length = propagator.update(points, result, pair.camera);
    demand(std::isfinite(length.length) && length.length > 0, "a length is positive");
    demand(std::isfinite(length.relative_sigma) && length.relative_sigma >= 0, "its uncertainty is finite");
    checkPublishable(withLength(result.robust.judgement.pose, length), true);
    propagator.advance();

    RelativePose pose = result.robust.judgement.pose;
    const std::vector<float> depth_of_reference = keypointDepth(reference, reference_depth);
    const std::vector<float> depth_of_current = keypointDepth(current, current_depth);
    const ScaleEstimate metric = poseFromKeypointDepth(
        {points, reference, current, result, pair.camera, depth_of_reference, depth_of_current, 0, tracks.ids()}, pose,
        &key);
    key.advance();
    demand(metric.features >= 0, "features are counted");
    demandEmpty(brokenPose(pose));
    if (metric.features == 0) continue;
    demand(std::isfinite(metric.length) && metric.length >= 0, "a metric length is finite");
    demand(std::isfinite(metric.relative_sigma) && metric.relative_sigma >= 0, "its uncertainty is finite");
    checkPublishable(pose, true);
  }
}

}  // namespace gms_ransac
