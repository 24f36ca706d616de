#include "matching/guided_windows.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace gms_ransac {

namespace {

/// Fewer: more runs for each window; more: more descriptors beside it.
constexpr float kKeypointsABucket = 2;
constexpr float kLeastSide = 2;  ///< of a bucket, pixels

int clampedFloor(float value, int count) {
  return static_cast<int>(std::min(std::max(std::floor(value), 0.f), static_cast<float>(count - 1)));
}

}  // namespace

int GuidedWindows::column(float x) const { return clampedFloor(x * buckets_per_pixel_, columns_); }
int GuidedWindows::row(float y) const { return clampedFloor(y * buckets_per_pixel_, rows_); }

void GuidedWindows::setCurrent(const Features& current, const HammingKernel& kernel, int seats) {
  kernel_ = &kernel;
  const auto n = static_cast<size_t>(current.size());
  const cv::Size image = current.image_size;
  const float area_a_bucket = kKeypointsABucket * static_cast<float>(image.area()) / static_cast<float>(n);
  buckets_per_pixel_ = 1 / std::max(std::sqrt(area_a_bucket), kLeastSide);
  columns_ = static_cast<int>(static_cast<float>(image.width) * buckets_per_pixel_) + 1;
  rows_ = static_cast<int>(static_cast<float>(image.height) * buckets_per_pixel_) + 1;

  // Counting sort; keypoints of one bucket stay in order. first_[b + 1] is where the next one of bucket b goes.
  first_.assign(static_cast<size_t>(columns_) * rows_ + 2, 0);
  bucket_.resize(n);
  for (size_t i = 0; i < n; ++i) {
    const cv::Point2f& point = current.keypoints[i].pt;
    bucket_[i] = row(point.y) * columns_ + column(point.x);
    ++first_[static_cast<size_t>(bucket_[i]) + 2];
  }
  for (size_t b = 2; b < first_.size(); ++b) first_[b] += first_[b - 1];
  index_.resize(n + kRowsReadPast);
  descriptors_.resize((n + kRowsReadPast) * kHammingBytes);
  for (size_t i = 0; i < n; ++i) {
    const auto place = static_cast<size_t>(first_[static_cast<size_t>(bucket_[i]) + 1]++);
    index_[place] = static_cast<int32_t>(i);
    std::memcpy(&descriptors_[place * kHammingBytes], current.descriptors.row(static_cast<int>(i)), kHammingBytes);
  }
  runs_.resize(static_cast<size_t>(rows_) * static_cast<size_t>(seats));
}

NearestTwo GuidedWindows::search(const uint8_t* query, const cv::Point2f& center, const cv::Point2f& reach, int seat) {
  const int left = column(center.x - reach.x), right = column(center.x + reach.x);
  const int top = row(center.y - reach.y), bottom = row(center.y + reach.y);
  RowRun* runs = &runs_[static_cast<size_t>(rows_) * static_cast<size_t>(seat)];
  int run_count = 0;
  for (int y = top; y <= bottom; ++y) {
    const int32_t* buckets = &first_[static_cast<size_t>(y) * columns_];
    const RowRun run = {buckets[left], buckets[right + 1]};
    if (run.first < run.last) runs[run_count++] = run;
  }
  return kernel_->searchRuns(query, descriptors_.data(), index_.data(), runs, run_count);
}

}  // namespace gms_ransac
