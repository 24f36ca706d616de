#include "node/read_parameters.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <stdexcept>

#include <XmlRpcValue.h>
#include <ros/node_handle.h>

#include "frames.h"
#include "gms_ransac/node_parameters.h"

namespace gms_ransac {

namespace {

std::string textOf(XmlRpc::XmlRpcValue raw) {
  if (raw.getType() == XmlRpc::XmlRpcValue::TypeString) return static_cast<std::string>(raw);
  std::ostringstream text;
  raw.write(text);
  return text.str();
}

std::string typeOf(const XmlRpc::XmlRpcValue& raw) {
  switch (raw.getType()) {
    case XmlRpc::XmlRpcValue::TypeBoolean:
      return "a yes or no";
    case XmlRpc::XmlRpcValue::TypeInt:
    case XmlRpc::XmlRpcValue::TypeDouble:
      return "a number";
    case XmlRpc::XmlRpcValue::TypeString:
      return "a text";
    case XmlRpc::XmlRpcValue::TypeArray:
      return "a list";
    default:
      return "a structure";
  }
}

[[noreturn]] void refuse(const ros::NodeHandle& pnh, const std::string& name, const std::string& value,
                         const std::string& accepted) {
  throw std::invalid_argument("parameter " + refusal(pnh.resolveName(name), value, accepted));
}

/// The value in the type of the parameter; empty if it is not allowed or ambiguous. YAML reads the words true and false
/// as booleans, which a choice has as words, and the number 4e-05 as a text.
std::optional<ParameterValue> valueOf(XmlRpc::XmlRpcValue raw, const Parameter& parameter) {
  switch (raw.getType()) {
    case XmlRpc::XmlRpcValue::TypeBoolean: {
      const ParameterValue flag = static_cast<bool>(raw);
      return parameter.convert(parameter.choices.empty() ? flag : toText(flag));
    }
    case XmlRpc::XmlRpcValue::TypeInt: {
      const int number = static_cast<int>(raw);
      const bool flag = std::holds_alternative<bool>(parameter.default_value) && (number == 0 || number == 1);
      return parameter.convert(flag ? ParameterValue(number == 1) : ParameterValue(number));
    }
    case XmlRpc::XmlRpcValue::TypeDouble:
      return parameter.convert(static_cast<double>(raw));
    case XmlRpc::XmlRpcValue::TypeString:
      return parameter.parse(static_cast<std::string>(raw));
    default:
      return std::nullopt;
  }
}

XmlRpc::XmlRpcValue toXmlRpc(const ParameterValue& value) {
  return std::visit([](const auto& typed) { return XmlRpc::XmlRpcValue(typed); }, value);
}

/// The values of all parameters of the table that are set.
ParameterValues read(const ros::NodeHandle& pnh, const ParameterTable& table) {
  ParameterValues values;
  for (const Parameter& parameter : table) {
    XmlRpc::XmlRpcValue raw;
    if (!pnh.getParam(parameter.name, raw)) continue;
    const std::optional<ParameterValue> value = valueOf(raw, parameter);
    if (!value) {
      const std::string type = typeOf(raw), wanted = typeOf(toXmlRpc(parameter.default_value));
      refuse(pnh, parameter.name, textOf(raw),
             parameter.accepted() + (type == wanted ? std::string() : ", and this is " + type));
    }
    // dynamic_reconfigure reads it as well, and would take the default for a value of another type.
    const XmlRpc::XmlRpcValue typed = toXmlRpc(*value);
    const bool whole = raw.getType() == XmlRpc::XmlRpcValue::TypeInt && std::holds_alternative<double>(*value);
    if (typed.getType() != raw.getType() && !whole) pnh.setParam(parameter.name, typed);
    values[parameter.name] = *value;
  }
  return values;
}

/// Null if no table has it.
const Parameter* find(const std::string& name) {
  const Parameter* found = findParameter(startParameters(), name);
  return found != nullptr ? found : findParameter(liveParameters(), name);
}

CameraIntrinsics cameraFrom(const ParameterValues& values, const ros::NodeHandle& pnh) {
  CameraIntrinsics camera;
  const bool given = values.count("camera/fx") > 0;
  const auto number = [&](const std::string& name) {
    const auto value = values.find("camera/" + name);
    return value == values.end() ? 0 : std::get<double>(value->second);
  };
  const std::map<std::string, double*> pinhole = {
      {"fx", &camera.fx}, {"fy", &camera.fy}, {"cx", &camera.cx}, {"cy", &camera.cy}};
  for (const auto& [name, field] : pinhole) {
    if ((values.count("camera/" + name) > 0) != given) {
      throw std::invalid_argument("parameters " + pnh.resolveName("camera") +
                                  "/fx, fy, cx and cy replace camera_info only together; camera/" +
                                  (given ? name : "fx") + " is missing");
    }
    *field = number(name);
  }
  if (!given) return CameraIntrinsics();
  const auto model = values.find("camera/distortion_model");
  if (model != values.end()) camera.distortion_model = std::get<std::string>(model->second);
  const std::map<std::string, std::vector<std::string>> coefficients = {
      {"plumb_bob", {"k1", "k2", "p1", "p2", "k3"}},
      {"equidistant", {"k1", "k2", "k3", "k4"}},
      {"omnidirectional", {"xi", "k1", "k2", "p1", "p2"}},
      {"double_sphere", {"xi", "alpha"}}};
  const std::string& lens = camera.distortion_model;
  for (const std::string& name : coefficients.at(lens.empty() ? "plumb_bob" : lens)) {
    camera.distortion.push_back(number(name));
  }
  try {
    camera.validate();
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument("parameters " + pnh.resolveName("camera") + ": " + error.what());
  }
  return camera;
}

}  // namespace

const ParameterTable& startParameters() { return ParameterFields<Parameters>::table(); }
const ParameterTable& liveParameters() { return ParameterFields<RuntimeOptions>::table(); }

template void setParameters(const ParameterValues&, Parameters&, const std::string&);
template ParameterValues parametersOf(const Parameters&);
template void setParameters(const ParameterValues&, RuntimeOptions&, const std::string&);
template ParameterValues parametersOf(const RuntimeOptions&);

Parameters readParameters(const ros::NodeHandle& pnh) {
  Parameters parameters;
  parameters.name = pnh.getNamespace();
  const ParameterValues values = read(pnh, startParameters());
  setParameters(values, parameters);
  parameters.camera = cameraFrom(values, pnh);
  parameters.odom_frame = withoutLeadingSlash(parameters.odom_frame);
  parameters.base_frame = withoutLeadingSlash(parameters.base_frame);
  parameters.imu_frame = withoutLeadingSlash(parameters.imu_frame);
  parameters.prior_frame = withoutLeadingSlash(parameters.prior_frame);
  if (parameters.rotation_prior == RotationPriorKind::kTf && parameters.prior_frame.empty()) {
    refuse(pnh, "prior_frame", "", "the fixed frame in which tf knows the camera, with ~rotation_prior tf");
  }
  if (parameters.scale == ScaleMode::kGround && parameters.camera_height == 0) {
    refuse(pnh, "camera_height", "0", "the camera's height above the ground in metres, with ~scale ground");
  }
  const bool pair = parameters.input == InputKind::kPair;
  const bool stereo = parameters.input == InputKind::kStereo;
  if (parameters.camera_info_sync == CameraInfoSync::kExact &&
      (parameters.scale == ScaleMode::kDepth || pair || stereo)) {
    refuse(pnh, "camera_info_sync", "exact", "'latest' with ~scale depth, ~input pair or ~input stereo");
  }
  const auto refuse_scale = [&](const char* accepted) {
    refuse(pnh, "scale", pnh.param<std::string>("scale", ""), accepted);
  };
  if (stereo && parameters.scale != ScaleMode::kUnit) {
    refuse_scale("unit, the default, with ~input stereo, which measures metres itself");
  }
  if (stereo && parameters.camera.calibrated()) {
    throw std::invalid_argument("parameters " + pnh.resolveName("camera") +
                                " describe one camera; with ~input stereo both are described by their camera_info");
  }
  if (pair && parameters.scale != ScaleMode::kUnit && parameters.scale != ScaleMode::kFixed) {
    refuse_scale("unit or fixed with ~input pair");
  }
  return parameters;
}

RuntimeOptions readRuntimeOptions(const ros::NodeHandle& pnh, const Parameters& at_start) {
  RuntimeOptions options;
  setParameters(read(pnh, liveParameters()), options);
  MatchFilterOptions& core = options.processor.core;
  // Threads one and two work on different images; further ones help the first or the second alternately.
  core.extractor.threads = std::max(1, (at_start.threads + 1) / 2);
  core.matcher_threads = std::max(1, at_start.threads / 2);
  core.validate();
  return options;
}

std::string settingsText(const ros::NodeHandle& pnh) {
  std::string always, others;
  const auto add = [&](const ParameterTable& table) {
    for (const Parameter& parameter : table) {
      const bool decides = parameter.name == "input" || parameter.name == "scale" || parameter.name == "method";
      XmlRpc::XmlRpcValue raw;
      std::optional<ParameterValue> value;
      if (pnh.getParam(parameter.name, raw)) value = valueOf(raw, parameter);
      if (value) value = parameter.convert(*value);
      const bool as_usual = !value || *value == parameter.default_value;
      if (as_usual && !decides) continue;
      (decides ? always : others) += ", ~" + parameter.name + " " + toText(value.value_or(parameter.default_value));
    }
  };
  add(startParameters());
  add(liveParameters());
  return (always + others).substr(2);
}

std::vector<std::string> parametersWithoutEffect(const ros::NodeHandle& pnh, const Parameters& parameters) {
  const bool ground = parameters.scale == ScaleMode::kGround,
             imu = parameters.rotation_prior == RotationPriorKind::kImu;
  const bool images = parameters.input != InputKind::kKeypoints;
  const struct {
    const char* name;
    bool used;
    const char* use;
  } conditions[] = {
      {"camera_height", ground, "~scale ground"},
      {"fixed_scale", parameters.scale == ScaleMode::kFixed, "~scale fixed"},
      {"depth_image_transport", parameters.scale == ScaleMode::kDepth, "~scale depth"},
      {"image_transport", images, "images (~input is keypoints)"},
      {"features", images, "images (~input is keypoints)"},
      {"fast_threshold", images, "images (~input is keypoints)"},
      {"extractor", images, "images (~input is keypoints)"},
      {"pyramid_levels", images, "images (~input is keypoints)"},
      {"pyramid_scale", images, "images (~input is keypoints)"},
      {"feature_layout", images, "images (~input is keypoints)"},
      {"imu_frame", imu, "~rotation_prior imu"},
      {"prior_frame", parameters.rotation_prior == RotationPriorKind::kTf, "~rotation_prior tf"},
      {"image_time_offset", parameters.usesSensors() && !(ground && !imu), "~rotation_prior or ~scale odometry"},
      {"stereo_features_type", parameters.input == InputKind::kStereo, "~input stereo"}};
  std::vector<std::string> all, sentences;
  pnh.getParamNames(all);
  const std::string prefix = pnh.getNamespace() + "/";
  for (const std::string& full : all) {
    if (full.compare(0, prefix.size(), prefix) != 0) continue;
    const std::string name = full.substr(prefix.size());
    // Image transports keep parameters of their own: those of the overlay below its name, the others below theirs.
    const std::string folder = name.substr(0, name.find('/') + 1);
    if (folder == "match_image/" || folder == parameters.image_transport + "/" ||
        folder == parameters.depth_image_transport + "/") {
      continue;
    }
    const Parameter* row = find(name);
    if (!row) {
      sentences.push_back(full + " is set, but this node has no such parameter; check the spelling");
      continue;
    }
    const auto condition =
        std::find_if(std::begin(conditions), std::end(conditions), [&](const auto& each) { return each.name == name; });
    XmlRpc::XmlRpcValue raw;
    if (condition == std::end(conditions) || condition->used || !pnh.getParam(name, raw)) continue;
    if (valueOf(raw, *row) == row->default_value) continue;  // a copy of match_filter.yaml sets them all
    sentences.push_back(full + " is set, but has no effect without " + condition->use);
  }
  return sentences;
}

}  // namespace gms_ransac
