// A mask message belongs to an image or is refused with a sentence; both extractors obey it.
#include <opencv2/core.hpp>

#include "fuzz_messages.h"
#include "gms_ransac/feature_extractor.h"
#include "input/image_conversion.h"
#include "input/mask_source.h"
#include "invariants.h"

namespace gms_ransac {
namespace {

FeatureExtractorOptions fuzzedOptions(FuzzInput& input) {
  FeatureExtractorOptions options;
  if (input.byte() > 224) options.extractor = "opencv";
  options.features = input.byte() > 250 ? 100000 : input.between(1, 500);
  options.pyramid_levels = input.between(1, 16);
  options.pyramid_scale = input.within(1.01, 2);
  options.fast_threshold = input.between(0, 255);
  return options;
}

/// The pixel that a point lies in, or the two or four on whose border it lies: there the rounding of coordinates
/// decides, and keypoints of enlarged images are rounded before they are scaled back.
cv::Rect pixelsAt(const cv::Point2f& point) {
  const cv::Point2f margin(0.001f, 0.001f);  // what single precision loses
  const cv::Point first = point - margin, last = point + margin;
  return {first, last + cv::Point(1, 1)};
}

}  // namespace

void check(FuzzInput input) {
  quietRos();
  static const std::vector<std::string> kMasks = {"mono8", "8UC1", "bgr8"}, kImages = {"mono8", "mono16", "rgb8"};
  Parameters parameters;
  if (input.flag()) parameters.mask_sync = MaskSync::kExact;
  MaskSource source(parameters);
  const FeatureExtractorOptions options = fuzzedOptions(input);
  const std::unique_ptr<FeatureExtractor> extractor = makeFeatureExtractor(options);
  Features features;
  for (int i = 0; i < 2; ++i) {
    const sensor_msgs::ImagePtr image = fuzzedImage(input, kImages, 220);
    const sensor_msgs::ImagePtr message = input.byte() > 240 ? nullptr : fuzzedImage(input, kMasks, 220);
    if (message && input.flag()) {
      message->width = message->step = image->width;
      message->height = image->height;
      message->data.resize(std::min<size_t>(size_t{message->step} * message->height, 1 << 20), 255);
    }
    cv::Mat grey, mask;
    if (!toGrey(*image, grey).empty()) continue;
    const std::string problem = source.get(message, grey.size(), mask);
    demand(problem.size() < 1000, "a refusal is short whatever the message says");
    demand(mask.empty() || (mask.type() == CV_8UC1 && mask.size() == grey.size()), "a mask has the image's size");
    demand(problem.empty() || mask.empty(), "a mask or a sentence");
    extractor->extract(grey, features, mask);
    demandEmpty(brokenFeatures(features, options));
    if (mask.empty() || options.extractor == "opencv") continue;
    for (const cv::KeyPoint& keypoint : features.keypoints) {
      demand(cv::countNonZero(mask(pixelsAt(keypoint.pt) & cv::Rect({}, mask.size()))) > 0,
             "a keypoint lies where the mask lets it");
    }
  }
}

}  // namespace gms_ransac
