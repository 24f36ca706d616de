// The program render_scene along a file of poses: the folder and the bag that it writes, and options that it refuses.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include <gtest/gtest.h>
#include <rosbag/view.h>
#include <sensor_msgs/Imu.h>
#include <tf2_eigen/tf2_eigen.h>
#include <tf2_msgs/TFMessage.h>

#include "datasets/dataset.h"
#include "run_program.h"
#include "says.h"
#include "scenes/scene.h"
#include "scratch_folder.h"

namespace gms_ransac {
namespace {

namespace fs = std::filesystem;

class RenderScene : public ::testing::Test {
 protected:
  RenderScene() {
    std::ostringstream text;
    for (int i = 0; i <= 20; ++i) {  // a second of a sideways step, as TUM's text
      text << 100 + 0.05 * i << ' ' << 0.5 * std::sin(0.05 * i) << " 0 0 -0.5 0.5 -0.5 0.5\n";
    }
    folder_.write("poses.txt", text.str());
  }
  std::string path(const std::string& name) const { return folder_.path(name); }
  Outcome render(const std::string& out, const std::string& options) const {
    return run(PROGRAMS "/render_scene " + path(out) + " --width 64 --height 48 --grey --trajectory " +
               path("poses.txt") + " " + options);
  }
  const ScratchFolder folder_;
};

const char kImuOptions[] = "--imu-rate 200 --imu-delay 0.01 --camera-in-imu 0.1,0,0,0,0,0,1 --rate 20";

TEST_F(RenderScene, WritesAFolderWithThePosesAndTheImu) {
  const Outcome outcome = render("set", kImuOptions);
  ASSERT_EQ(outcome.status, 0) << outcome.text;
  const std::vector<DatasetFrame> frames = Dataset::open(path("set")).frames();
  ASSERT_EQ(frames.size(), 19u);  // of 21 poses at the same rate the first and the last are left out
  const Eigen::Vector3d way = frames.back().pose->translation() - frames.front().pose->translation();
  EXPECT_LT((way - Eigen::Vector3d(0.5 * (std::sin(0.95) - std::sin(0.05)), 0, 0)).norm(), 1e-5);
  std::ifstream imu(path("set/imu.csv"));
  std::string line;
  std::getline(imu, line);
  EXPECT_EQ(line.substr(0, 24), "#timestamp [ns],w_RS_S_x");
  int samples = 0;
  for (; std::getline(imu, line); ++samples) {
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), 6);
    EXPECT_NEAR(std::stod(line) * 1e-9, kSceneStart - 0.05 + 0.01 + samples / 200.0, 1e-6);
  }
  EXPECT_EQ(samples, 201);
}

TEST_F(RenderScene, WritesABagWithTheImuAndItsPlaceOnTheCamera) {
  const Outcome outcome = render("drive.bag", std::string(kImuOptions) + " --offset 0.3");
  ASSERT_EQ(outcome.status, 0) << outcome.text;
  rosbag::Bag bag(path("drive.bag"), rosbag::bagmode::Read);
  std::map<std::string, int> count;
  int places = 0;
  double mean_up = 0;
  for (const rosbag::MessageInstance& m : rosbag::View(bag)) {
    ++count[m.getTopic()];
    if (const auto imu = m.instantiate<sensor_msgs::Imu>()) {
      EXPECT_EQ(imu->header.frame_id, "/imu");
      EXPECT_EQ(imu->orientation_covariance[0], -1);
      EXPECT_NEAR(imu->angular_velocity_covariance[4], 1.7e-4 * 1.7e-4 * 200, 1e-12);
      mean_up -= imu->linear_acceleration.y / 201;  // the camera's y points down
    }
    const auto tf = m.instantiate<tf2_msgs::TFMessage>();
    if (!tf || tf->transforms[0].child_frame_id != "/imu") continue;
    ++places;
    EXPECT_EQ(tf->transforms[0].header.frame_id, "/openni_rgb_optical_frame");
    EXPECT_NEAR(tf2::transformToEigen(tf->transforms[0]).translation().x(), -0.1 - 0.3, 1e-12);
  }
  EXPECT_EQ(count["/camera/rgb/image_color"], 19);
  EXPECT_EQ(count["/imu"], 201);
  EXPECT_EQ(places, 19);
  EXPECT_NEAR(mean_up, kGravity, 0.02);
  EXPECT_FALSE(fs::exists(path("drive.bag.active")));
}

TEST_F(RenderScene, SaysInASentenceWhatIsWrong) {
  const auto complaint = [&](const std::string& options) {
    const Outcome outcome = render("none", options);
    EXPECT_EQ(outcome.status, 2) << options;
    EXPECT_EQ(std::count(outcome.text.begin(), outcome.text.end(), '\n'), 1) << outcome.text;
    return outcome.text;
  };
  EXPECT_TRUE(says(complaint("--step 0.1"), {"--step has no effect with --trajectory"}));
  EXPECT_TRUE(says(complaint("--poses-of drone"), {"--poses-of is 'drone'; it must be camera or imu"}));
  EXPECT_TRUE(says(complaint("--poses-of imu"), {"poses.txt: has poses of an IMU; give --camera-in-imu"}));
  EXPECT_TRUE(says(complaint("--camera-in-imu 1,2,3"), {"--camera-in-imu: expected x,y,z,qx,qy,qz,qw", "found 3"}));
  EXPECT_TRUE(says(complaint("--camera-in-imu 1,0,0,0,0,1,0,0,0,0,0,0"), {"--camera-in-imu: not a rotation"}));
  EXPECT_TRUE(says(complaint("--gyro-noise 1"), {"--gyro-noise needs --imu-rate"}));
  EXPECT_TRUE(says(complaint("--frames 40"), {"--frames is 40; the path ends after 29 frames"}));
  EXPECT_TRUE(says(complaint("--rate 1"), {"the path ends after 0 frames"}));
  EXPECT_TRUE(says(complaint("--scale -1"), {"scale is -1; it must be between"}));
  const Outcome outcome = run(PROGRAMS "/render_scene " + path("none") + " --from 3");
  EXPECT_TRUE(says(outcome.text, {"--from needs --trajectory"}));
  EXPECT_FALSE(fs::exists(path("none")));
}

TEST_F(RenderScene, AFullDiskKeepsNoBagWithoutItsImu) {
  render("whole.bag", "");
  const auto blocks = fs::file_size(path("whole.bag")) / 512 + 40;  // as the shell counts
  const Outcome outcome =
      run("trap '' XFSZ; ulimit -f " + std::to_string(blocks) + "; " PROGRAMS "/render_scene " + path("full.bag") +
          " --width 64 --height 48 --grey --imu-rate 2000 --trajectory " + path("poses.txt"));
  EXPECT_EQ(outcome.status, 2) << outcome.text;
  EXPECT_TRUE(says(outcome.text, {"full.bag: writing failed; is the disk full?"}));
  EXPECT_FALSE(fs::exists(path("full.bag")) || fs::exists(path("full.bag.active")));
}

}  // namespace
}  // namespace gms_ransac
