// ~mask_file is the file of an image, or the node does not start and says so.
#include "input/mask_source.h"

#include <stdexcept>

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <opencv2/imgcodecs.hpp>

#include "scratch_folder.h"

namespace gms_ransac {
namespace {

MaskSource sourceOf(const std::string& file) {
  Parameters parameters;
  parameters.mask_file = file;
  return MaskSource(parameters);
}

TEST(MaskSource, ReadsAnImageFile) {
  const ScratchFolder folder;
  cv::imwrite(folder.path("mask.png"), cv::Mat(8, 8, CV_8UC1, cv::Scalar(255)));
  cv::Mat mask;
  EXPECT_EQ(sourceOf(folder.path("mask.png")).get(nullptr, {64, 64}, mask), "");
  EXPECT_EQ(mask.size(), cv::Size(64, 64));
}

TEST(MaskSource, ReadsNoPipeNoDeviceAndNoImageThatClaimsToBeTooLarge) {
  const ScratchFolder folder;
  ASSERT_EQ(mkfifo(folder.path("pipe.png").c_str(), 0600), 0);
  // A portable grey map of 2^31 - 1 pixels a side, as its header has it.
  folder.write("mask.pgm", "P5 2147483647 2147483647 255\n");
  for (const std::string& path :
       {folder.path("pipe.png"), folder.path("mask.pgm"), folder.path(), std::string("/dev/zero")}) {
    try {
      sourceOf(path);
      ADD_FAILURE() << path << " was read";
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find("~mask_file is '" + path + "'"), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace gms_ransac
