#include "input/waiting_images.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace gms_ransac {

namespace {

// Messages further ahead than this are left over from before the streams started again.
constexpr double kSight = 1;  // seconds

template <typename Message>
double stampOf(const Message& message) {
  return message->header.stamp.toSec();
}

/// Adds the newest of a stream, of which the last `most` are kept.
template <typename Message>
void keep(const Message& message, size_t most, std::deque<Message>& kept) {
  // Where the stream goes back, what is ahead of it is from before.
  const auto ahead = [&](const Message& other) { return stampOf(other) >= stampOf(message); };
  kept.erase(std::remove_if(kept.begin(), kept.end(), ahead), kept.end());
  if (kept.size() >= most) kept.pop_front();
  kept.push_back(message);
}

/// Sets `message`, unless it is set, to the one of that stamp; returns true if there is one.
template <typename Message>
bool findByStamp(const ros::Time& stamp, const std::deque<Message>& kept, Message& message) {
  const auto same = [&](const Message& each) { return each->header.stamp == stamp; };
  const auto found = std::find_if(kept.begin(), kept.end(), same);
  if (message || found == kept.end()) return false;
  message = *found;
  return true;
}

}  // namespace

void WaitingImages::add(const sensor_msgs::ImageConstPtr& image, const ros::Time& received, double now,
                        const KeypointsConstPtr& keypoints) {
  Waiting waiting{{}, now, options_.second == nullptr};
  waiting.input.*options_.first = image;
  waiting.input.keypoints = keypoints;
  waiting.input.received = received;
  waiting_.push_back(waiting);
}

void WaitingImages::addSecond(const sensor_msgs::ImageConstPtr& image) { keep(image, options_.capacity, second_); }

void WaitingImages::addCameraInfo(const sensor_msgs::CameraInfoConstPtr& info) {
  keep(info, options_.info_of_each ? options_.capacity : 1, infos_);
}

void WaitingImages::addMask(const sensor_msgs::ImageConstPtr& mask) {
  keep(mask, options_.for_mask ? options_.capacity : 1, masks_);
}

void WaitingImages::clear() {
  waiting_.clear();
  second_.clear();
  passed_.reset();
  if (options_.info_of_each) infos_.clear();
  if (options_.for_mask) masks_.clear();
}

std::vector<ImageWithInfo> WaitingImages::settled(double now) {
  watchSensors(now);
  collect(now);
  std::vector<ImageWithInfo> ready;
  for (; !waiting_.empty() && waiting_.front().paired; waiting_.pop_front()) {
    ImageWithInfo& input = waiting_.front().input;
    if (!input.image) continue;  // half of a pair
    const bool late = overdue(waiting_.begin(), now);
    if (options_.info_of_each && !input.camera_info) {
      if (!late && !overtaken(&ImageWithInfo::camera_info)) break;
      ++unpaired_;
      continue;
    }
    if (lacksCameraInfo()) {
      if (!late) break;
      gave_up_camera_info_ = true;
    }
    if (waitsForSensors(now)) break;
    if (options_.for_mask && !input.mask && !late && !overtaken(&ImageWithInfo::mask)) break;
    if (!options_.info_of_each && !infos_.empty()) input.camera_info = infos_.back();
    if (!options_.for_mask && !masks_.empty()) input.mask = masks_.back();
    input.right_info = latest_right_info_;
    ready.push_back(input);
  }
  return ready;
}

void WaitingImages::collect(double now) {
  for (auto image = waiting_.begin(); image != waiting_.end(); ++image) {
    ImageWithInfo& input = image->input;
    if (!image->paired) {
      const auto partner = nearest(image);
      const bool found = partner != second_.end();
      // Images of one stream are further apart than the tolerance, so the next one cannot be as near as half of it.
      const bool near = found && std::abs(stampOf(*partner) - stamp(*image)) <= options_.tolerance / 2;
      if (!near && !passed(image) && !overdue(image, now)) return;
      image->paired = true;
      matched_ += found;
      if (found) {
        input.*options_.second = *partner;
        second_.erase(second_.begin(), std::next(partner));
      }
    }
    if (!input.image) continue;
    if (options_.info_of_each) matched_ += findByStamp(input.image->header.stamp, infos_, input.camera_info);
    if (options_.for_mask) findByStamp(input.image->header.stamp, masks_, input.mask);
  }
}

std::deque<sensor_msgs::ImageConstPtr>::iterator WaitingImages::nearest(Iterator image) {
  auto best = second_.end();
  double least = options_.tolerance;
  for (auto candidate = second_.begin(); candidate != second_.end(); ++candidate) {
    const auto distance = [&](const Waiting& to) { return std::abs(stampOf(*candidate) - stamp(to)); };
    const double difference = distance(*image);
    const bool of_another = std::any_of(std::next(image), waiting_.end(),
                                        [&](const Waiting& later) { return distance(later) < difference; });
    if (of_another || difference > least) continue;
    best = candidate;
    least = difference;
  }
  return best;
}

bool WaitingImages::passed(Iterator image) const {
  return std::any_of(second_.begin(), second_.end(), [&](const sensor_msgs::ImageConstPtr& each) {
    const double ahead = stampOf(each) - stamp(*image);
    return ahead >= 0 && ahead <= kSight;
  });
}

bool WaitingImages::waitsForSensors(double now) {
  if (!options_.sensors_reach) return false;
  const Waiting& oldest = waiting_.front();
  if (options_.sensors_reach(oldest.input.image->header)) {
    gave_up_sensors_ = false;
    return false;
  }
  if (waiting_.size() > options_.capacity || now - oldest.since >= options_.sensor_patience) gave_up_sensors_ = true;
  if (!gave_up_sensors_) return true;
  if (!passed_) passed_ = {oldest.input.image->header, oldest.since};
  return false;
}

void WaitingImages::watchSensors(double now) {
  if (!passed_) return;
  const bool late = now - passed_->since >= options_.sensor_patience;
  const bool reached = options_.sensors_reach(passed_->header);
  if (reached && !late) gave_up_sensors_ = false;
  if (reached || late) passed_.reset();
}

bool WaitingImages::lacksCameraInfo() const {
  const bool left = options_.for_camera_info && infos_.empty();
  return (left || lacksRightInfo()) && !gave_up_camera_info_;
}

template <typename Message>
bool WaitingImages::overtaken(Message ImageWithInfo::*what) const {
  return std::any_of(std::next(waiting_.begin()), waiting_.end(),
                     [&](const Waiting& later) { return later.input.*what != nullptr; });
}

bool WaitingImages::overdue(Iterator image, double now) const {
  const bool restarted = stamp(waiting_.back()) < stamp(*image) - kSight;
  const auto behind = static_cast<size_t>(waiting_.end() - image);  // and it
  return restarted || behind > options_.capacity || now - image->since >= options_.patience;
}

}  // namespace gms_ransac
