#include "stream/prepared_frame.h"

#include <utility>

namespace gms_ransac {

void PreparedFrame::dropPixels() {
  input = ImageWithInfo();
  for (cv::Mat* pixels : {&grey, &depth, &mask, &stereo.right}) pixels->release();
  stereo.right_ray.clear();
  stereo.rig.reset();
}

std::shared_ptr<PreparedFrame> FramePool::take() {
  std::unique_ptr<PreparedFrame> frame;
  {
    std::lock_guard<std::mutex> lock(mutex_);
    if (!spare_.empty()) {
      frame = std::move(spare_.back());
      spare_.pop_back();
    }
  }
  if (!frame) frame = std::make_unique<PreparedFrame>();
  return {frame.release(), [pool = weak_from_this()](PreparedFrame* used) {
            std::unique_ptr<PreparedFrame> owned(used);
            if (const auto alive = pool.lock()) alive->give(std::move(owned));
          }};
}

void FramePool::give(std::unique_ptr<PreparedFrame> frame) {
  frame->dropPixels();
  frame->pair_reference.reset();
  frame->pipeline.reset();
  std::lock_guard<std::mutex> lock(mutex_);
  spare_.push_back(std::move(frame));
}

}  // namespace gms_ransac
