// The track of a sensor that a topic fills, and where the camera is on it.
#pragma once

#include <mutex>
#include <string>

#include "priors/motion_track.h"
#include "priors/prior_source.h"
#include "tf_lookup.h"

namespace gms_ransac {

/// May be used from any thread.
template <typename Track>
class SensorTrack {
 public:
  /// `topic`: resolved, for sentences. `tf` knows the camera in the frame of the sensor.
  SensorTrack(const std::string& topic, TfLookup& tf) : topic_(topic), tf_(tf) {}

  void clear() {
    std::lock_guard<std::mutex> lock(mutex_);
    track_.clear();
    refused_ = 0;
  }
  /// A message in this frame came, with a defect (empty: none), or with a sample: `add(track)` returns false if its
  /// numbers are impossible.
  template <typename Add>
  void note(const std::string& frame, const std::string& defect, const Add& add) {
    std::lock_guard<std::mutex> lock(mutex_);
    frame_ = frame;
    defect_ = defect;
    refused_ = add(track_) ? 0 : refused_ + 1;
  }
  bool reaches(double stamp) const {
    std::lock_guard<std::mutex> lock(mutex_);
    return track_.reaches(stamp);
  }
  /// Motion of the sensor in its own axes. Returns an empty string, or what is missing, as the end of a sentence.
  std::string between(double from, double to, TrackMotion& motion) const {
    std::lock_guard<std::mutex> lock(mutex_);
    if (!defect_.empty()) return "the messages on " + topic_ + " have " + defect_;
    const std::string problem = track_.empty() ? "no message has come" : track_.between(from, to, motion);
    if (!problem.empty() && refused_ > 0) {
      return "the last " + std::to_string(refused_) + " messages on " + topic_ +
             " are not used: their numbers are not finite, or larger than any sensor's";
    }
    return problem.empty() ? problem : problem + " on " + topic_;
  }
  /// The same, and the camera in these axes.
  std::string between(const PriorQuery& query, TrackMotion& motion, Eigen::Isometry3d& camera_in_sensor) const {
    std::string problem = between(query.from, query.to, motion);
    if (!problem.empty()) return problem;
    std::string frame;
    {
      std::lock_guard<std::mutex> lock(mutex_);
      frame = frame_;
    }
    // Both are screwed to one body: the latest is as good as any.
    return tf_.get(frame, query.camera_frame, 0, camera_in_sensor);
  }

 private:
  const std::string topic_;
  TfLookup& tf_;
  mutable std::mutex mutex_;  ///< guards what follows
  Track track_;
  std::string frame_, defect_;  ///< of the axes; of the messages, with the remedy
  int refused_ = 0;             ///< messages in a row, up to the last one, with impossible numbers
};

}  // namespace gms_ransac
