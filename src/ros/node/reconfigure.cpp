#include "node/reconfigure.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include <dynamic_reconfigure/server.h>
#include <ros/node_handle.h>
#include <boost/thread/recursive_mutex.hpp>

#include "gms_ransac/node_parameters.h"
#include "node/match_filter_config.h"
#include "parameter.h"
#include "parameters.h"

namespace gms_ransac {

namespace {

/// Every parameter by name, as the table has it.
ParameterValues valuesOf(const MatchFilterConfig& config) {
  ParameterValues values;
  for (const auto& description : MatchFilterConfig::__getParamDescriptions__()) {
    boost::any value;
    description->getValue(config, value);
    ParameterValue& typed = values[description->name];
    if (const auto* whole = boost::any_cast<int>(&value)) typed = *whole;
    if (const auto* number = boost::any_cast<double>(&value)) typed = *number;
    if (const auto* flag = boost::any_cast<bool>(&value)) typed = *flag;
    if (const auto* word = boost::any_cast<std::string>(&value)) typed = *word;
  }
  return values;
}

/// " ~features 2000 -> 500, ~model ..."; empty: none.
std::string differences(const MatchFilterConfig& before, const MatchFilterConfig& after) {
  const ParameterValues old_values = valuesOf(before);
  std::string text;
  for (const auto& [name, value] : valuesOf(after)) {
    const ParameterValue& old_value = old_values.at(name);
    if (value == old_value) continue;
    text += (text.empty() ? " ~" : ", ~") + name + " " + toText(old_value) + " -> " + toText(value);
  }
  return text;
}

RuntimeOptions runtimeOptions(const Parameters& at_start, const MatchFilterConfig& config) {
  RuntimeOptions options;
  ProcessorOptions& processor = options.processor;
  processor.core = coreOptions(at_start.core, config);
  // Threads one and two work on different images; further ones help the first or the second alternately.
  const int threads = at_start.threads;
  processor.core.extractor.threads = std::max(1, (threads + 1) / 2);
  processor.core.matcher_threads = std::max(1, threads / 2);
  processor.max_frame_gap = config.max_frame_gap;
  processor.hold_reference = config.hold_reference;
  processor.recovery = {config.recovery_frames, config.max_recovery_gap};
  processor.sigma_floor = {config.translation_sigma_floor, config.rotation_sigma_floor};
  options.outputs.publish_rejected = config.publish_rejected;
  options.outputs.publish_relative_tf = config.publish_relative_tf;
  options.outputs.publish_odom_tf = config.publish_odom_tf;
  binding::fromValue(config.overlay_colour, options.outputs.overlay.colour);
  binding::fromValue(config.overlay_layout, options.outputs.overlay.layout);
  options.outputs.features = {{config.feature_limit, config.feature_distance}, config.feature_rate};
  return options;
}

MatchFilterConfig configOf(const ros::NodeHandle& pnh) {
  MatchFilterConfig config = MatchFilterConfig::__getDefault__();
  config.__fromServer__(pnh);
  return config;
}

struct ChangeServer {
  ChangeServer(const ros::NodeHandle& pnh, const Parameters& parameters,
               std::function<void(const RuntimeOptions&)> accepts)
      : at_start(parameters), accept(std::move(accepts)), in_force(configOf(pnh)), server(mutex, pnh) {
    server.setCallback([this](UnclampedConfig& config, uint32_t /*level*/) { change(config); });
  }

  void change(UnclampedConfig& config) {
    try {
      if (!config.problem.empty()) throw std::invalid_argument(config.problem);
      accept(runtimeOptions(at_start, config));
    } catch (const std::exception& error) {
      ROS_ERROR_STREAM(at_start.name << ": change refused, the old parameters stay: " << error.what());
      config = in_force;
      return;
    }
    const std::string changes = differences(in_force, config);
    if (!changes.empty()) ROS_INFO_STREAM(at_start.name << ": changed" << changes);
    in_force = config;
  }

  const Parameters at_start;
  const std::function<void(const RuntimeOptions&)> accept;
  MatchFilterConfig in_force;  ///< what a refused change falls back to; guarded by the mutex
  boost::recursive_mutex mutex;
  dynamic_reconfigure::Server<UnclampedConfig> server;
};

}  // namespace

void UnclampedConfig::__clamp__() {
  problem.clear();
  const ParameterValues values = valuesOf(*this);
  for (const auto& description : __getParamDescriptions__()) {
    const std::string& name = description->name;
    const Parameter& parameter = findParameter(name);
    if (parameter.accepts(values.at(name))) continue;
    if (!problem.empty()) problem += "; ";
    problem += "parameter " + refusal("~" + name, toText(values.at(name)), parameter.accepted());
  }
}

MatchFilterOptions coreOptions(const ParameterValues& at_start, const MatchFilterConfig& config) {
  const ParameterValues live = valuesOf(config);
  ParameterValues of_core = at_start;
  for (const Parameter& parameter : coreParameters()) {
    const auto value = live.find(parameter.name);
    if (value != live.end()) of_core[parameter.name] = value->second;
  }
  MatchFilterOptions options;
  setParameters(of_core, options);
  options.validate();
  return options;
}

RuntimeOptions startOptions(const ros::NodeHandle& pnh, const Parameters& at_start) {
  // Refused here, with a sentence; dynamic_reconfigure would only log them.
  return runtimeOptions(at_start, configOf(pnh));
}

std::shared_ptr<void> serveChanges(const ros::NodeHandle& pnh, const Parameters& at_start,
                                   std::function<void(const RuntimeOptions&)> accept) {
  return std::make_shared<ChangeServer>(pnh, at_start, std::move(accept));
}

}  // namespace gms_ransac
