#include "matching/stereo_matcher.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "matching/hamming_kernels.h"

namespace gms_ransac {

namespace {

// Largest distance, of 256 bits; one match in a hundred is wrong.
constexpr int kMostDistance = 60;
constexpr int kNone = -1;

struct Rows {
  std::vector<int> order;  ///< keypoints, upper ones first
  std::vector<double> y;   ///< rows of these
  explicit Rows(const RectifiedRays& rays) : order(rays.size()) {
    std::iota(order.begin(), order.end(), 0);
    const auto has_ray = [&](int i) { return rays[i].allFinite(); };
    order.erase(std::stable_partition(order.begin(), order.end(), has_ray), order.end());
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return rays[a].y() < rays[b].y(); });
    for (const int i : order) y.push_back(rays[i].y());
  }
};

}  // namespace

void matchRows(const Features& left, const RectifiedRays& left_rays, const Features& right,
               const RectifiedRays& right_rays, double focal_length, double row_tolerance,
               std::vector<StereoMatch>& matches) {
  matches.clear();
  const double most = 0.25 * left.image_size.width / focal_length;
  const Rows rows(right_rays);
  std::vector<StereoMatch> best_of_right(static_cast<size_t>(right.size()), {kNone, kNone, kMostDistance + 1});
  std::vector<StereoMatch> best_of_left;
  for (int i = 0; i < left.size(); ++i) {
    const Eigen::Vector2d& ray = left_rays[i];
    if (!ray.allFinite()) continue;
    const int octave = left.keypoints[i].octave;
    const double tolerance = row_tolerance * std::pow(left.scale_factor, octave) / focal_length;
    StereoMatch best = {i, kNone, kMostDistance + 1};
    auto k = static_cast<size_t>(std::lower_bound(rows.y.begin(), rows.y.end(), ray.y() - tolerance) - rows.y.begin());
    for (; k < rows.y.size() && rows.y[k] <= ray.y() + tolerance; ++k) {
      const int j = rows.order[k];
      const double disparity = ray.x() - right_rays[j].x();
      if (std::abs(right.keypoints[j].octave - octave) > 1 || disparity <= 0 || disparity > most) continue;
      const auto distance = static_cast<uint16_t>(hammingDistance(left.descriptors.row(i), right.descriptors.row(j)));
      if (distance < best.distance) best = {i, j, distance};
      if (distance < best_of_right[j].distance) best_of_right[j] = {i, j, distance};
    }
    if (best.right != kNone) best_of_left.push_back(best);
  }
  for (const StereoMatch& match : best_of_left) {
    if (best_of_right[match.right].left == match.left) matches.push_back(match);
  }
}

}  // namespace gms_ransac
