// A mask in the size of the image, or a sentence; ~mask_file is the file of an image, or the node does not start.
#include "input/mask_source.h"

#include <stdexcept>

#include <cv_bridge/cv_bridge.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <opencv2/imgcodecs.hpp>

#include "exif.h"
#include "says.h"
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

TEST(MaskSource, IsNotTurnedByItsExifOrientation) {
  const ScratchFolder folder;
  std::vector<uint8_t> jpeg;
  cv::imencode(".jpg", cv::Mat(40, 64, CV_8UC1, cv::Scalar(255)), jpeg);
  std::string photograph(jpeg.begin(), jpeg.end());
  setExifOrientation(6, photograph);
  folder.write("mask.jpg", photograph);
  cv::Mat mask;
  EXPECT_EQ(sourceOf(folder.path("mask.jpg")).get(nullptr, {64, 40}, mask), "");
}

TEST(MaskSource, ScalesAMessageOfTheImagesShapeAndRefusesOthers) {
  const struct {
    cv::Size size;
    std::string encoding;
    std::vector<std::string> words;
  } rows[] = {{{64, 48}, "mono8", {}},
              {{16, 12}, "8UC1", {}},
              {{64, 48}, "bgr8", {"'bgr8'", "send mono8"}},
              {{20, 20}, "mono8", {"the mask is 20x20 and the image 64x48", "shape"}}};
  for (const auto& row : rows) {
    cv::Mat left(row.size, row.encoding == "bgr8" ? CV_8UC3 : CV_8UC1, cv::Scalar::all(1)), mask;
    left.colRange(row.size.width / 2, row.size.width) = cv::Scalar::all(0);
    const auto message = cv_bridge::CvImage(std_msgs::Header(), row.encoding, left).toImageMsg();
    EXPECT_TRUE(says(MaskSource(Parameters()).get(message, {64, 48}, mask), row.words));
    EXPECT_EQ(mask.empty(), !row.words.empty());
    if (mask.empty()) continue;
    EXPECT_EQ(cv::countNonZero(mask), 32 * 48);
    EXPECT_EQ(cv::countNonZero(mask.colRange(0, 32)), 32 * 48);
  }
  Parameters exact;
  exact.mask_sync = MaskSync::kExact;
  cv::Mat mask;
  EXPECT_EQ(MaskSource(exact).get(nullptr, {64, 48}, mask), "none of its stamp came on ~mask");
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
      EXPECT_TRUE(says(error.what(), {"~mask_file is '" + path + "'"}));
    }
  }
}

}  // namespace
}  // namespace gms_ransac
