#include "output/message_conversion.h"

#include <algorithm>
#include <utility>

#include "frames.h"
#include "quantiles.h"
#include "two_view/sigma_by_octave.h"

namespace gms_ransac {

namespace {

/// Rows of an image over the focal length in pixels; 0 without a calibration.
double rowsInFocalLengths(const PreparedFrame& frame) {
  const CameraModel* camera = frame.image.camera.get();
  if (camera == nullptr || !camera->camera.calibrated()) return 0;
  return frame.imageSize().height / camera->camera.meanFocalLength();
}

/// Sets the fields pixel_space and K of a message.
template <typename Message>
void setCamera(const CameraModel& model, Message& message) {
  const bool calibrated = model.camera.calibrated();
  message.pixel_space = calibrated && model.rectified() ? Message::PIXELS_RECTIFIED : Message::PIXELS_RAW;
  message.K.fill(0);
  if (!calibrated) return;
  const CameraIntrinsics& k = model.camera.intrinsics();
  message.K = {k.fx, 0, k.cx, 0, k.fy, k.cy, 0, 0, 1};
}

/// Every column at its length, at once: it is written by index, and nothing is allocated on the way.
void setLength(size_t n, bool with_stage, Correspondences& message) {
  message.reference_points.resize(2 * n);
  message.current_points.resize(2 * n);
  message.confidence.resize(n);
  message.distance.resize(n);
  message.track_id.resize(n);
  message.track_length.resize(n);
  message.stage.resize(with_stage ? n : 0);
  message.probability.resize(n);
  message.reference_sigma.resize(n);
  message.current_sigma.resize(n);
}

}  // namespace

void toMessage(const ProcessedFrame& processed, bool with_rejected, Correspondences& message) {
  const MatchResult& result = processed.pair->result;
  const PreparedFrame& current = *processed.current;
  message.header = current.image.header;
  message.reference_header = processed.pair->reference->image.header;
  message.width = static_cast<uint32_t>(current.imageSize().width);
  message.height = static_cast<uint32_t>(current.imageSize().height);
  setCamera(*current.image.camera, message);

  setLength(with_rejected ? result.raw.size() : static_cast<size_t>(result.inliers), with_rejected, message);
  const Features &reference_features = processed.pair->reference->frame.features,
                 &current_features = current.frame.features;
  const SigmaByOctave reference_sigma(result.robust.judgement, reference_features.scale_factor),
      current_sigma(result.robust.judgement, current_features.scale_factor);
  size_t entry = 0;
  result.forEachRaw([&](const Match& match, MatchStage stage, size_t row) {
    if (!with_rejected && stage != MatchStage::kInlier) return;
    const bool kept = stage != MatchStage::kRaw;
    const cv::KeyPoint& from = reference_features.keypoints[match.reference];
    const cv::KeyPoint& to = current_features.keypoints[match.current];
    if (with_rejected) message.stage[entry] = static_cast<uint8_t>(stage);
    message.reference_points[2 * entry] = from.pt.x;
    message.reference_points[2 * entry + 1] = from.pt.y;
    const cv::Point2f& pixel = kept ? result.current_pixel[row] : to.pt;
    message.current_points[2 * entry] = pixel.x;
    message.current_points[2 * entry + 1] = pixel.y;
    message.confidence[entry] = kept ? result.confidence[row] : 0;
    message.distance[entry] = match.distance;
    message.track_id[entry] = kept ? processed.pair->track_ids[row] : 0;
    message.track_length[entry] = kept ? processed.pair->track_lengths[row] : 0;
    message.probability[entry] = kept ? result.probability(row) : 0;
    const bool aligned = kept && result.pairs.isAligned(row);
    message.reference_sigma[entry] = reference_sigma.of(from.octave, aligned);
    message.current_sigma[entry++] = current_sigma.of(to.octave, aligned);
  });
  const RelativePose* pose = processed.posePublished();
  message.pose_valid = pose != nullptr;
  const Judgement& judgement = processed.pair->result.robust.judgement;
  message.pose_probability = static_cast<float>(judgement.pose_probability);
  message.rotation_probability = static_cast<float>(judgement.rotation_probability);
  message.metric_scale = processed.metric_scale;
  message.current_in_reference = geometry_msgs::PoseWithCovariance();
  message.current_in_reference.pose.orientation.w = 1;
  if (pose != nullptr) message.current_in_reference = toMessage(toIsometry(*pose), pose->covariance);
}

void toMessage(const ProcessedFrame& processed, Keypoints& message) {
  const PreparedFrame& current = *processed.current;
  const Features& features = current.frame.features;
  message.header = current.image.header;
  message.width = static_cast<uint32_t>(features.image_size.width);
  message.height = static_cast<uint32_t>(features.image_size.height);
  setCamera(*current.image.camera, message);
  message.scale_factor = features.scale_factor;
  const auto n = static_cast<size_t>(features.size());
  for (auto* column : {&message.u, &message.v, &message.size, &message.angle, &message.response, &message.sigma}) {
    column->reserve(n);
  }
  const bool has_model = processed.pair != nullptr && processed.pair->result.robust.model_found;
  const Judgement no_model;
  const SigmaByOctave sigma(has_model ? processed.pair->result.robust.judgement : no_model, features.scale_factor);
  for (const cv::KeyPoint& keypoint : features.keypoints) {
    message.u.push_back(keypoint.pt.x);
    message.v.push_back(keypoint.pt.y);
    message.octave.push_back(static_cast<uint8_t>(keypoint.octave));
    message.size.push_back(keypoint.size);
    message.angle.push_back(keypoint.angle);
    message.response.push_back(keypoint.response);
    message.sigma.push_back(sigma[keypoint.octave]);
  }
  message.track_id.assign(n, 0);
  if (processed.pair != nullptr) {
    const std::vector<uint32_t>& ids = processed.pair->track_ids;
    for (size_t row = 0; row < ids.size(); ++row) {
      if (ids[row] != 0) message.track_id[processed.pair->result.matches[row].current] = ids[row];
    }
  }
  message.depth = current.stereo.depth;
  const cv::Mat rows = features.descriptors.asMat();  // in one piece
  message.descriptor_type = rows.depth() == CV_32F ? Keypoints::DESCRIPTOR_FLOAT32 : Keypoints::DESCRIPTOR_BINARY;
  message.descriptor_size = static_cast<uint32_t>(rows.cols * rows.elemSize());
  if (n > 0) message.descriptors.assign(rows.data, rows.data + n * message.descriptor_size);
}

void toMessage(const ProcessedFrame& processed, const FrameCounters& counters, MatchStats& message) {
  message = MatchStats();
  message.header = processed.current->image.header;
  message.status = processed.publishedStatus();
  message.status_text = processed.text;
  message.keypoints_current = static_cast<uint32_t>(processed.current->frame.features.size());
  message.time_convert = static_cast<float>(processed.current->image.convert_seconds);
  message.time_detect = static_cast<float>(processed.current->frame.detect_seconds);
  message.time_budget = static_cast<float>(processed.current->image.time_budget);
  message.features_asked = static_cast<uint32_t>(processed.current->frame.features_asked);
  if (processed.status == MatchStats::BAD_IMAGE) message.keypoints_current = message.features_asked = 0;
  if (processed.pair != nullptr) {
    const MatchResult& result = processed.pair->result;
    message.reference_header = processed.pair->reference->image.header;
    message.keypoints_reference = static_cast<uint32_t>(result.keypoints_reference);
    message.stationary = result.stationary;
    message.matches_raw = static_cast<uint32_t>(result.raw.size());
    message.matches_gms = static_cast<uint32_t>(result.size());
    message.inliers = static_cast<uint32_t>(result.inliers);
    message.hypotheses = static_cast<uint32_t>(result.robust.effort.hypotheses);
    message.search_cut = result.robust.effort.search_cut;
    message.refinement_cut = result.robust.effort.refinement_cut;
    message.inlier_ratio = result.size() > 0 ? static_cast<float>(result.inliers) / result.size() : 0.f;
    message.median_parallax_px = static_cast<float>(result.robust.judgement.median_parallax_px);
    message.rms_error_px = static_cast<float>(result.robust.rms_error_px);
    message.sigma_px = static_cast<float>(result.robust.judgement.sigma_px);
    message.shutter = result.shutter.kind;
    const double focal_lengths = rowsInFocalLengths(*processed.current);
    message.shutter_readout = static_cast<float>(focal_lengths * result.shutter.readout);
    message.shutter_readout_sigma = static_cast<float>(focal_lengths * result.shutter.deviation);
    message.pose_probability = static_cast<float>(result.robust.judgement.pose_probability);
    message.rotation_probability = static_cast<float>(result.robust.judgement.rotation_probability);
    message.camera_misfit = static_cast<float>(result.robust.judgement.camera_misfit);
    if (processed.rig) {
      Eigen::Map<Eigen::Vector4f>(message.disparity_error.data()) = processed.rig->mean().cast<float>();
      Eigen::Map<Eigen::Vector4f>(message.disparity_error_sigma.data()) = processed.rig->deviation().cast<float>();
    }
    if (processed.offset) {
      message.inverse_depth_error = static_cast<float>(processed.offset->mean());
      message.inverse_depth_error_sigma = static_cast<float>(processed.offset->deviation());
    }
    message.time_match = static_cast<float>(processed.times.match);
    message.time_gms = static_cast<float>(processed.times.gms);
    message.time_ransac = static_cast<float>(processed.times.ransac);
    std::vector<uint16_t> lengths;
    lengths.reserve(processed.pair->track_lengths.size());
    for (const uint16_t length : processed.pair->track_lengths) {
      if (length > 0) lengths.push_back(length);
    }
    const auto [median, p90] = quantilesOf(std::move(lengths));
    message.track_length_median = median;
    message.track_length_p90 = p90;
  }
  message.time_total =
      message.time_convert + message.time_detect + message.time_match + message.time_gms + message.time_ransac;
  message.frames_received = counters.received;
  message.frames_processed = counters.processed;
  message.frames_passed_over = counters.passed_over;
  message.frames_dropped = counters.dropped;
  message.resets = counters.resets;
}

}  // namespace gms_ransac
