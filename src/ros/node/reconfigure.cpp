#include "node/reconfigure.h"

#include <utility>

#include <dynamic_reconfigure/server.h>
#include <gms_ransac/MatchFilterConfig.h>
#include <ros/node_handle.h>
#include <boost/thread/recursive_mutex.hpp>

namespace gms_ransac {

namespace {

/// dynamic_reconfigure clamps numbers silently; here they stay, and are refused.
struct UnclampedConfig : MatchFilterConfig {
  UnclampedConfig() = default;
  UnclampedConfig(const MatchFilterConfig& config) : MatchFilterConfig(config) {}  // implicit: the server converts so
  /// Hides the generated one; the server calls it with every request.
  void __clamp__() {}

  /// Hides the generated one, which writes every parameter, each in a call of the master, with every request.
  void __toServer__(const ros::NodeHandle& nh) {
    ParameterValues now = values();
    for (const auto& description : __getParamDescriptions__()) {
      const auto written = on_server.find(description->name);
      if (written == on_server.end() || written->second != now.at(description->name)) description->toServer(nh, *this);
    }
    on_server = std::move(now);
  }

  ParameterValues values() const {
    dynamic_reconfigure::Config message;
    __toMessage__(message);
    return valuesOf(message);
  }

  ParameterValues on_server;  ///< what was written last; empty: nothing yet
};

/// " ~features 2000 -> 500, ~model ..."; empty: none.
std::string differences(const ParameterValues& before, const ParameterValues& after) {
  std::string text;
  for (const auto& [name, value] : after) {
    const ParameterValue& old_value = before.at(name);
    if (value == old_value) continue;
    text += (text.empty() ? " ~" : ", ~") + name + " " + toText(old_value) + " -> " + toText(value);
  }
  return text;
}

struct ChangeServer {
  ChangeServer(const ros::NodeHandle& pnh, std::string node, RuntimeOptions at_start,
               std::function<void(const RuntimeOptions&)> accepts)
      : name(std::move(node)), start(std::move(at_start)), accept(std::move(accepts)), server(mutex, pnh) {
    in_force.__fromServer__(pnh);
    server.setCallback([this](UnclampedConfig& config, uint32_t /*level*/) { change(config); });
  }

  void change(UnclampedConfig& config) {
    try {
      RuntimeOptions options = start;
      setParameters(config.values(), options, "parameter ~");
      accept(options);
    } catch (const std::exception& error) {
      ROS_ERROR_STREAM(name << ": change refused, the old parameters stay: " << error.what());
      config = in_force;
      return;
    }
    const std::string changes = differences(in_force.values(), config.values());
    if (!changes.empty()) ROS_INFO_STREAM(name << ": changed" << changes);
    in_force = config;
  }

  const std::string name;
  const RuntimeOptions start;
  const std::function<void(const RuntimeOptions&)> accept;
  UnclampedConfig in_force = MatchFilterConfig::__getDefault__();  ///< guarded by the mutex
  boost::recursive_mutex mutex;
  dynamic_reconfigure::Server<UnclampedConfig> server;
};

}  // namespace

ParameterValues valuesOf(const dynamic_reconfigure::Config& message) {
  ParameterValues values;
  for (const auto& each : message.bools) values[each.name] = each.value != 0;
  for (const auto& each : message.ints) values[each.name] = each.value;
  for (const auto& each : message.doubles) values[each.name] = each.value;
  for (const auto& each : message.strs) values[each.name] = each.value;
  return values;
}

std::shared_ptr<void> serveChanges(const ros::NodeHandle& pnh, const std::string& name, const RuntimeOptions& start,
                                   std::function<void(const RuntimeOptions&)> accept) {
  return std::make_shared<ChangeServer>(pnh, name, start, std::move(accept));
}

}  // namespace gms_ransac
