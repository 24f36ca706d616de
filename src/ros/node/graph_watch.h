// Asks the ROS master every other second: does it still know this node, and which topics are published? roscpp does
// neither. An unreachable master may take long not to answer, and nobody waits for it.
#pragma once

#include <future>
#include <memory>
#include <string>

#include "input/topics.h"

namespace gms_ransac {

class GraphWatch {
 public:
  /// `name`: prefix of log lines.
  explicit GraphWatch(const std::string& name);
  /// Does not wait for a master that does not answer.
  ~GraphWatch();

  /// Asks the master, or takes its answer and logs what changed. Called every second; never waits.
  void look();
  /// The master, or its silence, has answered at least once.
  bool answered() const { return answered_; }
  /// Problem of the master or of the registration of this node, and the remedy; empty: none.
  const std::string& problem() const { return last_.problem; }
  const Topics& topics() const { return last_.topics; }

 private:
  struct Answer {
    std::string problem;
    Topics topics;
  };
  class Asker;

  const std::string name_;
  const std::shared_ptr<Asker> asker_;  ///< shared with the thread that asks, which may outlive this
  bool answered_ = false;
  Answer last_;
  std::future<Answer> asked_;
};

}  // namespace gms_ransac
