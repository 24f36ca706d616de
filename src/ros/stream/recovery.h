// The last good images, kept so that the stream can go on from one of them after a loss: dark, blurred or covered
// images, or none at all. Compares nothing and publishes nothing.
#pragma once

#include <cstddef>
#include <deque>
#include <memory>
#include <vector>

#include "scale/translation_scale.h"
#include "tracks/track_table.h"

namespace gms_ransac {

struct PreparedFrame;

/// An image whose place is known, with what is known of its keypoints; without its pixels: 240 kB at 2000 features.
struct KeptFrame {
  std::unique_ptr<PreparedFrame> frame;
  std::vector<TrackTable::Track> tracks;
  ScalePropagator scale;
};

struct RecoveryOptions {
  int frames = 0;       ///< that are kept; 0: a loss is final
  double seconds = 10;  ///< age at which a kept image is dropped
};

/// While nothing is lost, images are kept as they cease to be the reference. From `lose` on the kept ones stay as they
/// are, until `takeOut` finds the way back to one, they grow too old, or the stream goes on somewhere else.
class Recovery {
 public:
  void setOptions(const RecoveryOptions& options);
  bool enabled() const { return options_.frames > 0; }

  /// Keeps the frame as the newest; returns the frame that made room for it, if one had to.
  std::unique_ptr<PreparedFrame> keep(KeptFrame kept);
  /// The motion since the newest kept image is not known.
  void lose();
  bool lost() const { return lost_; }
  /// While lost: an image has come that is not compared with a kept one, or not with success.
  void miss() { ++missed_; }
  int missed() const { return missed_; }
  /// While lost: two images that follow on each other were compared. So many good ones in a row are a new start.
  void addPair(bool good);
  /// Gives up when the newest kept image is older than they may be at `stamp`.
  void giveUpAt(double stamp);
  void clear();

  /// Newest first.
  const std::deque<KeptFrame>& kept() const { return kept_; }
  /// The way back is found: hands over that frame, and drops those that are newer and do not show it.
  KeptFrame takeOut(size_t index);

 private:
  RecoveryOptions options_;
  std::deque<KeptFrame> kept_;
  bool lost_ = false;
  int missed_ = 0, good_pairs_ = 0;  ///< since the loss; in a row
};

}  // namespace gms_ransac
