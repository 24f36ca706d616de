// The node's parameters that can change at run time (listed in cfg/MatchFilter.cfg), by dynamic_reconfigure.
#pragma once

#include <functional>
#include <memory>
#include <string>

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

class Reconfigure {
 public:
  /// Called with the values at start and with every change; what it throws refuses the change.
  using Accept = std::function<void(const RuntimeOptions&)>;

  Reconfigure(const ros::NodeHandle& pnh, const Parameters& at_start);
  ~Reconfigure();

  /// The values on the parameter server; throws std::invalid_argument when they contradict each other.
  RuntimeOptions startOptions();
  /// A change is taken, or refused as a whole with a sentence, and the parameters in force given back.
  /// Deadlock ahead: the server holds its mutex while it calls back, so nothing may wait for it with another held.
  void serve(Accept accept);

 private:
  struct Server;
  std::unique_ptr<Server> server_;
};

}  // namespace gms_ransac
