// Matches an image of squares with a copy that is moved by 12 pixels. With an argument it prints all numbers of a pair.
#include <cmath>
#include <iostream>

#include <gms_ransac/match_filter.h>
#include <opencv2/imgproc.hpp>

#include "numbers.h"

int main(int argc, char**) {
  if (argc > 1) {
    printNumbers();
    return 0;
  }
  cv::Mat image(480, 640, CV_8UC1, cv::Scalar(128));
  cv::RNG random(1);
  for (int i = 0; i < 3000; ++i) {
    const cv::Rect square(random.uniform(0, 628), random.uniform(0, 468), 12, 12);
    cv::rectangle(image, square, random.uniform(0, 256), cv::FILLED);
  }
  gms_ransac::MatchFilterOptions options;
  options.robust.model = gms_ransac::ModelType::kHomography;
  gms_ransac::MatchFilter filter(options);
  filter.process(image.colRange(0, 628));
  const gms_ransac::MatchResult& result = filter.process(image.colRange(12, 640));
  const Eigen::Matrix3d H = result.robust.model / result.robust.model(2, 2);
  std::cout << gms_ransac::toString(result.status) << ", moved by " << std::lround(H(0, 2)) << "\n";
}
