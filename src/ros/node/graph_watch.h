// Asks the ROS master every other second: does it still know this node, and which topics are published? roscpp does
// neither. An unreachable master may take long not to answer, and nobody waits for it.
#pragma once

#include <future>
#include <string>

#include "input/topics.h"

namespace gms_ransac {

class GraphWatch {
 public:
  /// `name`: prefix of log lines.
  explicit GraphWatch(const std::string& name) : name_(name) {}

  /// Asks the master, or takes its answer and logs what changed. Called every second; never waits.
  void look();
  /// Problem of the master or of the registration of this node, and the remedy; empty: none.
  const std::string& problem() const { return last_.problem; }
  const Topics& topics() const { return last_.topics; }

 private:
  struct Answer {
    std::string problem;
    Topics topics;
  };
  Answer ask();

  const std::string name_;
  int master_pid_ = 0;      ///< of the first answer; 0: none yet
  bool forgotten_ = false;  ///< stays set: a node that registers some topics again is still not complete
  Answer last_;
  std::future<Answer> asked_;  ///< last: waits for the answer at the end
};

}  // namespace gms_ransac
