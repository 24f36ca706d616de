// One frame after another through the OpenCV baseline and through ours, with a mark after each stage for the counter of
// instructions (count_instructions.c). Prints the names of the marks.
//
// usage: frame_instructions FEATURES [DATASET [FRAMES]]; without a data set a rendered room.
#include <cstdlib>
#include <exception>
#include <iostream>
#include <string>
#include <vector>

#include <unistd.h>

#include <opencv2/core/utility.hpp>

#include "benchmark/opencv_baseline.h"
#include "datasets/dataset.h"
#include "gms_ransac/match_filter.h"
#include "match_filter_hooks.h"
#include "scenes/scene.h"

namespace gms_ransac {
namespace {

constexpr long kMark = 77001;  // no system call: the emulator's plugin hears of it, and nothing else happens

/// Ends what is counted for `stage`.
void mark(const std::string& stage) {
  static int count = 0;
  std::cout << "stage " << count << ' ' << stage << std::endl;  // before: printing is part of what the mark ends
  syscall(kMark, count++);
}

struct Images {
  std::vector<cv::Mat> images;
  Camera camera;
};

Images rendered(int frames) {
  const SceneOptions options;
  const Scene scene(options);
  Images images{{}, Camera(scene.intrinsics(), options.size)};
  for (int i = 0; i < frames; ++i) images.images.push_back(scene.render(i).image);
  return images;
}

Images recorded(const std::string& folder, int frames) {
  const Dataset dataset = Dataset::open(folder);
  Images images;
  for (int i = 0; i < frames; ++i) images.images.push_back(dataset.image(i));
  if (dataset.intrinsics()) images.camera = Camera(*dataset.intrinsics(), images.images.front().size());
  return images;
}

/// cv::ORB, cv::BFMatcher, GMS as published, and OpenCV's RANSAC: what a front end of stock parts does for each image.
void runBaseline(const Images& input, int features) {
  const cv::Ptr<cv::ORB> orb = makeBaselineExtractor(features);
  const BaselineEstimator estimator = baselineEstimators(input.camera.calibrated()).front();
  Features reference;
  for (const cv::Mat& image : input.images) {
    Features current;
    cv::Mat descriptors;
    current.image_size = image.size();
    mark("-");
    orb->detectAndCompute(image, cv::noArray(), current.keypoints, descriptors);
    mark("opencv extract");
    current.descriptors.assign(descriptors);
    if (reference.keypoints.empty()) {
      reference = current;
      continue;
    }
    mark("-");
    const std::vector<Match> matches = baselineMatches(reference.descriptors.asMat(), descriptors);
    mark("opencv match");
    MotionStatistics statistics;
    denseMotionStatistics({}, reference, current, matches, statistics);
    mark("opencv gms");
    std::vector<Match> survivors = acceptedOf(matches, statistics);
    mark("-");
    estimate(estimator, reference.keypoints, current.keypoints, input.camera, survivors);
    mark("opencv robust");
    reference = current;
  }
}

/// `process` in its two halves; the robust stage, which `filter` ends with, is run once more by itself.
void runOurs(const Images& input, int features, SearchMode search) {
  const std::string name = search == SearchMode::kGuided ? "guided" : "ours";
  MatchFilterOptions options;
  options.search = search;
  options.extractor.features = features;
  options.extractor.fast_threshold = fastThreshold(features);
  MatchFilter filter(options);
  filter.setCamera(input.camera);
  Frame reference, current;
  MatchResult result;
  for (size_t i = 0; i < input.images.size(); ++i) {
    mark("-");
    filter.extract(input.images[i], current);
    mark(name + " extract");
    if (i > 0) {
      filter.filter(reference, current, result);
      mark(name + " match, gms and robust");
      MatchFilterHooks::estimate(filter, reference, current, result);
      mark(name + " robust, alone");
    }
    std::swap(reference, current);
  }
}

}  // namespace
}  // namespace gms_ransac

int main(int count, char** arguments) {
  using namespace gms_ransac;
  try {
    const int features = count > 1 ? std::atoi(arguments[1]) : 2000;
    const int frames = count > 3 ? std::atoi(arguments[3]) : 4;
    const Images images = count > 2 ? recorded(arguments[2], frames) : rendered(frames);
    cv::setNumThreads(1);
    runBaseline(images, features);
    for (const SearchMode search : {SearchMode::kFull, SearchMode::kGuided}) runOurs(images, features, search);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
  return 0;
}
