#include "input/image_pairing.h"

#include <algorithm>
#include <cmath>

namespace gms_ransac {

namespace {

// A second image further ahead than this is of another time: left over from before the streams started again.
constexpr double kSight = 1;  // seconds

double stamp(const sensor_msgs::ImageConstPtr& image) { return image->header.stamp.toSec(); }

double distance(const sensor_msgs::ImageConstPtr& a, const sensor_msgs::ImageConstPtr& b) {
  return std::abs(stamp(a) - stamp(b));
}

}  // namespace

void ImagePairing::addFirst(const sensor_msgs::ImageConstPtr& image, double now) { first_.push_back({image, now}); }

void ImagePairing::addSecond(const sensor_msgs::ImageConstPtr& image) {
  // Where the stream goes back, what is ahead of it is from before.
  const auto ahead = [&](const sensor_msgs::ImageConstPtr& other) { return stamp(other) >= stamp(image); };
  second_.erase(std::remove_if(second_.begin(), second_.end(), ahead), second_.end());
  if (second_.size() >= options_.capacity) second_.pop_front();
  second_.push_back(image);
}

std::vector<ImagePair> ImagePairing::settled(double now) {
  std::vector<ImagePair> pairs;
  while (!first_.empty()) {
    const auto partner = nearest();
    const bool found = partner != second_.end();
    // Images of one stream are further apart than the tolerance, so the next one cannot be as near as half of it.
    const bool near = found && distance(*partner, first_.front().image) <= options_.tolerance / 2;
    if (!near && !passed() && !overdue(now)) break;
    pairs.push_back({first_.front().image, found ? *partner : nullptr});
    first_.pop_front();
    if (found) second_.erase(second_.begin(), std::next(partner));
  }
  return pairs;
}

void ImagePairing::clear() {
  first_.clear();
  second_.clear();
}

std::deque<sensor_msgs::ImageConstPtr>::iterator ImagePairing::nearest() {
  const sensor_msgs::ImageConstPtr& image = first_.front().image;
  auto best = second_.end();
  for (auto candidate = second_.begin(); candidate != second_.end(); ++candidate) {
    const double difference = distance(*candidate, image);
    const bool of_another = std::any_of(std::next(first_.begin()), first_.end(), [&](const Waiting& later) {
      return distance(*candidate, later.image) < difference;
    });
    if (difference > options_.tolerance || of_another) continue;
    if (best == second_.end() || difference < distance(*best, image)) best = candidate;
  }
  return best;
}

bool ImagePairing::passed() const {
  return std::any_of(second_.begin(), second_.end(), [&](const sensor_msgs::ImageConstPtr& image) {
    const double ahead = stamp(image) - stamp(first_.front().image);
    return ahead >= 0 && ahead <= kSight;
  });
}

bool ImagePairing::overdue(double now) const {
  const Waiting& oldest = first_.front();
  const bool restarted = stamp(first_.back().image) < stamp(oldest.image);
  return restarted || first_.size() > options_.capacity || now - oldest.since >= options_.patience;
}

}  // namespace gms_ransac
