#include "node/reconfigure.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include <dynamic_reconfigure/server.h>
#include <ros/node_handle.h>
#include <boost/thread/recursive_mutex.hpp>

#include "node/match_filter_config.h"
#include "parameters.h"
#include "throttle.h"

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

ProcessorOptions processorOptions(const MatchFilterConfig& config, int threads) {
  ProcessorOptions options;
  options.core = coreOptions(config);
  // The second thread runs beside the first, image after image; all others help one of the two in turn.
  options.core.extractor.threads = std::max(1, (threads + 1) / 2);
  options.core.matcher_threads = std::max(1, threads / 2);
  options.max_frame_gap = config.max_frame_gap;
  options.hold_reference = config.hold_reference;
  options.recovery = {config.recovery_frames, config.max_recovery_gap};
  options.sigma_floor = {config.translation_sigma_floor, config.rotation_sigma_floor};
  return options;
}

RuntimeOptions runtimeOptions(const MatchFilterConfig& config, int threads) {
  RuntimeOptions options;
  options.processor = processorOptions(config, threads);
  options.outputs.publish_rejected = config.publish_rejected;
  options.outputs.publish_relative_tf = config.publish_relative_tf;
  options.outputs.publish_odom_tf = config.publish_odom_tf;
  options.outputs.features = {{config.feature_limit, config.feature_distance}, config.feature_rate};
  return options;
}

}  // namespace

void UnclampedConfig::__clamp__() {
  problem.clear();
  renamed.clear();
  const ParameterValues values = valuesOf(*this);
  for (const auto& description : __getParamDescriptions__()) {
    const std::string& name = description->name;
    const Parameter& parameter = findParameter(name);
    const std::string given = toText(values.at(name));
    if (!parameter.accepts(values.at(name))) {
      if (!problem.empty()) problem += "; ";
      problem += "parameter " + refusal("~" + name, given, parameter.accepted());
      continue;
    }
    const std::string current = toText(*parameter.convert(values.at(name)));
    if (given == current) continue;
    renamed.push_back(renaming("~" + name, given, current));
    this->*static_cast<const ParamDescription<std::string>&>(*description).field = current;
  }
}

MatchFilterOptions coreOptions(const MatchFilterConfig& config) {
  const ParameterValues all = valuesOf(config);
  ParameterValues of_core;
  for (const Parameter& parameter : coreParameters()) of_core[parameter.name] = all.at(parameter.name);
  MatchFilterOptions options;
  setParameters(of_core, options);
  options.validate();
  return options;
}

struct Reconfigure::Server {
  Server(const ros::NodeHandle& handle, const std::string& log_name, int threads_of_node)
      : pnh(handle), name(log_name), threads(threads_of_node), server(mutex, handle) {}

  void change(UnclampedConfig& config) {
    for (const std::string& sentence : config.renamed) throttle.warnOnce(sentence, name + ": " + sentence);
    try {
      if (!config.problem.empty()) throw std::invalid_argument(config.problem);
      accept(runtimeOptions(config, threads));
    } catch (const std::exception& error) {
      ROS_ERROR_STREAM(name << ": change refused, the old parameters stay: " << error.what());
      config = in_force;
      return;
    }
    in_force = config;
  }

  const ros::NodeHandle pnh;
  const std::string name;
  const int threads;
  Throttle throttle;
  Accept accept;
  MatchFilterConfig in_force;  ///< what a refused change falls back to; guarded by the mutex
  boost::recursive_mutex mutex;
  dynamic_reconfigure::Server<UnclampedConfig> server;
};

Reconfigure::Reconfigure(const ros::NodeHandle& pnh, const std::string& name, int threads)
    : server_(std::make_unique<Server>(pnh, name, threads)) {}

Reconfigure::~Reconfigure() = default;

RuntimeOptions Reconfigure::startOptions() {
  // Refused here, with a sentence; dynamic_reconfigure would only log them.
  MatchFilterConfig config = MatchFilterConfig::__getDefault__();
  config.__fromServer__(server_->pnh);
  RuntimeOptions options = runtimeOptions(config, server_->threads);
  server_->in_force = config;
  return options;
}

void Reconfigure::serve(Accept accept) {
  server_->accept = std::move(accept);
  server_->server.setCallback(
      [server = server_.get()](UnclampedConfig& config, uint32_t /*level*/) { server->change(config); });
}

}  // namespace gms_ransac
