#include "stream/parts_of_the_way.h"

#include <algorithm>

namespace gms_ransac {

namespace {

constexpr double kBetween = 0.1;    // seconds between two beginnings
constexpr double kRounding = 1e-6;  // of stamps, relative

bool covers(double covered, double length) { return covered >= length * (1 - kRounding); }

}  // namespace

OdometryEstimate publishedOf(const Parameters& parameters, const MotionIntegrator& place,
                             const ProcessedFrame& answer) {
  OdometryEstimate estimate = place.camera();
  if (!parameters.givesMetres() && answer.pair) forgetLength(answer.atRest(), estimate);
  return estimate;
}

std::vector<OdometryPart> PartsOfTheWay::add(const Parameters& parameters, const ProcessedFrame& answer) {
  if (answer.place_restarted) *this = PartsOfTheWay();
  moveOn(parameters, answer);
  std::vector<OdometryPart> ended;
  if (!answer.place) return ended;
  for (Beginning& b : begun_) {
    const auto end = [&](double covered, bool metres, size_t& next) {
      if (next == kLengths.size() || !covers(covered, kLengths[next])) return;
      const OdometryEstimate since = publishedOf(parameters, b.place, answer);
      ended.push_back({b.stamp, kLengths[next++], metres, since.pose, since.pose_covariance});
    };
    if (parameters.givesMetres()) end(way_ - b.way, true, b.metres);
    end(answer.current->stamp() - b.stamp, false, b.seconds);
  }
  const auto over = [](const Beginning& b) { return b.seconds == kLengths.size(); };
  begun_.erase(std::remove_if(begun_.begin(), begun_.end(), over), begun_.end());
  begin(answer);
  return ended;
}

void PartsOfTheWay::moveOn(const Parameters& parameters, const ProcessedFrame& answer) {
  ProcessedFrame copy = answer;
  for (Beginning& b : begun_) integrate(parameters, b.place, copy);
  if (!answer.place) return;
  const Eigen::Vector3d position = answer.place->camera().pose.translation();
  way_ += (position - position_.value_or(position)).norm();
  position_ = position;
}

void PartsOfTheWay::begin(const ProcessedFrame& answer) {
  const double now = answer.current->stamp();
  if (!begun_.empty() && !covers(now - begun_.back().stamp, kBetween)) return;
  begun_.push_back({now, way_, *answer.place});
  begun_.back().place.set(Eigen::Isometry3d::Identity(), Matrix6d::Zero());
}

}  // namespace gms_ransac
