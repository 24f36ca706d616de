// Polls the ROS master every few seconds: does it still know this node, and which topics are published? roscpp does
// neither. An unreachable master may take long not to answer: the watch has a thread of its own.
#pragma once

#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

#include "input/topics.h"

namespace gms_ransac {

class GraphWatch {
 public:
  /// `name`: prefix of log lines.
  explicit GraphWatch(const std::string& name);
  ~GraphWatch();

  /// Problem of the master or of the registration of this node, and the remedy; empty: none.
  std::string problem() const;
  Topics topics() const;

 private:
  void watch();
  std::string ask(Topics& topics);

  const std::string name_;
  int master_pid_ = 0;      ///< of the first answer; 0: none yet
  bool forgotten_ = false;  ///< stays set: a node that registers some topics again is still not complete

  mutable std::mutex mutex_;  ///< guards what follows
  std::condition_variable stopped_;
  bool stopping_ = false;
  std::string problem_;
  Topics topics_;
  std::thread thread_;
};

}  // namespace gms_ransac
