#include "parameters.h"

#include <map>
#include <stdexcept>

#include <XmlRpcValue.h>
#include <ros/node_handle.h>

#include "frames.h"
#include "reconfigure.h"
#include "refusal.h"

namespace gms_ransac {

namespace {

// Every parameter that is fixed at start; the one list that `unknownParameters` knows besides cfg/MatchFilter.cfg.
// clang-format off
const std::vector<std::string> kStaticNames = {
    "depth_image_transport",
    "camera_info_sync", "input_is_rectified", "image_transport", "drop_frames", "queue_size", "always_subscribe",
    "threads", "diagnostic_period", "input", "feature_layout", "scale", "fixed_scale", "odom_frame", "base_frame", "invert_odom_tf",
    "camera/fx", "camera/fy", "camera/cx", "camera/cy", "camera/k1", "camera/k2", "camera/p1", "camera/p2",
    "camera/k3", "camera/k4", "camera/distortion_model"};
// clang-format on

/// Reads `name` into `value` if it is set; refuses another type instead of ignoring it as NodeHandle::param does.
template <typename T>
void read(const ros::NodeHandle& pnh, const std::string& name, const char* type, T& value) {
  XmlRpc::XmlRpcValue raw;
  if (!pnh.getParam(name, raw)) return;
  if (!pnh.getParam(name, value)) refuse(pnh, name, toText(raw), type);
}

int readInt(const ros::NodeHandle& pnh, const std::string& name, int value, int low, int high) {
  const std::string accepted = "a whole number between " + std::to_string(low) + " and " + std::to_string(high);
  XmlRpc::XmlRpcValue raw;
  // roscpp would round a fraction.
  if (pnh.getParam(name, raw) && raw.getType() != XmlRpc::XmlRpcValue::TypeInt)
    refuse(pnh, name, toText(raw), accepted);
  read(pnh, name, accepted.c_str(), value);
  if (value < low || value > high) refuse(pnh, name, std::to_string(value), accepted);
  return value;
}

/// One of `choices`; YAML turns the words true and false into booleans, so those are taken as words too.
std::string readChoice(const ros::NodeHandle& pnh, const std::string& name, const std::string& fallback,
                       const std::vector<std::string>& choices) {
  XmlRpc::XmlRpcValue raw;
  if (!pnh.getParam(name, raw)) return fallback;
  std::string word = toText(raw);
  if (raw.getType() == XmlRpc::XmlRpcValue::TypeBoolean) word = static_cast<bool>(raw) ? "true" : "false";
  if (contains(choices, word)) return word;
  refuse(pnh, name, word, oneOf(choices));
}

CameraIntrinsics readCamera(const ros::NodeHandle& pnh) {
  CameraIntrinsics camera;
  const bool given = pnh.hasParam("camera/fx");
  const std::map<std::string, double*> focal = {
      {"camera/fx", &camera.fx}, {"camera/fy", &camera.fy}, {"camera/cx", &camera.cx}, {"camera/cy", &camera.cy}};
  for (const auto& [name, value] : focal) {
    if (pnh.hasParam(name) != given) {
      throw std::invalid_argument("parameters " + pnh.resolveName("camera") +
                                  "/fx, fy, cx and cy replace camera_info only together; " +
                                  (given ? name + " is missing" : "camera/fx is missing"));
    }
    read(pnh, name, "a number of pixels", *value);
  }
  read(pnh, "camera/distortion_model", "a word", camera.distortion_model);
  const bool fisheye = camera.distortion_model == "equidistant";
  const std::vector<std::string> order = fisheye ? std::vector<std::string>{"k1", "k2", "k3", "k4"}
                                                 : std::vector<std::string>{"k1", "k2", "p1", "p2", "k3"};
  for (const std::string& coefficient : order) {
    double value = 0;
    read(pnh, "camera/" + coefficient, "a number", value);
    camera.distortion.push_back(value);
  }
  if (!given) return CameraIntrinsics();
  if (camera.fx <= 0 || camera.fy <= 0) refuse(pnh, "camera/fx", std::to_string(camera.fx), "above 0, and so must fy");
  try {
    camera.validate();
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument("parameters " + pnh.resolveName("camera") + ": " + error.what());
  }
  return camera;
}

}  // namespace

Parameters Parameters::read(const ros::NodeHandle& pnh) {
  Parameters parameters;
  parameters.camera_info_sync = readChoice(pnh, "camera_info_sync", "latest", {"latest", "exact"}) == "exact"
                                    ? CameraInfoSync::kExact
                                    : CameraInfoSync::kLatest;
  const std::string rectified = readChoice(pnh, "input_is_rectified", "auto", {"auto", "true", "false"});
  parameters.input_is_rectified =
      rectified == "auto" ? Rectified::kAuto : (rectified == "true" ? Rectified::kYes : Rectified::kNo);
  parameters.camera = readCamera(pnh);
  gms_ransac::read(pnh, "image_transport", "the name of an image transport", parameters.image_transport);
  gms_ransac::read(pnh, "depth_image_transport", "the name of an image transport", parameters.depth_image_transport);
  gms_ransac::read(pnh, "diagnostic_period", "a number of seconds above 0", parameters.diagnostic_period);
  if (!(parameters.diagnostic_period > 0)) {
    refuse(pnh, "diagnostic_period", std::to_string(parameters.diagnostic_period), "a number of seconds above 0");
  }
  gms_ransac::read(pnh, "drop_frames", "true or false", parameters.drop_frames);
  gms_ransac::read(pnh, "always_subscribe", "true or false", parameters.always_subscribe);
  parameters.queue_size = readInt(pnh, "queue_size", parameters.queue_size, 1, 10000);
  parameters.input =
      readChoice(pnh, "input", "stream", {"stream", "pair"}) == "pair" ? InputKind::kPair : InputKind::kStream;
  parameters.scale = parseScaleMode(readChoice(pnh, "scale", "unit", {"unit", "propagate", "depth", "fixed"}));
  parameters.feature_layout =
      readChoice(pnh, "feature_layout", "vins_mono", {"vins_mono", "vins_fusion"}) == "vins_mono"
          ? FeatureLayout::kVinsMono
          : FeatureLayout::kVinsFusion;
  if (parameters.camera_info_sync == CameraInfoSync::kExact &&
      (parameters.scale == ScaleMode::kDepth || parameters.input == InputKind::kPair)) {
    refuse(pnh, "camera_info_sync", "exact", "'latest' with ~scale depth or ~input pair, whose stamps differ");
  }
  if (parameters.input == InputKind::kPair && parameters.scale != ScaleMode::kUnit &&
      parameters.scale != ScaleMode::kFixed) {
    refuse(pnh, "scale", "propagate or depth", "unit or fixed with ~input pair");
  }
  gms_ransac::read(pnh, "fixed_scale", "a number of metres", parameters.fixed_scale);
  if (!(parameters.fixed_scale >= 1e-6 && parameters.fixed_scale <= 1e6)) {
    refuse(pnh, "fixed_scale", std::to_string(parameters.fixed_scale), "between 1e-06 and 1e+06 metres");
  }
  gms_ransac::read(pnh, "odom_frame", "a frame", parameters.odom_frame);
  gms_ransac::read(pnh, "base_frame", "a frame", parameters.base_frame);
  parameters.odom_frame = withoutLeadingSlash(parameters.odom_frame);
  parameters.base_frame = withoutLeadingSlash(parameters.base_frame);
  gms_ransac::read(pnh, "invert_odom_tf", "true or false", parameters.invert_odom_tf);
  parameters.threads = readInt(pnh, "threads", parameters.threads, 1, 16);
  return parameters;
}

std::vector<std::string> unknownParameters(const ros::NodeHandle& pnh, const Parameters& parameters) {
  std::vector<std::string> all, unknown;
  pnh.getParamNames(all);
  const std::vector<std::string> reconfigurable = reconfigurableNames();
  const std::string prefix = pnh.getNamespace() + "/";
  for (const std::string& full : all) {
    if (full.compare(0, prefix.size(), prefix) != 0) continue;
    const std::string name = full.substr(prefix.size());
    if (contains(kStaticNames, name) || contains(reconfigurable, name)) continue;
    // Image transports keep parameters of their own: those of the overlay below its name, the others below theirs.
    const std::string folder = name.substr(0, name.find('/') + 1);
    if (folder == "match_image/" || folder == parameters.image_transport + "/" ||
        folder == parameters.depth_image_transport + "/") {
      continue;
    }
    unknown.push_back(name);
  }
  return unknown;
}

}  // namespace gms_ransac
