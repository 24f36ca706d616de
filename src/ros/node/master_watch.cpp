#include "node/master_watch.h"

#include <chrono>

#include <ros/console.h>
#include <ros/init.h>
#include <ros/master.h>
#include <ros/this_node.h>

#include "guard.h"

namespace gms_ransac {

namespace {

constexpr std::chrono::seconds kPeriod{2};

bool call(const char* method, const std::string& argument, XmlRpc::XmlRpcValue& answer) {
  XmlRpc::XmlRpcValue request, response;
  request[0] = ros::this_node::getName();
  if (!argument.empty()) request[1] = argument;
  constexpr bool kWaitForMaster = false;
  return ros::master::execute(method, request, response, answer, kWaitForMaster);
}

}  // namespace

MasterWatch::MasterWatch(const std::string& name) : name_(name), thread_([this] { watch(); }) {}

MasterWatch::~MasterWatch() {
  {
    std::lock_guard<std::mutex> lock(mutex_);
    stopping_ = true;
  }
  stopped_.notify_all();
  thread_.join();
}

std::string MasterWatch::problem() const {
  std::lock_guard<std::mutex> lock(mutex_);
  return problem_;
}

void MasterWatch::watch() {
  std::unique_lock<std::mutex> lock(mutex_);
  do {
    lock.unlock();
    guarded([this] { report(ask()); },
            [this](const std::string& what) { report("the ROS master cannot be asked: " + what); });
    lock.lock();
  } while (!stopped_.wait_for(lock, kPeriod, [this] { return stopping_; }));
}

std::string MasterWatch::ask() {
  const std::string master = "the ROS master at " + ros::master::getURI();
  XmlRpc::XmlRpcValue pid, uri;
  if (!call("getPid", "", pid)) {
    return master +
           " does not answer: what is connected goes on, nothing new can connect; start it again and then the " +
           "nodes, this one too";
  }
  if (master_pid_ == 0) master_pid_ = static_cast<int>(pid);
  // In a container every master may have the same process id; but a new one knows no node.
  forgotten_ |= master_pid_ != static_cast<int>(pid) || !call("lookupNode", ros::this_node::getName(), uri);
  if (!forgotten_) return std::string();
  return master + " was restarted and knows nothing of " + ros::this_node::getName() +
         ": what is connected goes on, nobody else finds its topics and services; ROS 1 does not register them again, "
         "so restart it, and every other node that was running";
}

void MasterWatch::report(const std::string& problem) {
  std::lock_guard<std::mutex> lock(mutex_);
  // While the process ends nothing is asked of the master any more, whatever it could answer.
  if (stopping_ || !ros::ok() || problem == problem_) return;
  problem_ = problem;
  if (problem.empty()) {
    ROS_INFO_STREAM(name_ << ": the ROS master answers again");
  } else {
    ROS_ERROR_STREAM(name_ << ": " << problem);
  }
}

}  // namespace gms_ransac
