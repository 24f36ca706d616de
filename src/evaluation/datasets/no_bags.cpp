// Takes the place of the code that reads and writes bags where there is no ROS.
#include <stdexcept>

#include "datasets/dataset.h"
#include "scenes/scene_writer.h"

namespace gms_ransac {

namespace {

[[noreturn]] void refuse(const std::string& path) {
  throw std::invalid_argument(path + ": this program was built without ROS and has no bags; use a folder");
}

}  // namespace

void Dataset::readBag(const DatasetOptions&) { refuse(path_); }

void writeBag(const Scene&, int, const std::string& path, const std::function<void()>&) { refuse(path); }

}  // namespace gms_ransac
