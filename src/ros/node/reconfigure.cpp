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

ProcessorOptions processorOptions(const Parameters& at_start, const MatchFilterConfig& config) {
  ProcessorOptions options;
  options.core = coreOptions(at_start.core, config);
  // Threads one and two work on different images; further ones help the first or the second alternately.
  const int threads = at_start.threads;
  options.core.extractor.threads = std::max(1, (threads + 1) / 2);
  options.core.matcher_threads = std::max(1, threads / 2);
  options.max_frame_gap = config.max_frame_gap;
  options.hold_reference = config.hold_reference;
  options.recovery = {config.recovery_frames, config.max_recovery_gap};
  options.sigma_floor = {config.translation_sigma_floor, config.rotation_sigma_floor};
  return options;
}

RuntimeOptions runtimeOptions(const Parameters& at_start, const MatchFilterConfig& config) {
  RuntimeOptions options;
  options.processor = processorOptions(at_start, config);
  options.outputs.publish_rejected = config.publish_rejected;
  options.outputs.publish_relative_tf = config.publish_relative_tf;
  options.outputs.publish_odom_tf = config.publish_odom_tf;
  binding::fromValue(config.overlay_colour, options.outputs.overlay.colour);
  binding::fromValue(config.overlay_layout, options.outputs.overlay.layout);
  options.outputs.features = {{config.feature_limit, config.feature_distance}, config.feature_rate};
  return options;
}

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

struct Reconfigure::Server {
  Server(const ros::NodeHandle& handle, const Parameters& parameters)
      : pnh(handle), at_start(parameters), server(mutex, handle) {}

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

  const ros::NodeHandle pnh;
  const Parameters at_start;
  Accept accept;
  MatchFilterConfig in_force;  ///< what a refused change falls back to; guarded by the mutex
  boost::recursive_mutex mutex;
  dynamic_reconfigure::Server<UnclampedConfig> server;
};

Reconfigure::Reconfigure(const ros::NodeHandle& pnh, const Parameters& at_start)
    : server_(std::make_unique<Server>(pnh, at_start)) {}

Reconfigure::~Reconfigure() = default;

RuntimeOptions Reconfigure::startOptions() {
  // Refused here, with a sentence; dynamic_reconfigure would only log them.
  MatchFilterConfig config = MatchFilterConfig::__getDefault__();
  config.__fromServer__(server_->pnh);
  RuntimeOptions options = runtimeOptions(server_->at_start, config);
  server_->in_force = config;
  return options;
}

void Reconfigure::serve(Accept accept) {
  server_->accept = std::move(accept);
  server_->server.setCallback(
      [server = server_.get()](UnclampedConfig& config, uint32_t /*level*/) { server->change(config); });
}

}  // namespace gms_ransac
