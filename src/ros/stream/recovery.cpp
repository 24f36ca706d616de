#include "stream/recovery.h"

#include <utility>

#include "stream/prepared_frame.h"

namespace gms_ransac {

namespace {

// Least seconds between the kept images, the newest left out: what spoils the last good image (a hand that comes, the
// first blur) spoils its neighbours too.
constexpr double kApart = 0.1;
// Two blurred images in a row resemble each other; five pairs in a row are a camera that sees where it goes, elsewhere.
constexpr int kNewBeginning = 5;

}  // namespace

void Recovery::setOptions(const RecoveryOptions& options) {
  options_ = options;
  if (!enabled()) clear();
}

std::unique_ptr<PreparedFrame> Recovery::keep(KeptFrame kept) {
  // Pixels may belong to the driver's buffers; a comparison needs features alone.
  kept.frame->input = ImageWithInfo();
  StereoColumns& stereo = kept.frame->stereo;
  for (cv::Mat* pixels : {&kept.frame->grey, &kept.frame->depth, &kept.frame->mask, &stereo.right}) pixels->release();
  stereo.right_ray.clear();
  stereo.rig.reset();
  std::unique_ptr<PreparedFrame> dropped;
  if (kept_.size() > 1 && kept_[0].frame->stamp() - kept_[1].frame->stamp() < kApart) {
    dropped = std::move(kept_.front().frame);
    kept_.pop_front();
  }
  kept_.push_front(std::move(kept));
  while (kept_.size() > static_cast<size_t>(options_.frames)) {
    dropped = std::move(kept_.back().frame);
    kept_.pop_back();
  }
  return dropped;
}

void Recovery::lose() {
  lost_ = true;
  missed_ = good_pairs_ = 0;
}

void Recovery::addPair(bool good) {
  good_pairs_ = good ? good_pairs_ + 1 : 0;
  if (good_pairs_ >= kNewBeginning) clear();
}

void Recovery::giveUpAt(double stamp) {
  if (lost_ && stamp - kept_.front().frame->stamp() > options_.seconds) clear();
}

void Recovery::clear() {
  kept_.clear();
  lost_ = false;
}

KeptFrame Recovery::takeOut(size_t index) {
  KeptFrame found = std::move(kept_[index]);
  kept_.erase(kept_.begin(), kept_.begin() + static_cast<std::ptrdiff_t>(index) + 1);
  lost_ = false;
  return found;
}

}  // namespace gms_ransac
