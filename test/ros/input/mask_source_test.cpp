// ~mask_file is the file of an image, or the node does not start and says so.
#include "input/mask_source.h"

#include <filesystem>
#include <fstream>
#include <stdexcept>

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <opencv2/imgcodecs.hpp>

namespace gms_ransac {
namespace {

namespace fs = std::filesystem;

class MaskSourceTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() / ("gms_ransac_mask_" + std::string(info->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  static void expectRefused(const std::string& path) {
    Parameters parameters;
    parameters.mask_file = path;
    try {
      MaskSource source(parameters);
      ADD_FAILURE() << path << " was read";
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find("~mask_file is '" + path + "'"), std::string::npos) << error.what();
    }
  }

  fs::path folder_;
};

TEST_F(MaskSourceTest, ReadsAnImageFile) {
  const std::string path = (folder_ / "mask.png").string();
  cv::imwrite(path, cv::Mat(8, 8, CV_8UC1, cv::Scalar(255)));
  Parameters parameters;
  parameters.mask_file = path;
  cv::Mat mask;
  EXPECT_EQ(MaskSource(parameters).get(nullptr, {64, 64}, mask), "");
  EXPECT_EQ(mask.size(), cv::Size(64, 64));
}

TEST_F(MaskSourceTest, WaitsForNoPipeAndReadsNoDevice) {
  const std::string pipe = (folder_ / "mask.png").string();
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  expectRefused(pipe);
  expectRefused("/dev/zero");
  expectRefused(folder_.string());
}

TEST_F(MaskSourceTest, RefusesAnImageThatClaimsToBeTooLarge) {
  // A portable grey map of 2^31 - 1 pixels a side, as its header has it.
  const std::string path = (folder_ / "mask.pgm").string();
  std::ofstream(path) << "P5 2147483647 2147483647 255\n";
  expectRefused(path);
}

}  // namespace
}  // namespace gms_ransac
