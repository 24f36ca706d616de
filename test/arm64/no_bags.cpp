// Data sets of folders without those of bags, which need ROS.
#include <stdexcept>

#include "datasets/dataset_text.h"

namespace gms_ransac {

Dataset openBag(const std::string& file, const DatasetOptions&) {
  throw std::invalid_argument(file + " is a bag, and this program is built without ROS");
}

}  // namespace gms_ransac
