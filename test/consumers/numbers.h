// A pair of drawn images through the pipeline, and every number of its answer as text: it must not depend on the flags
// that the program is compiled with.
#pragma once

#include <iomanip>
#include <iostream>

#include <gms_ransac/match_filter.h>
#include <gms_ransac/triangulation.h>
#include <Eigen/Cholesky>
#include <opencv2/imgproc.hpp>

/// Squares before a wall of squares, seen by a camera that moves to the right by a tenth of the distance of the first.
inline cv::Mat drawSquares(int camera) {
  cv::Mat image(480, 640, CV_8UC1, cv::Scalar(128));
  cv::RNG random(1);
  for (int i = 0; i < 3000; ++i) {
    const int shift = camera * (i % 3 == 0 ? 24 : 8);
    const cv::Rect square(random.uniform(-30, 660) - shift, random.uniform(-12, 480), 12, 12);
    cv::rectangle(image, square, random.uniform(0, 256), cv::FILLED);
  }
  return image;
}

template <typename Numbers>
void print(const char* name, const Numbers& numbers) {
  double sum = 0;
  for (const auto number : numbers) sum += static_cast<double>(number);
  std::cout << name << " " << numbers.size() << " " << sum << "\n";
}

inline void printNumbers() {
  const cv::Mat images[] = {drawSquares(0), drawSquares(1)};
  gms_ransac::MatchFilter filter;
  filter.setCamera({{500, 500, 319.5, 239.5, "plumb_bob", {-0.1, 0.02, 0, 0, 0}}, images[0].size()});
  gms_ransac::Frame reference, current;
  filter.extract(images[0], reference);
  filter.extract(images[1], current);
  gms_ransac::MatchResult result;
  gms_ransac::Past past;
  filter.filter(reference, current, result, nullptr, &past);
  gms_ransac::Triangulation points;
  gms_ransac::triangulateInliers(reference.features, result, filter.camera(), points);

  const gms_ransac::RobustResult& robust = result.robust;
  const gms_ransac::RelativePose pose = robust.judgement.pose;  // a copy, by this program's idea of its layout
  std::cout << std::setprecision(17) << gms_ransac::toString(result.status) << " " << result.raw.size() << " "
            << result.size() << " " << result.inliers << " " << robust.effort.point_evaluations << "\n"
            << pose.R << "\n"
            << pose.t.transpose() << "\n"
            << pose.covariance << "\n"
            << robust.model << "\n"
            << robust.judgement.median_parallax_px << " " << robust.judgement.sigma_px << " " << robust.rms_error_px
            << "\n";
  print("probability", robust.judgement.probability);
  print("confidence", result.confidence);
  print("depth", points.depth_current);
  print("static", past.current_static);
  // The library has these templates of Eigen, too, compiled for other vectors.
  const Eigen::Matrix<double, 6, 6> covariance = pose.covariance + 1e-6 * Eigen::Matrix<double, 6, 6>::Identity();
  std::cout << "definite " << (covariance.llt().info() == Eigen::Success) << "\n";
}
