#include "node/graph_watch.h"

#include <chrono>

#include <ros/console.h>
#include <ros/init.h>
#include <ros/master.h>
#include <ros/this_node.h>

#include "guard.h"

namespace gms_ransac {

namespace {

constexpr std::chrono::seconds kPeriod{2};

/// False: no answer, or one that says the call failed.
bool call(const char* method, const char* argument, XmlRpc::XmlRpcValue& answer) {
  XmlRpc::XmlRpcValue request, response;
  request[0] = ros::this_node::getName();
  if (argument != nullptr) request[1] = argument;
  constexpr bool kWaitForMaster = false;
  return ros::master::execute(method, request, response, answer, kWaitForMaster);
}

}  // namespace

GraphWatch::GraphWatch(const std::string& name) : name_(name), thread_([this] { watch(); }) {}

GraphWatch::~GraphWatch() {
  {
    std::lock_guard<std::mutex> lock(mutex_);
    stopping_ = true;
  }
  stopped_.notify_all();
  thread_.join();
}

std::string GraphWatch::problem() const {
  std::lock_guard<std::mutex> lock(mutex_);
  return problem_;
}

Topics GraphWatch::topics() const {
  std::lock_guard<std::mutex> lock(mutex_);
  return topics_;
}

void GraphWatch::watch() {
  std::unique_lock<std::mutex> lock(mutex_);
  do {
    lock.unlock();
    std::string problem;
    Topics topics;
    guarded([&] { problem = ask(topics); },
            [&](const std::string& what) { problem = "the request to the ROS master failed: " + what; });
    lock.lock();
    topics_ = std::move(topics);
    // While the process ends the master's answers mean nothing.
    if (stopping_ || !ros::ok() || problem == problem_) continue;
    problem_ = problem;
    if (problem.empty()) {
      ROS_INFO_STREAM(name_ << ": the ROS master answers again");
    } else {
      ROS_ERROR_STREAM(name_ << ": " << problem);
    }
  } while (!stopped_.wait_for(lock, kPeriod, [this] { return stopping_; }));
}

std::string GraphWatch::ask(Topics& topics) {
  const std::string master = "the ROS master at " + ros::master::getURI();
  XmlRpc::XmlRpcValue pid, uri, published;
  if (!call("getPid", nullptr, pid)) {
    return master + " does not answer: existing connections work, new ones cannot be made; restart it, then all nodes";
  }
  if (master_pid_ == 0) master_pid_ = static_cast<int>(pid);
  // In a container every master may have the same process id; but a new one knows no node.
  forgotten_ |= master_pid_ != static_cast<int>(pid) || !call("lookupNode", ros::this_node::getName().c_str(), uri);
  if (forgotten_) {
    return master + " was restarted and knows nothing of " + ros::this_node::getName() +
           ": existing connections work, new ones cannot be made; restart this node and all others";
  }
  if (call("getPublishedTopics", "", published)) {
    for (int i = 0; i < published.size(); ++i) topics[published[i][0]] = static_cast<std::string>(published[i][1]);
  }
  return std::string();
}

}  // namespace gms_ransac
