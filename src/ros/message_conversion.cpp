#include "message_conversion.h"

#include <algorithm>

#include "frames.h"

namespace gms_ransac {

namespace {

void reserveColumns(size_t n, bool with_stage, Correspondences& message) {
  message.reference_points.clear();
  message.current_points.clear();
  message.confidence.clear();
  message.distance.clear();
  message.track_id.clear();
  message.track_length.clear();
  message.stage.clear();
  message.reference_points.reserve(2 * n);
  message.current_points.reserve(2 * n);
  message.confidence.reserve(n);
  message.distance.reserve(n);
  message.track_id.reserve(n);
  message.track_length.reserve(n);
  if (with_stage) message.stage.reserve(n);
}

}  // namespace

void toMessage(const ProcessedFrame& processed, bool with_rejected, Correspondences& message) {
  const MatchResult& result = *processed.result;
  const PreparedFrame &reference = *processed.reference, &current = *processed.current;
  message.header = current.header;
  message.reference_header = reference.header;
  message.width = static_cast<uint32_t>(current.grey.cols);
  message.height = static_cast<uint32_t>(current.grey.rows);
  const bool calibrated = current.camera->camera.calibrated();
  message.pixel_space =
      calibrated && current.camera->rectified ? Correspondences::PIXELS_RECTIFIED : Correspondences::PIXELS_RAW;
  message.K.fill(0);
  if (calibrated) {
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> K = current.camera->camera.K();
    std::copy(K.data(), K.data() + 9, message.K.begin());
  }

  reserveColumns(with_rejected ? result.matches.size() : static_cast<size_t>(result.inliers), with_rejected, message);
  for (size_t i = 0; i < result.matches.size(); ++i) {
    if (!with_rejected && result.stage[i] != MatchStage::kInlier) continue;
    const Match& match = result.matches[i];
    const cv::Point2f from = reference.frame.features.keypoints[match.reference].pt;
    const cv::Point2f to = current.frame.features.keypoints[match.current].pt;
    message.reference_points.insert(message.reference_points.end(), {from.x, from.y});
    message.current_points.insert(message.current_points.end(), {to.x, to.y});
    message.confidence.push_back(result.confidence[i]);
    message.distance.push_back(match.distance);
    message.track_id.push_back((*processed.track_ids)[i]);
    message.track_length.push_back((*processed.track_lengths)[i]);
    if (with_rejected) message.stage.push_back(static_cast<uint8_t>(result.stage[i]));
  }
  message.pose_valid = processed.poseValid();
  message.metric_scale = processed.metric_scale;
  message.current_in_reference = geometry_msgs::PoseWithCovariance();
  message.current_in_reference.pose.orientation.w = 1;
  if (processed.poseValid()) message.current_in_reference = toPoseWithCovariance(processed.pose);
}

void toMessage(const ProcessedFrame& processed, const FrameCounters& counters, MatchStats& message) {
  message = MatchStats();
  message.header = processed.current->header;
  message.status = processed.status;
  message.status_text = processed.text;
  message.keypoints_current = static_cast<uint32_t>(processed.current->frame.features.size());
  message.time_convert = static_cast<float>(processed.current->convert_seconds);
  message.time_detect = static_cast<float>(processed.current->frame.detect_seconds);
  if (processed.status == MatchStats::BAD_IMAGE) message.keypoints_current = 0;
  if (processed.result != nullptr) {
    const MatchResult& result = *processed.result;
    message.reference_header = processed.reference->header;
    message.keypoints_reference = static_cast<uint32_t>(result.keypoints_reference);
    message.matches_raw = static_cast<uint32_t>(result.matches.size());
    message.matches_gms = static_cast<uint32_t>(result.matches_gms);
    message.inliers = static_cast<uint32_t>(result.inliers);
    message.hypotheses = static_cast<uint32_t>(result.robust.effort.hypotheses);
    message.inlier_ratio = result.matches_gms > 0 ? static_cast<float>(result.inliers) / result.matches_gms : 0.f;
    message.median_parallax_px = static_cast<float>(result.robust.median_parallax_px);
    message.rms_error_px = static_cast<float>(result.robust.rms_error_px);
    message.time_match = static_cast<float>(result.times.match);
    message.time_gms = static_cast<float>(result.times.gms);
    message.time_ransac = static_cast<float>(result.times.ransac);
  }
  message.time_total =
      message.time_convert + message.time_detect + message.time_match + message.time_gms + message.time_ransac;
  message.frames_received = counters.received;
  message.frames_processed = counters.processed;
  message.frames_dropped = counters.dropped;
  message.resets = counters.resets;
}

}  // namespace gms_ransac
