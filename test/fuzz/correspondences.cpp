// Correspondences messages from anywhere into CorrespondencesView: it takes them or throws std::invalid_argument.
#include "gms_ransac/correspondences_view.h"

#include <stdexcept>

#include <gms_ransac/Correspondences.h>
#include <sensor_msgs/CameraInfo.h>

#include "fuzz_input.h"

namespace gms_ransac {
namespace {

template <typename Column>
void fill(FuzzInput& input, size_t n, Column& column) {
  column.resize(input.byte() > 250 ? input.byte() : n);
  for (auto& value : column) value = static_cast<typename Column::value_type>(input.byte());
}

Correspondences fuzzedMessage(FuzzInput& input) {
  Correspondences message;
  const size_t n = input.byte();
  for (auto* column : {&message.reference_points, &message.current_points}) {
    fill(input, 2 * n, *column);
    for (float& value : *column) value *= input.byte() > 250 ? input.number32(-1, 1) : 1;
  }
  for (auto* column : {&message.confidence, &message.probability, &message.reference_sigma, &message.current_sigma}) {
    fill(input, n, *column);
  }
  fill(input, n, message.distance);
  fill(input, n, message.track_id);
  fill(input, n, message.track_length);
  if (input.flag()) fill(input, n, message.stage);
  for (double& value : message.K) value = input.number(0, 500);
  message.pixel_space = input.byte();
  message.current_in_reference.pose.orientation.w = input.number(0, 1);
  message.current_in_reference.pose.orientation.z = input.number(0, 1);
  return message;
}

}  // namespace

void check(FuzzInput input) {
  const Correspondences message = fuzzedMessage(input);
  try {
    const CorrespondencesView<Correspondences> view(message);
    for (int i = 0; i < view.size(); ++i) view.isInlier(i);
    demand(view.referencePoints().rows == view.size() && view.currentPoints().rows == view.size(), "one row a match");
    demand(view.reference().cols() == view.size() && view.probability().size() == view.size(), "one column a match");
    demand(view.referencePoints().data == reinterpret_cast<const uint8_t*>(message.reference_points.data()), "no copy");
    view.currentInReference();
    sensor_msgs::CameraInfo info;
    for (int n = input.between(0, 15); n > 0; --n) info.D.push_back(input.number(-1, 1));
    info.distortion_model = input.flag() ? "equidistant" : "plumb_bob";
    const cv::Mat rays = view.normalized(view.currentPoints(), info);
    demand(rays.rows == view.size(), "one ray a match");
  } catch (const std::invalid_argument& error) {
    demand(std::string(error.what()).find("Correspondences: ") == 0, "a refusal is a sentence");
  }
}

}  // namespace gms_ransac
