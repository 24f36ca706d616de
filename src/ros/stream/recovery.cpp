#include "stream/recovery.h"

#include <algorithm>
#include <utility>

#include "stream/prepared_frame.h"

namespace gms_ransac {

namespace {

// Least seconds between the kept images, the newest left out: what spoils the last good image (a hand that comes, the
// first blur) spoils its neighbours too.
constexpr double kLeastInterval = 0.1;
// Two blurred images in a row resemble each other; five pairs in a row are a camera that sees where it goes, elsewhere.
constexpr int kNewBeginning = 5;
// Kept images that an image is compared with, at most. A comparison that fails is the slowest: it searches to the end.
constexpr size_t kTries = 3;

}  // namespace

void Recovery::keep(const Stream& stream, const RecoveryOptions& options) {
  if (kept_.size() > 1 && kept_[0].reference->stamp() - kept_[1].reference->stamp() < kLeastInterval) kept_.pop_front();
  kept_.push_front(stream);
  while (kept_.size() > static_cast<size_t>(options.frames)) kept_.pop_back();
}

void Recovery::lose() {
  lost_ = true;
  missed_ = good_pairs_ = 0;
  turn_ = 0;
}

void Recovery::addPair(bool good) {
  good_pairs_ = good ? good_pairs_ + 1 : 0;
  if (good_pairs_ >= kNewBeginning) clear();
}

void Recovery::giveUp(double stamp, const RecoveryOptions& options) {
  if (lost_ && stamp - kept_.front().reference->stamp() > options.seconds) clear();
}

void Recovery::clear() {
  kept_.clear();
  lost_ = false;
}

std::vector<size_t> Recovery::next() {
  std::vector<size_t> indices = {0};
  const size_t others = kept_.size() - 1;
  while (indices.size() < std::min(kTries, kept_.size())) indices.push_back(1 + turn_++ % others);
  return indices;
}

void Recovery::dropPixels(const PreparedFrame* reference) {
  for (const Stream& stream : kept_) {
    if (stream.reference.get() != reference) stream.reference->dropPixels();
  }
}

Stream Recovery::resume(size_t index) {
  Stream found = std::move(kept_[index]);
  kept_.erase(kept_.begin(), kept_.begin() + static_cast<std::ptrdiff_t>(index) + 1);
  lost_ = false;
  return found;
}

}  // namespace gms_ransac
