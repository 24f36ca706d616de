// Data sets of folders without those of bags, which need ROS.
#include <stdexcept>

#include "datasets/dataset.h"

namespace gms_ransac {

void Dataset::readBag(const std::string&) {
  throw std::invalid_argument(path_ + " is a bag, and this program is built without ROS");
}

}  // namespace gms_ransac
