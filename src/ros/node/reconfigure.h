// The node's parameters that can change at run time (listed in cfg/MatchFilter.cfg), by dynamic_reconfigure.
#pragma once

#include <functional>
#include <memory>

#include "output/output_options.h"
#include "stream/frame_processor.h"

namespace ros {
class NodeHandle;
}

namespace gms_ransac {

struct Parameters;

/// Values of the parameters in cfg/MatchFilter.cfg.
struct RuntimeOptions {
  ProcessorOptions processor;
  OutputOptions outputs;
};

/// The values on the parameter server; throws std::invalid_argument when they contradict each other.
RuntimeOptions startOptions(const ros::NodeHandle& pnh, const Parameters& at_start);

/// Serves changes until the result is destroyed. `accept` is called with the values at start and with every change;
/// what it throws refuses the change: as a whole, with a sentence, and the parameters in force are given back. Deadlock
/// ahead: the server holds its mutex while it calls back, so nothing may wait for it with another held.
std::shared_ptr<void> serveChanges(const ros::NodeHandle& pnh, const Parameters& at_start,
                                   std::function<void(const RuntimeOptions&)> accept);

}  // namespace gms_ransac
