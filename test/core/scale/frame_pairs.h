// Pairs of images of a sequence through the default pipeline.
#pragma once

#include <vector>

#include "gms_ransac/match_filter.h"
#include "gms_ransac/triangulation.h"

namespace gms_ransac {

/// Calls visit(i, reference, current, result, triangulation) for the images i and i + gap of the first `frames`.
template <typename Source, typename Visit>
void forEachPair(const Camera& camera, int frames, int gap, double minimum_parallax, const Source& image,
                 const Visit& visit, const MatchFilterOptions& options = {}) {
  MatchFilter filter(options);
  filter.setCamera(camera);
  std::vector<Frame> extracted(static_cast<size_t>(frames));
  for (int i = 0; i < frames; ++i) filter.extract(image(i), extracted[i]);
  for (int i = 0; i + gap < frames; ++i) {
    MatchResult result;
    filter.filter(extracted[i], extracted[i + gap], result);
    Triangulation points;
    triangulateInliers(extracted[i].features, result, camera, points, minimum_parallax);
    visit(i, extracted[i], extracted[i + gap], result, points);
  }
}

}  // namespace gms_ransac
