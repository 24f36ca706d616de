#include "judgement/second_body.h"

#include <array>

#include "ransac/motion_starts.h"

namespace gms_ransac {

namespace {

/// Among what the pose does not explain another motion may explain this share of what the pose does; more is a second
/// body as likely to be the world as the first.
constexpr double kSecondBody = 0.8;
/// Less where the pose may join both: its matches contradict the camera model, as those of one body do by chance in one
/// pair of a hundred, or the second's lie among the first's, as those of a pattern that repeats itself.
constexpr double kSecondJoined = 0.6, kByChance = 1;
/// Of the second's matches, in blocks that are the first's for the most part: as a pattern's, and hardly as a body's.
constexpr double kMostAmong = 0.4;
constexpr int kCellsOfBlock = 2, kBlockSide = kSpreadGridSide / kCellsOfBlock;
constexpr int kIterations = 10;

/// Whether the pose explains the match of a column.
bool isExplained(const JudgedPose& judged, size_t column) { return judged.noise.probabilities()[column] >= 0.5f; }

/// Whether the matches of a second motion lie among those of the first, as those of a repeated pattern do, and not in a
/// part of the view of their own. `second`: of each column whether it is the second's.
bool lieAmong(const JudgedPose& judged, const std::vector<uint8_t>& second) {
  struct Block {
    int first = 0, second = 0;
  };
  std::array<Block, kBlockSide * kBlockSide> blocks;
  const std::vector<int32_t>& cells = judged.points.cells();
  for (size_t i = 0; i < second.size(); ++i) {
    const auto row = static_cast<size_t>(cells[i] / kSpreadGridSide / kCellsOfBlock);
    const auto column = static_cast<size_t>(cells[i] % kSpreadGridSide / kCellsOfBlock);
    Block& block = blocks[row * kBlockSide + column];
    block.first += isExplained(judged, i);
    block.second += second[i];
  }
  int all = 0, among = 0;
  for (const Block& block : blocks) {
    all += block.second;
    if (block.first > block.second) among += block.second;
  }
  return among > kMostAmong * all;
}

/// Whether a second motion may be the world as well as the pose. `share`: of what it explains in what the pose does;
/// `second`: of each column whether it is the second's.
bool mayBeWorld(const JudgedPose& judged, double share, const std::vector<uint8_t>& second) {
  if (share <= kSecondJoined) return false;
  return share > kSecondBody || judged.spread.contradiction > kByChance || lieAmong(judged, second);
}

}  // namespace

bool SecondBody::isRival(const JudgedPose& judged, const BodyParting& bodies, int64_t& evaluations) {
  if (bodies.found() && mayBeWorld(judged, bodies.smallerShare(), bodies.apart())) return true;
  const int explained = collectRest(judged);
  if (static_cast<double>(rest_.size()) < kSecondJoined * explained) return false;
  takeUpRest(judged.points.view());
  findMotionStarts(kernels_, rest_points_.view(), motions_, evaluations);
  for (TwoViewPose& motion : motions_) {
    const double share = static_cast<double>(explainRest(motion, evaluations)) / explained;
    if (mayBeWorld(judged, share, second_)) return true;
  }
  return false;
}

int SecondBody::collectRest(const JudgedPose& judged) {
  const int count = judged.points.size();
  rest_.clear();
  for (int i = 0; i < count; ++i) {
    if (!isExplained(judged, static_cast<size_t>(i))) rest_.push_back(i);
  }
  return count - static_cast<int>(rest_.size());
}

void SecondBody::takeUpRest(const PointColumnsView& points) {
  rest_points_.gather(points, rest_.data(), static_cast<int>(rest_.size()));
  residuals_.resize(static_cast<size_t>(points.size));
  second_.resize(static_cast<size_t>(points.count));
}

int SecondBody::explainRest(TwoViewPose& motion, int64_t& evaluations) {
  const PoseModel model(kernels_, rest_points_.view());
  model.refine(kRobustLoss, kIterations, motion);
  model.residualsInFront(motion, residuals_.data());
  evaluations += static_cast<int64_t>(rest_.size());
  second_.assign(second_.size(), 0);
  int count = 0;
  for (size_t k = 0; k < rest_.size(); ++k) {
    count += second_[static_cast<size_t>(rest_[k])] = residuals_[k] < 1;
  }
  return count;
}

}  // namespace gms_ransac
