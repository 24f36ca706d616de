// gms_ransac/MatchFilter: the match filter as a nodelet.
#include <exception>
#include <memory>

#include <nodelet/nodelet.h>
#include <pluginlib/class_list_macros.hpp>

#include "node/match_filter_ros.h"

namespace gms_ransac {

class MatchFilterNodelet : public nodelet::Nodelet {
  void onInit() override {
    try {
      // The single-threaded handle keeps images in order; the heavy work has its own thread.
      filter_ = runMatchFilter(getNodeHandle(), getPrivateNodeHandle());
    } catch (const std::exception& error) {
      NODELET_FATAL("%s: %s", getName().c_str(), error.what());
      throw;
    }
  }
  std::shared_ptr<void> filter_;
};

}  // namespace gms_ransac

PLUGINLIB_EXPORT_CLASS(gms_ransac::MatchFilterNodelet, nodelet::Nodelet)
