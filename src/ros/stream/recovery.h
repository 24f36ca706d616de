// The last good states of the stream, kept so that it can go on from one of them after a loss: dark, blurred or covered
// images, or none at all. Compares nothing and publishes nothing.
#pragma once

#include <cstddef>
#include <deque>
#include <vector>

#include "stream/stream.h"

namespace gms_ransac {

/// While nothing is lost, the stream is kept as it leaves each reference. From `lose` on the kept ones stay as they
/// are, until the stream goes on from one of them or somewhere else, or they grow too old.
class Recovery {
 public:
  /// Keeps a copy as the newest. Its reference is a place that is known.
  void keep(const Stream& stream, const RecoveryOptions& options);
  /// The motion since the newest kept stream is not known.
  void lose();
  bool lost() const { return lost_; }
  /// While lost: an image has come that is not compared with a kept one, or not with success.
  void miss() { ++missed_; }
  int missed() const { return missed_; }
  /// While lost: two images that follow on each other were compared. So many good ones in a row are a new start.
  void addPair(bool good);
  /// Gives up when the newest kept reference is older than it may be at `stamp`.
  void giveUp(double stamp, const RecoveryOptions& options);
  void clear();

  /// Newest first.
  const std::deque<Stream>& kept() const { return kept_; }
  /// Indices of those that the next image is compared with: the newest, and the others one after the other.
  std::vector<size_t> next();
  /// Releases pixels that no answer shows any more. `reference`: of the last answer.
  void dropPixels(const PreparedFrame* reference);
  /// Hands over the kept stream that the image continues, and forgets the newer ones, which show another place.
  Stream resume(size_t index);

 private:
  std::deque<Stream> kept_;
  bool lost_ = false;
  int missed_ = 0, good_pairs_ = 0;  ///< since the loss; in a row
  size_t turn_ = 0;                  ///< which of the others is compared next
};

}  // namespace gms_ransac
