// Changes of the node's parameters at run time (those in cfg/MatchFilter.cfg), by dynamic_reconfigure.
#pragma once

#include <functional>
#include <memory>

#include <dynamic_reconfigure/Config.h>

#include "node/read_parameters.h"

namespace gms_ransac {

ParameterValues valuesOf(const dynamic_reconfigure::Config& message);

/// Serves changes of `start` until the result is destroyed. `accept` is called with the values at start and with every
/// change; what it throws refuses the change: as a whole, with a sentence, and the parameters in force are given back.
/// Deadlock ahead: the server holds its mutex while it calls back, so nothing may wait for it with another held.
/// `name`: of the node, for the log.
std::shared_ptr<void> serveChanges(const ros::NodeHandle& pnh, const std::string& name, const RuntimeOptions& start,
                                   std::function<void(const RuntimeOptions&)> accept);

}  // namespace gms_ransac
