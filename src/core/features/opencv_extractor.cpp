#include "features/opencv_extractor.h"

namespace gms_ransac {

namespace {
constexpr int kPatchSize = 31;  // of the ORB descriptor, and so the border without keypoints
}

OpenCvExtractor::OpenCvExtractor(const FeatureExtractorOptions& options)
    : options_(options),
      orb_(cv::ORB::create(options.features, static_cast<float>(options.scale_factor), options.levels, kPatchSize, 0, 2,
                           cv::ORB::HARRIS_SCORE, kPatchSize, options.fast_threshold)) {}

void OpenCvExtractor::extract(const cv::Mat& image, Features& features) {
  features.image_size = image.size();
  features.scale_factor = static_cast<float>(options_.scale_factor);
  features.keypoints.clear();
  // cv::ORB fails an assertion on images that are smaller than its patch.
  if (image.cols <= 2 * kPatchSize || image.rows <= 2 * kPatchSize) {
    features.descriptors.resize(0);
    features.descriptors.pack();
    return;
  }
  orb_->detectAndCompute(image, cv::noArray(), features.keypoints, descriptors_);
  features.descriptors.assign(descriptors_);
}

}  // namespace gms_ransac
