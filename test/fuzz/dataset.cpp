// Folders of image sets: their lists, calibrations, times and poses are read, or refused with a DatasetError that names
// the file. The input is the kind of the folder and the texts of its files, with a zero byte between them.
#include "datasets/dataset.h"

#include <cmath>

#include <Eigen/LU>

#include "fuzz_input.h"
#include "scratch_folder.h"

namespace gms_ransac {
namespace {

constexpr const char* kFiles[3][4] = {{"rgb.txt", "groundtruth.txt", "depth.txt", "camera.txt"},
                                      {"poses.txt", "times.txt", "calib.txt", "camera.txt"},
                                      {"pairs.txt", "matrix.txt", "camera.txt", "other.txt"}};

void write(const ScratchFolder& folder, int kind, const std::string& texts) {
  size_t begin = 0;
  for (const char* name : kFiles[kind]) {
    const size_t end = texts.find('\0', begin);
    const std::string text = texts.substr(begin, end == std::string::npos ? end : end - begin);
    if (!text.empty() || begin == 0) folder.write(name, text);
    if (end == std::string::npos) break;
    begin = end + 1;
  }
  if (kind != 1) return;
  for (const char* image : {"000000.png", "000001.png"}) folder.write(std::string("image_0/") + image, "no picture");
}

void checkSet(const Dataset& set) {
  for (const DatasetFrame& frame : set.frames()) {
    demand(std::isfinite(frame.stamp), "a stamp is finite");
    if (!frame.pose) continue;
    demand(frame.pose->matrix().allFinite(), "a pose is finite");
    const Eigen::Matrix3d R = frame.pose->linear();
    demand((R.transpose() * R).isIdentity(0.02) && R.determinant() > 0, "a pose's rotation is one");
  }
  if (set.intrinsics()) demand(set.intrinsics()->calibrated(), "intrinsics are positive");
  const int n = static_cast<int>(set.frames().size());
  for (const DatasetPair& pair : set.pairs(1, 1)) {
    demand(pair.reference >= 0 && pair.reference < n && pair.current >= 0 && pair.current < n, "a pair has frames");
    if (pair.homography) demand(pair.homography->allFinite(), "a homography is finite");
    if (pair.disparity) demand(pair.disparity->scale > 0, "a scale is positive");
  }
}

}  // namespace

void check(FuzzInput input) {
  static const ScratchFolder folder;
  folder.clear();
  const int kind = input.between(0, 2);
  DatasetOptions options;
  if (input.byte() > 224) options.intrinsics = input.text(60);
  write(folder, kind, input.rest());
  try {
    const Dataset set = Dataset::open(folder.path(), options);
    checkSet(set);
    set.image(0);
    demand(false, "a text is no image");
  } catch (const DatasetError& error) {
    // A list may name a file anywhere, so the complaint need not be about this folder.
    demand(std::string(error.what()).find(": ") != std::string::npos, "a complaint names what it is about");
  }
}

}  // namespace gms_ransac
