#include "node/graph_watch.h"

#include <chrono>
#include <thread>
#include <utility>

#include <ros/console.h>
#include <ros/init.h>
#include <ros/master.h>
#include <ros/this_node.h>

#include "guard.h"

namespace gms_ransac {

namespace {

constexpr std::chrono::seconds kPatienceAtEnd(1);

/// False: no answer, or one that says the call failed.
bool call(const char* method, const char* argument, XmlRpc::XmlRpcValue& answer) {
  XmlRpc::XmlRpcValue request, response;
  request[0] = ros::this_node::getName();
  if (argument != nullptr) request[1] = argument;
  constexpr bool kWaitForMaster = false;
  return ros::master::execute(method, request, response, answer, kWaitForMaster);
}

}  // namespace

/// Used by one thread at a time.
class GraphWatch::Asker {
 public:
  Answer ask();

 private:
  int master_pid_ = 0;      ///< of the first answer; 0: none yet
  bool forgotten_ = false;  ///< stays set: a node that registers some topics again is still not complete
};

GraphWatch::GraphWatch(const std::string& name) : name_(name), asker_(std::make_shared<Asker>()) {}

GraphWatch::~GraphWatch() {
  // A thread that asks while the process ends might use what is destroyed already; a master that is there is fast.
  if (asked_.valid()) asked_.wait_for(kPatienceAtEnd);
}

void GraphWatch::look() {
  if (!asked_.valid()) {
    std::packaged_task<Answer()> question([asker = asker_] {
      Answer answer;
      guarded([&] { answer = asker->ask(); },
              [&](const std::string& what) { answer.problem = "the request to the ROS master failed: " + what; });
      return answer;
    });
    asked_ = question.get_future();
    std::thread(std::move(question)).detach();  // the future of std::async would wait for it
    return;
  }
  // While the process ends the master's answers mean nothing.
  if (!ros::ok() || asked_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
  const std::string before = last_.problem;
  last_ = asked_.get();
  answered_ = true;
  if (last_.problem == before) return;
  if (last_.problem.empty()) {
    ROS_INFO_STREAM(name_ << ": the ROS master answers again");
  } else {
    ROS_ERROR_STREAM(name_ << ": " << last_.problem);
  }
}

GraphWatch::Answer GraphWatch::Asker::ask() {
  Answer answer;
  const std::string master = "the ROS master at " + ros::master::getURI();
  XmlRpc::XmlRpcValue pid, uri, published;
  if (!forgotten_) {
    const bool known = call("lookupNode", ros::this_node::getName().c_str(), uri);
    // Asked last: a master that ends in between knows no node either, but was not restarted.
    if (!call("getPid", nullptr, pid)) {
      answer.problem =
          master + " does not answer: existing connections work, new ones cannot be made; restart it, then all nodes";
      return answer;
    }
    if (master_pid_ == 0) master_pid_ = static_cast<int>(pid);
    // In a container every master may have the same process id; but a new one knows no node.
    forgotten_ = master_pid_ != static_cast<int>(pid) || !known;
  }
  if (forgotten_) {
    answer.problem = master + " was restarted and knows nothing of " + ros::this_node::getName() +
                     ": existing connections work, new ones cannot be made; restart this node and all others";
  } else if (call("getPublishedTopics", "", published)) {
    for (int i = 0; i < published.size(); ++i) {
      answer.topics[published[i][0]] = static_cast<std::string>(published[i][1]);
    }
  }
  return answer;
}

}  // namespace gms_ransac
