// Bags and folders written by the tools, read back: topics, frames, intrinsics, pictures, depth and truth.
#include "datasets/bag_writer.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>

#include <gtest/gtest.h>
#include <rosbag/view.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <tf2_msgs/TFMessage.h>
#include <opencv2/imgcodecs.hpp>

#include "datasets/dataset.h"
#include "run_program.h"
#include "scenes/scene_writer.h"
#include "scratch_folder.h"

namespace gms_ransac {
namespace {

namespace fs = std::filesystem;
constexpr int kFrames = 4;

class Written : public ::testing::Test {
 protected:
  Written() {
    SceneOptions options;
    options.size = {320, 240};
    options.colour = true;
    options.distortion = {0.1, -0.05, 0.001, 0.002, 0};
    scene_ = std::make_unique<Scene>(options);
  }
  std::string path(const std::string& name) const { return folder_.path(name); }

  std::map<std::string, int> messagesPerTopic(const std::string& file) const {
    rosbag::Bag bag(file, rosbag::bagmode::Read);
    std::map<std::string, int> count;
    for (const rosbag::MessageInstance& m : rosbag::View(bag)) ++count[m.getTopic()];
    return count;
  }
  /// A folder as a bag of the same name.
  Outcome toBag(const std::string& folder) const {
    return run(PROGRAMS "/dataset_to_bag " + path(folder) + " " + path(folder + ".bag"));
  }
  template <typename Message>
  typename Message::ConstPtr first(const std::string& file, const std::string& topic) const {
    rosbag::Bag bag(file, rosbag::bagmode::Read);
    rosbag::View view(bag, rosbag::TopicQuery(topic));
    return view.begin()->instantiate<Message>();
  }
  void expectScenePoses(const Dataset& dataset, double tolerance, double start = kSceneStart, double rate = 30) const {
    ASSERT_EQ(dataset.frames().size(), static_cast<size_t>(kFrames));
    for (int i = 0; i < kFrames; ++i) {
      ASSERT_TRUE(dataset.frames()[i].pose.has_value()) << i;
      EXPECT_LT((dataset.frames()[i].pose->matrix() - scene_->pose(i).matrix()).norm(), tolerance) << i;
      EXPECT_NEAR(dataset.frames()[i].stamp, start + i / rate, 1e-6);
    }
  }

  const ScratchFolder folder_;
  std::unique_ptr<Scene> scene_;
};

TEST_F(Written, TumFolderHoldsTheScene) {
  int calls = 0;
  writeTumFolder(*scene_, kFrames, path("scene"), [&calls] { ++calls; });
  EXPECT_EQ(calls, kFrames);
  const Dataset dataset = Dataset::open(path("scene"));
  EXPECT_EQ(dataset.kind(), DatasetKind::kTum);
  expectScenePoses(dataset, 1e-9);
  ASSERT_TRUE(dataset.intrinsics().has_value());
  EXPECT_DOUBLE_EQ(dataset.intrinsics()->fx, scene_->intrinsics().fx);
  EXPECT_EQ(dataset.intrinsics()->distortion, scene_->intrinsics().distortion);
  const RenderedFrame frame = scene_->render(2);
  EXPECT_EQ(cv::norm(dataset.image(2, true), frame.image, cv::NORM_INF), 0);
  EXPECT_LE(cv::norm(dataset.depth(2), frame.depth, cv::NORM_INF), 0.5 / 5000 + 1e-6);
}

TEST_F(Written, ABagIsNotOverwritten) {
  writeTumFolder(*scene_, kFrames, path("twice"), [] {});
  ASSERT_EQ(toBag("twice").status, 0);
  const auto before = messagesPerTopic(path("twice.bag"));
  const Outcome again = toBag("twice");
  EXPECT_EQ(again.status, 2);
  EXPECT_NE(again.text.find("twice.bag: exists; remove it"), std::string::npos) << again.text;
  EXPECT_EQ(messagesPerTopic(path("twice.bag")), before);
}

TEST_F(Written, SceneBagLooksLikeTumsAndHoldsTheScene) {
  writeBag(*scene_, kFrames, path("scene.bag"), [] {});
  const std::map<std::string, int> expected = {{"/camera/rgb/image_color", kFrames},
                                               {"/camera/rgb/camera_info", kFrames},
                                               {"/camera/depth/image", kFrames},
                                               {"/camera/depth/camera_info", kFrames},
                                               {"/tf", kFrames}};
  EXPECT_EQ(messagesPerTopic(path("scene.bag")), expected);
  const auto info = first<sensor_msgs::CameraInfo>(path("scene.bag"), "/camera/rgb/camera_info");
  EXPECT_EQ(info->header.frame_id, "/openni_rgb_optical_frame");
  EXPECT_EQ(info->width, 320u);
  EXPECT_EQ(info->K[0], scene_->intrinsics().fx);
  EXPECT_EQ(info->D, scene_->intrinsics().distortion);
  const auto depth = first<sensor_msgs::Image>(path("scene.bag"), "/camera/depth/image");
  EXPECT_EQ(depth->encoding, "32FC1");
  EXPECT_EQ(depth->header.frame_id, "/openni_rgb_optical_frame");
  const auto tf = first<tf2_msgs::TFMessage>(path("scene.bag"), "/tf");
  std::string chain = tf->transforms.front().header.frame_id;
  for (const auto& t : tf->transforms) {
    EXPECT_EQ(t.header.frame_id, chain.substr(chain.rfind('/')));
    chain += t.child_frame_id;
  }
  EXPECT_EQ(chain, "/world/kinect/openni_camera/openni_rgb_frame/openni_rgb_optical_frame");

  const Dataset dataset = Dataset::open(path("scene.bag"));
  expectScenePoses(dataset, 1e-6);
  EXPECT_EQ(cv::norm(dataset.image(3, true), scene_->render(3).image, cv::NORM_INF), 0);
}

TEST_F(Written, UnknownDepthIsNotANumberInABag) {
  BagWriter bag(path("depth.bag"), BagLayout::kTum, scene_->intrinsics());
  bag.writeDepth(1.5, (cv::Mat_<float>(1, 2) << 0.f, 2.5f));
  EXPECT_FALSE(fs::exists(path("depth.bag"))) << "not before it has an index";
  bag.close();
  const auto message = first<sensor_msgs::Image>(path("depth.bag"), "/camera/depth/image");
  const float* metres = reinterpret_cast<const float*>(message->data.data());
  EXPECT_TRUE(std::isnan(metres[0]));
  EXPECT_EQ(metres[1], 2.5f);
}

TEST_F(Written, TumFolderBecomesABagWithItsOwnCalibration) {
  SceneOptions options;
  options.colour = true;
  options.focal_length = 500;
  const Scene scene(options);
  writeTumFolder(scene, 2, path("tum"), [] {});
  ASSERT_EQ(toBag("tum").status, 0);
  EXPECT_EQ(first<sensor_msgs::CameraInfo>(path("tum.bag"), "/camera/rgb/camera_info")->K[0], 500);
  const Dataset dataset = Dataset::open(path("tum.bag"));
  EXPECT_EQ(dataset.calibrationText(),
            "calibration of /camera/rgb/camera_info, P: fx 500, fy 500, cx 319.5, cy 239.5, no distortion");
  ASSERT_EQ(dataset.frames().size(), 2u);
  ASSERT_TRUE(dataset.frames()[1].pose.has_value());
  EXPECT_LT((dataset.frames()[1].pose->matrix() - scene.pose(1).matrix()).norm(), 1e-6);

  fs::remove(path("tum/camera.txt"));
  fs::remove(path("tum.bag"));
  EXPECT_NE(toBag("tum").text.find("since there is no camera.txt"), std::string::npos);
  const auto info = first<sensor_msgs::CameraInfo>(path("tum.bag"), "/camera/rgb/camera_info");
  EXPECT_EQ(info->K[0], 525);
  EXPECT_EQ(info->K[2], 319.5);
  EXPECT_EQ(info->K[5], 239.5);
  EXPECT_EQ(info->D, std::vector<double>(5, 0.0));
  EXPECT_NE(Dataset::open(path("tum.bag")).calibrationText().find("the OpenNI driver"), std::string::npos);
}

TEST_F(Written, KittiFolderBecomesABagLikeKitti2bags) {
  fs::create_directories(path("kitti/image_0"));
  std::ofstream poses(path("kitti/poses.txt"));
  poses.precision(12);
  for (int i = 0; i < kFrames; ++i) {
    cv::Mat grey;
    cv::extractChannel(scene_->render(i).image, grey, 1);
    cv::imwrite(path("kitti/image_0/00000" + std::to_string(i) + ".png"), grey);
    const Eigen::Isometry3d pose = scene_->pose(i);
    for (int k = 0; k < 12; ++k) poses << pose.matrix()(k / 4, k % 4) << (k == 11 ? '\n' : ' ');
  }
  poses.close();
  std::ofstream(path("kitti/calib.txt")) << "P0: 262.5 0 159.5 0 0 262.5 119.5 0 0 0 1 0\n";
  ASSERT_EQ(toBag("kitti").status, 0);
  const std::map<std::string, int> expected = {{"/kitti/camera_gray_left/image_rect", kFrames},
                                               {"/kitti/camera_gray_left/camera_info", kFrames},
                                               {"/tf", kFrames}};
  EXPECT_EQ(messagesPerTopic(path("kitti.bag")), expected);
  const auto info = first<sensor_msgs::CameraInfo>(path("kitti.bag"), "/kitti/camera_gray_left/camera_info");
  EXPECT_EQ(info->K[0], 0);
  EXPECT_EQ(info->P[0], 262.5);
  EXPECT_EQ(info->P[2], 159.5);
  EXPECT_TRUE(info->D.empty());
  EXPECT_EQ(info->distortion_model, "");
  const auto image = first<sensor_msgs::Image>(path("kitti.bag"), "/kitti/camera_gray_left/image_rect");
  EXPECT_EQ(image->encoding, "mono8");
  EXPECT_EQ(image->header.frame_id, "camera_gray_left");
  const auto tf = first<tf2_msgs::TFMessage>(path("kitti.bag"), "/tf");
  EXPECT_EQ(tf->transforms.at(0).header.frame_id, "world");
  EXPECT_EQ(tf->transforms.at(0).child_frame_id, "camera_left");
  expectScenePoses(Dataset::open(path("kitti.bag")), 1e-6, 1317042272, 10);
}

TEST_F(Written, KittiFolderOfTwoCamerasBecomesABagOfBoth) {
  for (const char* camera : {"image_0", "image_1"}) {
    fs::create_directories(path(std::string("rig/") + camera));
    for (const char* name : {"/000000.png", "/000001.png"}) {
      cv::imwrite(path(std::string("rig/") + camera + name), cv::Mat(40, 60, CV_8UC1, cv::Scalar(*camera)));
    }
  }
  std::ofstream(path("rig/calib.txt")) << "P0: 50 0 30 0 0 50 20 0 0 0 1 0\nP1: 50 0 30 -25 0 50 20 0 0 0 1 0\n";
  const Outcome made = toBag("rig");
  ASSERT_EQ(made.status, 0) << made.text;
  EXPECT_NE(made.text.find("fx 50, fy 50, cx 30, cy 20, no distortion; the right camera is 0.5 m to the right"),
            std::string::npos)
      << made.text;
  EXPECT_NE(made.text.find("kitti.launch variant:=odom camera:=gray_left bag:=" + path("rig.bag") + " stereo:=true"),
            std::string::npos)
      << made.text;
  const std::map<std::string, int> expected = {{"/kitti/camera_gray_left/image_rect", 2},
                                               {"/kitti/camera_gray_left/camera_info", 2},
                                               {"/kitti/camera_gray_right/image_rect", 2},
                                               {"/kitti/camera_gray_right/camera_info", 2}};
  EXPECT_EQ(messagesPerTopic(path("rig.bag")), expected);
  const auto info = first<sensor_msgs::CameraInfo>(path("rig.bag"), "/kitti/camera_gray_right/camera_info");
  EXPECT_EQ(info->header.frame_id, "camera_gray_right");
  EXPECT_EQ(info->P[3], -25);
  EXPECT_EQ(first<sensor_msgs::CameraInfo>(path("rig.bag"), "/kitti/camera_gray_left/camera_info")->P[3], 0);
}

TEST_F(Written, AFullDiskIsNamedAndKeepsNoBag) {
  writeTumFolder(*scene_, kFrames, path("full"), [] {});
  const std::string limited = "trap '' XFSZ; ulimit -f 200; " PROGRAMS;
  for (const std::string& command :
       {"/dataset_to_bag " + path("full") + " " + path("full.bag"), "/render_scene -n 4 " + path("full.bag")}) {
    const Outcome outcome = run(limited + command);
    EXPECT_EQ(outcome.status, 2) << outcome.text;
    EXPECT_NE(outcome.text.find("full.bag: writing failed; is the disk full?"), std::string::npos) << outcome.text;
    EXPECT_FALSE(fs::exists(path("full.bag")) || fs::exists(path("full.bag.active")));
  }
}

TEST_F(Written, BadInputIsRefusedAndLeavesNoBag) {
  EXPECT_THROW(BagWriter(path("no/such/folder.bag"), BagLayout::kTum, {}), std::runtime_error);
  EXPECT_THROW(writeTumFolder(*scene_, 1, "/proc/nothing", [] {}), std::runtime_error);
  writeTumFolder(*scene_, 2, path("broken"), [] {});
  std::ofstream(path("broken/rgb.txt"), std::ios::app) << "1600000005.0 rgb/missing.png\n";
  EXPECT_NE(toBag("broken").text.find("rgb/missing.png: no such image"), std::string::npos);
  EXPECT_FALSE(fs::exists(path("broken.bag")) || fs::exists(path("broken.bag.active")));
  fs::remove(path("broken/camera.txt"));  // 320 x 240 is no OpenNI image: without camera.txt nothing is known
  EXPECT_NE(toBag("broken").text.find("so there is no camera_info to write"), std::string::npos);
}

}  // namespace
}  // namespace gms_ransac
