#include "gms/motion_predictor.h"

#include <algorithm>
#include <cmath>

namespace gms_ransac {

namespace {

// Chosen on kitti_06 (gaps 1, 5), tum_fr1_desk (1, 4) and tum_fr1_rpy (5), doc/guided_search.md.

/// Of all the matches that must be accepted before any is believed: of unrelated images the statistics accept 0.05, at
/// most 0.10 (53 pairs), of kitti_06 at gap 10, a dozen metres, 0.24.
constexpr double kLeastAccepted = 0.15;
/// What a cell needs: so many accepted matches in it and around it, and such a share of all there. Where it is not
/// enough the next ring of cells is asked, too.
constexpr double kLeastMatches = 6;
constexpr double kLeastShare[] = {0.3, 0.2};
constexpr int kRings = 2;

/// Fits, each without the matches that the one before leaves more than kOutlierSigmas away.
constexpr int kPasses = 2;
constexpr double kOutlierSigmas = 2.5;
/// Half a window in standard deviations of the displacements about their fit, beside a margin for what the fit does not
/// know: a share of the square root of the image's area.
constexpr double kReachSigmas = 2;
constexpr double kMargin = 0.005;

}  // namespace

void MotionPredictor::Moments::add(const cv::Point2f& position, const cv::Point2f& displacement) {
  const double px = position.x, py = position.y;
  count += 1;
  x += px;
  y += py;
  xx += px * px;
  xy += px * py;
  yy += py * py;
  const double displacements[2] = {displacement.x, displacement.y};
  for (int k = 0; k < 2; ++k) {
    const double d = displacements[k];
    axis[k].d += d;
    axis[k].xd += px * d;
    axis[k].yd += py * d;
    axis[k].dd += d * d;
  }
}

void MotionPredictor::Moments::add(const Moments& other) {
  count += other.count;
  x += other.x;
  y += other.y;
  xx += other.xx;
  xy += other.xy;
  yy += other.yy;
  for (int k = 0; k < 2; ++k) {
    axis[k].d += other.axis[k].d;
    axis[k].xd += other.axis[k].xd;
    axis[k].yd += other.axis[k].yd;
    axis[k].dd += other.axis[k].dd;
  }
}

const MotionPrediction& MotionPredictor::predict(const Features& reference, const Features& current,
                                                 const std::vector<Match>& matches,
                                                 const MotionStatistics& statistics) {
  const cv::Size image = reference.image_size;
  prediction_.cells.clear();
  if (statistics.accepted_count < kLeastAccepted * static_cast<double>(matches.size())) return prediction_;
  prediction_.columns = statistics.grid_columns;
  prediction_.rows = statistics.grid_rows;
  const size_t cells = static_cast<size_t>(prediction_.columns) * prediction_.rows;
  prediction_.cells.assign(cells, CellMotion());
  cell_ = {static_cast<double>(image.width) / prediction_.columns,
           static_cast<double>(image.height) / prediction_.rows};
  margin_ = static_cast<float>(kMargin * std::sqrt(static_cast<double>(image.area())));
  all_.assign(cells, 0);
  for (const int32_t cell : statistics.cell) ++all_[static_cast<size_t>(cell)];
  for (int pass = 0; pass < kPasses; ++pass) {
    collect(reference, current, matches, statistics);
    fitCells();
  }
  return prediction_;
}

void MotionPredictor::collect(const Features& reference, const Features& current, const std::vector<Match>& matches,
                              const MotionStatistics& statistics) {
  moments_.assign(prediction_.cells.size(), Moments());
  const auto far = [this](float apart, float reach) {
    constexpr float kPixel = 1;  // the noise of keypoints, where all others agree better than that
    const auto sigma = static_cast<float>((reach - margin_) / kReachSigmas);
    return std::abs(apart) > kOutlierSigmas * sigma + kPixel;
  };
  for (size_t i = 0; i < matches.size(); ++i) {
    if (!statistics.accepted[i]) continue;
    const auto cell = static_cast<size_t>(statistics.cell[i]);
    const cv::Point2f& from = reference.keypoints[static_cast<size_t>(matches[i].reference)].pt;
    const cv::Point2f& to = current.keypoints[static_cast<size_t>(matches[i].current)].pt;
    const CellMotion& motion = prediction_.cells[cell];
    if (motion.known) {
      const cv::Point2f apart = to - motion.predict(from);
      if (far(apart.x, motion.reach.x) || far(apart.y, motion.reach.y)) continue;
    }
    moments_[cell].add(from, to - from);
  }
}

void MotionPredictor::fitCells() {
  for (int row = 0; row < prediction_.rows; ++row) {
    for (int column = 0; column < prediction_.columns; ++column) {
      CellMotion& motion = prediction_.cells[static_cast<size_t>(row) * prediction_.columns + column];
      motion.known = false;
      for (int ring = 1; ring <= kRings && !motion.known; ++ring) motion.known = fit(column, row, ring, motion);
    }
  }
}

bool MotionPredictor::fit(int column, int row, int rings, CellMotion& motion) const {
  Moments sum;
  int all = 0;
  for (int v = std::max(row - rings, 0); v <= std::min(row + rings, prediction_.rows - 1); ++v) {
    for (int u = std::max(column - rings, 0); u <= std::min(column + rings, prediction_.columns - 1); ++u) {
      const size_t cell = static_cast<size_t>(v) * prediction_.columns + u;
      sum.add(moments_[cell]);
      all += all_[cell];
    }
  }
  if (sum.count < kLeastMatches || sum.count < kLeastShare[rings - 1] * all) return false;

  // Least squares, with the weight of one match at a cell's distance that the displacement is everywhere the same.
  const double x = sum.x / sum.count, y = sum.y / sum.count;
  const double xx = sum.xx - sum.x * x + cell_.width * cell_.width;
  const double yy = sum.yy - sum.y * y + cell_.height * cell_.height;
  const double xy = sum.xy - sum.x * y;
  const double determinant = xx * yy - xy * xy;
  float displacement[2], per_x[2], per_y[2], reach[2];
  for (int k = 0; k < 2; ++k) {
    const Moments::Axis& axis = sum.axis[k];
    const double d = axis.d / sum.count;
    const double xd = axis.xd - sum.x * d, yd = axis.yd - sum.y * d, dd = axis.dd - axis.d * d;
    const double slope_x = (xd * yy - yd * xy) / determinant, slope_y = (yd * xx - xd * xy) / determinant;
    constexpr double kFitted = 3;  // numbers
    const double variance = std::max(dd - slope_x * xd - slope_y * yd, 0.) / std::max(sum.count - kFitted, 1.);
    displacement[k] = static_cast<float>(d);
    per_x[k] = static_cast<float>(slope_x);
    per_y[k] = static_cast<float>(slope_y);
    reach[k] = static_cast<float>(kReachSigmas * rings * std::sqrt(variance)) + margin_;
  }
  motion.center = {static_cast<float>(x), static_cast<float>(y)};
  motion.displacement = {displacement[0], displacement[1]};
  motion.per_x = {per_x[0], per_x[1]};
  motion.per_y = {per_y[0], per_y[1]};
  motion.reach = {reach[0], reach[1]};
  return true;
}

}  // namespace gms_ransac
