// One image of a stream: selects its reference, has them compared and moves the stream on. Publishes nothing.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "stream/processed_frame.h"
#include "stream/recovery.h"

namespace gms_ransac {

/// Storage of pairs, used again once no answer holds it. Used by one thread.
class PairPool {
 public:
  std::shared_ptr<ComparedPair> acquire();
  /// Lets go of the references of pairs that no answer holds.
  void releaseFrames();

 private:
  std::vector<std::shared_ptr<ComparedPair>> pairs_;
};

/// The current image against references: one of these comparisons becomes the answer.
struct Comparison {
  Pipeline& pipeline;
  Stream& stream;
  PairPool& pairs;
  const std::shared_ptr<PreparedFrame>& current;
  ProcessedFrame answer = ProcessedFrame();

  void because(Why why, const std::string& detail = std::string()) { answer.reasons.push_back({why, detail}); }

  /// Answers by comparison with the stream's reference. Never throws.
  void compare();
  /// Matches, filters, estimates. If the calibration changed since the reference, that becomes a copy whose keypoints
  /// are where the camera shows them now.
  std::shared_ptr<ComparedPair> attempt(const std::shared_ptr<PreparedFrame>& reference,
                                        const RotationPrior* prior = nullptr, Past* past = nullptr);
  /// Answers by this pair: status, tracks and pose.
  void conclude(const std::shared_ptr<ComparedPair>& pair);
  /// Answers that the comparison with this reference threw.
  void fail(const std::shared_ptr<PreparedFrame>& reference, const std::string& what);
};

/// Answers a usable image. The stream becomes that after the image; `recovery` keeps earlier ones. Never throws.
ProcessedFrame step(Pipeline& pipeline, Stream& stream, Recovery& recovery, PairPool& pairs,
                    const std::shared_ptr<PreparedFrame>& current);

}  // namespace gms_ransac
