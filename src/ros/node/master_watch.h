// Notices that the ROS master is gone, or was restarted and has forgotten this node; roscpp does neither.
#pragma once

#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

namespace gms_ransac {

/// Asks the master every few seconds, on a thread of its own, because an unreachable one may take long not to answer.
class MasterWatch {
 public:
  /// `name` stands in front of log lines.
  explicit MasterWatch(const std::string& name);
  ~MasterWatch();

  /// What is wrong and what to do; empty: nothing.
  std::string problem() const;

 private:
  void watch();
  /// A sentence as `problem` gives it.
  std::string ask();
  void report(const std::string& problem);

  const std::string name_;
  int master_pid_ = 0;      ///< of the first answer; 0: none yet
  bool forgotten_ = false;  ///< for good: what is registered anew by chance is not everything

  mutable std::mutex mutex_;  ///< guards what follows
  std::condition_variable stopped_;
  bool stopping_ = false;
  std::string problem_;
  std::thread thread_;
};

}  // namespace gms_ransac
