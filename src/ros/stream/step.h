// One image of a stream: selects its reference, has them compared and moves the stream on. Publishes nothing.
#pragma once

#include <memory>
#include <string>

#include "stream/processed_frame.h"
#include "stream/recovery.h"

namespace gms_ransac {

/// Storage that an answer points to until the next image.
struct Workspace {
  MatchResult result, kept_result;
  Triangulation points;
  StageTimes spent;                                   ///< in all comparisons of the image
  std::shared_ptr<PreparedFrame> current, reference;  ///< of the answer
};

/// The current image against one reference: the answer, and what the stream knows of the pair.
struct Comparison {
  Pipeline& pipeline;
  Stream& stream;
  Workspace& work;
  const std::shared_ptr<PreparedFrame>& current;
  ProcessedFrame answer = ProcessedFrame();

  void because(Why why, const std::string& detail = std::string()) { answer.reasons.push_back({why, detail}); }

  /// Answers by comparison with the stream's reference. Never throws.
  void compare();
  /// Matches, filters, estimates. If the calibration changed since the reference, that becomes a copy whose keypoints
  /// are where the camera shows them now.
  void match(std::shared_ptr<PreparedFrame>& reference, MatchResult& result, const RotationPrior* prior = nullptr,
             Past* past = nullptr);
  /// Treats the pair as one without a model.
  static void reject(MatchResult& result);
  /// The answer is about the result of the workspace, with this reference.
  void answerBy(const std::shared_ptr<PreparedFrame>& reference);
  /// Sets status, tracks and pose.
  void conclude();
  void fail(const std::string& what);
};

/// Answers a usable image. The stream becomes that after the image; `recovery` keeps earlier ones. Never throws.
ProcessedFrame step(Pipeline& pipeline, Stream& stream, Recovery& recovery, Workspace& work,
                    const std::shared_ptr<PreparedFrame>& current);

}  // namespace gms_ransac
