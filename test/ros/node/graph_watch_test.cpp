// A master that takes the question and never answers, as one whose machine hangs.
#include "node/graph_watch.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>

#include <gtest/gtest.h>
#include <ros/datatypes.h>

namespace ros::master {
void init(const M_string& remappings);  // part of ros::init, which would begin a node
}

namespace gms_ransac {
namespace {

/// Accepts connections, as the system does for a socket that listens, and reads nothing.
class SilentMaster {
 public:
  SilentMaster() : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    const bool listens = bind(socket_, reinterpret_cast<sockaddr*>(&address), size) == 0 && listen(socket_, 8) == 0;
    EXPECT_TRUE(listens && getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size) == 0);
    ros::master::init({{"__master", "http://127.0.0.1:" + std::to_string(ntohs(address.sin_port))}});
  }
  ~SilentMaster() { close(socket_); }

 private:
  const int socket_;
};

TEST(GraphWatch, NobodyWaitsForAMasterThatDoesNotAnswer) {
  const SilentMaster master;
  GraphWatch watch("node");
  for (int i = 0; i < 3; ++i) watch.look();
  EXPECT_FALSE(watch.answered());
  EXPECT_EQ(watch.problem(), "");
  // The end of the test: nothing waits for the answer, which would be for ever.
}

}  // namespace
}  // namespace gms_ransac
