#include "parameters.h"

#include <algorithm>
#include <map>
#include <sstream>
#include <stdexcept>

#include <XmlRpcValue.h>

#include "former_names.h"
#include "frames.h"

namespace gms_ransac {

namespace {

// Every parameter that is fixed at start; the one list that `unknownParameters` knows besides cfg/MatchFilter.cfg.
// clang-format off
const std::vector<std::string> kStaticNames = {
    "depth_image_transport", "mask_file", "mask_sync",
    "camera_info_sync", "input_is_rectified", "image_transport", "drop_frames", "queue_size", "always_subscribe",
    "threads", "diagnostic_period", "input", "feature_layout", "scale", "fixed_scale", "odom_frame", "base_frame", "invert_odom_tf",
    "camera/fx", "camera/fy", "camera/cx", "camera/cy", "camera/k1", "camera/k2", "camera/p1", "camera/p2",
    "camera/k3", "camera/k4", "camera/distortion_model"};
// clang-format on

std::string toText(XmlRpc::XmlRpcValue value) {
  if (value.getType() == XmlRpc::XmlRpcValue::TypeString) return static_cast<std::string>(value);
  std::ostringstream text;
  value.write(text);
  return text.str();
}

std::string refusal(const std::string& name, const std::string& value, const std::string& accepted) {
  return "parameter " + name + " is '" + value + "'; it must be " + accepted;
}

[[noreturn]] void refuse(const ros::NodeHandle& pnh, const std::string& name, const std::string& value,
                         const std::string& accepted) {
  throw std::invalid_argument(refusal(pnh.resolveName(name), value, accepted));
}

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

bool contains(const std::vector<std::string>& words, const std::string& word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

std::string oneOf(const std::vector<std::string>& choices) {
  std::string text = "one of";
  for (const std::string& choice : choices) text += " '" + choice + "'";
  return text;
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

/// One reconfigurable number and what it may be.
struct Range {
  bool whole;
  double low, high;

  bool holds(double value) const { return value >= low && value <= high; }  // not of NaN
  std::string text() const {
    std::ostringstream out;
    out << (whole ? "a whole number" : "a number") << " between ";
    // At six digits 2147483647 would be another number.
    whole ? out << static_cast<int>(low) << " and " << static_cast<int>(high) : out << low << " and " << high;
    return out.str();
  }
};

using Description = MatchFilterConfig::AbstractParamDescription;

double numberIn(const Description& description, const MatchFilterConfig& config) {
  boost::any value;
  description.getValue(config, value);
  return description.type == "int" ? boost::any_cast<int>(value) : boost::any_cast<double>(value);
}

bool isNumber(const Description& description) { return description.type == "int" || description.type == "double"; }

/// The words that cfg/MatchFilter.cfg offers; it keeps them in the text from which rqt_reconfigure makes its menu.
std::vector<std::string> choicesOf(const Description& description) {
  std::vector<std::string> words;
  const std::string key = "'value': '";
  const std::string& menu = description.edit_method;
  for (size_t at = menu.find(key); at != std::string::npos; at = menu.find(key, at)) {
    at += key.size();
    words.push_back(menu.substr(at, menu.find('\'', at) - at));
  }
  return words;
}

Range rangeOf(const Description& description) {
  return {description.type == "int", numberIn(description, MatchFilterConfig::__getMin__()),
          numberIn(description, MatchFilterConfig::__getMax__())};
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
  gms_ransac::read(pnh, "mask_file", "the path of an image", parameters.mask_file);
  parameters.mask_sync =
      readChoice(pnh, "mask_sync", "latest", {"latest", "exact"}) == "exact" ? MaskSync::kExact : MaskSync::kLatest;
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

void checkConfigOnServer(const ros::NodeHandle& pnh) {
  for (const auto& description : MatchFilterConfig::__getParamDescriptions__()) {
    XmlRpc::XmlRpcValue raw;
    if (!pnh.getParam(description->name, raw)) continue;
    if (isNumber(*description)) {
      const Range range = rangeOf(*description);
      const bool is_int = raw.getType() == XmlRpc::XmlRpcValue::TypeInt;
      const bool fits = is_int || (raw.getType() == XmlRpc::XmlRpcValue::TypeDouble && !range.whole);
      if (!fits || !range.holds(is_int ? static_cast<int>(raw) : static_cast<double>(raw))) {
        refuse(pnh, description->name, toText(raw), range.text());
      }
    } else if (description->type == "bool" && raw.getType() != XmlRpc::XmlRpcValue::TypeBoolean) {
      refuse(pnh, description->name, toText(raw), "true or false");
    } else if (description->type == "str") {
      const std::vector<std::string> choices = choicesOf(*description);
      if (raw.getType() != XmlRpc::XmlRpcValue::TypeString || !contains(choices, toText(raw))) {
        refuse(pnh, description->name, toText(raw), oneOf(choices));
      }
    }
  }
}

void UnclampedConfig::__clamp__() {
  problem.clear();
  renamed = replaceFormerNames(*this);
  for (const auto& description : __getParamDescriptions__()) {
    std::ostringstream asked;
    std::string accepted;
    if (isNumber(*description)) {
      const Range range = rangeOf(*description);
      const double value = numberIn(*description, *this);
      if (range.holds(value)) continue;
      range.whole ? asked << static_cast<int>(value) : asked << value;
      accepted = range.text();
    } else if (description->type == "str") {
      boost::any value;
      description->getValue(*this, value);
      asked << boost::any_cast<std::string>(value);
      const std::vector<std::string> choices = choicesOf(*description);
      if (contains(choices, asked.str())) continue;
      accepted = oneOf(choices);
    } else {
      continue;
    }
    if (!problem.empty()) problem += "; ";
    problem += refusal("~" + description->name, asked.str(), accepted);
  }
}

MatchFilterOptions coreOptions(const MatchFilterConfig& config) {
  MatchFilterOptions options;
  options.method = config.method;
  options.extractor.extractor = config.extractor;
  options.extractor.features = config.features;
  options.extractor.levels = config.pyramid_levels;
  options.extractor.scale_factor = config.pyramid_scale;
  options.extractor.fast_threshold = config.fast_threshold;
  options.motion_statistics.acceptance = parseAcceptance(config.gms_acceptance);
  options.motion_statistics.grid_columns = config.gms_grid_columns;
  options.motion_statistics.grid_rows = config.gms_grid_rows;
  options.motion_statistics.threshold_factor = config.gms_threshold_factor;
  options.motion_statistics.rotation = config.gms_rotation;
  options.motion_statistics.scale = config.gms_scale;
  if (config.gms_border != "opencv" && config.gms_border != "original") {
    throw std::invalid_argument("gms_border is '" + config.gms_border + "'; it must be 'opencv' or 'original'");
  }
  options.motion_statistics.border = config.gms_border == "opencv" ? GridBorder::kOpenCV : GridBorder::kOriginal;
  options.distance_reading = parseDistanceReading(config.distance_reading);
  options.one_to_one = config.one_to_one;
  options.lan_mutual = config.lan_mutual;
  options.second_alpha = config.lan_second_alpha;
  options.robust.model = parseModelType(config.model);
  options.robust.threshold_px = config.threshold_px;
  options.robust.confidence = config.confidence;
  options.robust.max_iterations = config.max_iterations;
  options.robust.seed = static_cast<uint64_t>(config.seed);
  options.robust.ratio = config.ratio;
  options.robust.geometric_groups = config.geometric_groups;
  options.robust.tdd_d = config.tdd_d;
  options.robust.subset_count = config.subset_count;
  options.robust.subset_fraction = config.subset_fraction;
  options.robust.split = config.split;
  options.robust.target_ratio = config.target_ratio;
  options.robust.quality = config.quality;
  options.robust.judge = config.judge;
  options.robust.refine = config.refine;
  options.validate();
  return options;
}

std::vector<std::string> unknownParameters(const ros::NodeHandle& pnh, const Parameters& parameters) {
  std::vector<std::string> all, unknown;
  pnh.getParamNames(all);
  const std::string prefix = pnh.getNamespace() + "/";
  for (const std::string& full : all) {
    if (full.compare(0, prefix.size(), prefix) != 0) continue;
    const std::string name = full.substr(prefix.size());
    if (std::find(kStaticNames.begin(), kStaticNames.end(), name) != kStaticNames.end()) continue;
    const auto& dynamic = MatchFilterConfig::__getParamDescriptions__();
    if (std::any_of(dynamic.begin(), dynamic.end(), [&](const auto& d) { return d->name == name; })) continue;
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
