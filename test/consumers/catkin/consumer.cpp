// Uses the messages, the view of a message, and the library. With an argument it prints all numbers of a pair.
#include <iostream>

#include <gms_ransac/Correspondences.h>
#include <gms_ransac/MatchStats.h>
#include <gms_ransac/correspondences_view.h>
#include <gms_ransac/match_filter.h>

#include "numbers.h"

int main(int argc, char**) {
  if (argc > 1) {
    printNumbers();
    return 0;
  }
  gms_ransac::Correspondences message;
  message.reference_points = {1, 2, 3, 4};
  message.current_points = {5, 6, 7, 8};
  message.confidence = message.probability = message.reference_sigma = message.current_sigma = {0.5, 0.5};
  message.distance.resize(2);
  message.track_id.resize(2);
  message.track_length.resize(2);
  const gms_ransac::CorrespondencesView<gms_ransac::Correspondences> view(message);

  gms_ransac::MatchFilter filter;
  const auto& result = filter.process(cv::Mat(480, 640, CV_8UC1, cv::Scalar(0)));
  std::cout << view.size() << " matches, " << view.current()(1, 1) << ", " << gms_ransac::toString(result.status)
            << ", OK is " << int(gms_ransac::MatchStats::OK) << "\n";
}
