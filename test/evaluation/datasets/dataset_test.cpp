// The dataset reader on tiny folders and a bag written here: what is read, and every sentence of complaint.
#include "datasets/dataset.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <sys/stat.h>

#include <cv_bridge/cv_bridge.h>
#include <geometry_msgs/TransformStamped.h>
#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <tf2_msgs/TFMessage.h>
#include <opencv2/imgcodecs.hpp>

#include "camera/camera_info.h"
#include "exif.h"
#include "features/wide_image.h"
#include "run/truth.h"
#include "scratch_folder.h"

namespace gms_ransac {
namespace {

namespace fs = std::filesystem;

class DatasetTest : public ::testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) const { folder_.write(name, text); }
  void writeImage(const std::string& name, int value, int type = CV_8UC1) const {
    write(name, "");
    cv::imwrite(path(name), cv::Mat(4, 6, type, cv::Scalar::all(value)));
  }
  std::string path(const std::string& name = "") const { return folder_.path(name); }

  std::string complaint(const std::string& name = "", const DatasetOptions& options = {}) const {
    try {
      Dataset::open(path(name), options);
    } catch (const DatasetError& error) {
      const std::string sentence = error.what();
      const std::string prefix = path() + "/";
      return sentence.rfind(prefix, 0) == 0 ? sentence.substr(prefix.size()) : sentence;
    }
    return "no complaint";
  }

  struct Refusal {
    std::string file, text, complaint;  ///< behind the name of the file
  };
  /// Each such file is complained about in these words, and is then gone.
  void expectRefused(const std::vector<Refusal>& refusals) {
    for (const auto& [file, text, sentence] : refusals) {
      write(file, text);
      EXPECT_EQ(complaint(), file + sentence) << text;
      fs::remove(path(file));
    }
  }

  const ScratchFolder folder_;
};

using TumTest = DatasetTest;
using KittiTest = DatasetTest;
using PairsTest = DatasetTest;
using BagTest = DatasetTest;

TEST_F(TumTest, ReadsImagesDepthIntrinsicsAndInterpolatedPoses) {
  write("rgb.txt", "# stamp file\n1.00 rgb/a.png\n1.05 rgb/b.png\n\n1.50 rgb/c.png\n");
  write("depth.txt", "1.01 depth/a.png\n1.08 depth/b.png\n");
  // A rotation by 90 degrees about z between the first two samples, then a gap too long for interpolation.
  write("groundtruth.txt",
        "# tum\n1.01 0 0 0 0 0 0 1\n1.02 0 0 0 0 0 0 1\n1.10 8 0 0 0 0 0.7071067811865476 0.7071067811865476\n"
        "1.60 9 0 0 0 0 0 1\n");
  write("camera.txt", "500 501 320 240 0.1 -0.2 0.01 0.02 0.3\n");
  writeImage("rgb/a.png", 7, CV_8UC3);
  writeImage("rgb/b.png", 8);
  writeImage("depth/a.png", 2500, CV_16UC1);
  writeImage("depth/b.png", 2500, CV_16UC1);

  const Dataset dataset = Dataset::open(path() + "/");
  EXPECT_EQ(dataset.kind(), DatasetKind::kTum);
  EXPECT_EQ(dataset.path(), path());
  ASSERT_EQ(dataset.frames().size(), 3u);
  EXPECT_EQ(dataset.frames()[1].name, "rgb/b.png");
  EXPECT_DOUBLE_EQ(dataset.frames()[1].stamp, 1.05);
  EXPECT_EQ(dataset.frames()[0].depth, "depth/a.png");
  EXPECT_EQ(dataset.frames()[1].depth, "") << "30 ms apart is another instant";
  EXPECT_FALSE(dataset.frames()[0].pose) << "nothing before the first sample";
  ASSERT_TRUE(dataset.frames()[1].pose);
  EXPECT_FALSE(dataset.frames()[2].pose) << "inside a hole";
  const Eigen::Isometry3d pose = *dataset.frames()[1].pose;
  EXPECT_NEAR(pose.translation().x(), 3.0, 1e-9);
  EXPECT_NEAR(std::atan2(pose(1, 0), pose(0, 0)), M_PI / 2 * 0.375, 1e-9);
  ASSERT_TRUE(dataset.intrinsics());
  EXPECT_DOUBLE_EQ(dataset.intrinsics()->fy, 501);
  EXPECT_EQ(dataset.intrinsics()->distortion, (std::vector<double>{0.1, -0.2, 0.01, 0.02, 0.3}));
  EXPECT_EQ(dataset.image(0).type(), CV_8UC1);
  EXPECT_EQ(dataset.image(0, true).type(), CV_8UC3);
  EXPECT_FLOAT_EQ(dataset.depth(0).at<float>(2, 2), 0.5f);
  EXPECT_TRUE(dataset.depth(1).empty());

  DatasetOptions options;
  options.intrinsics = "1,2,3,4";
  EXPECT_DOUBLE_EQ(Dataset::open(path(), options).intrinsics()->fy, 2);
  options.intrinsics = "equidistant,1,2,3,4,5,6,7,8";
  EXPECT_EQ(Dataset::open(path(), options).intrinsics()->distortion_model, "equidistant");
}

TEST_F(TumTest, SixteenBitsAreScaledNotCutOff) {
  write("rgb.txt", "1 a.png\n");
  cv::Mat ramp(8, 100, CV_16UC1);
  for (int c = 0; c < ramp.cols; ++c) ramp.col(c) = cv::Scalar(10 * c);
  write("a.png", "");
  cv::imwrite(path("a.png"), ramp);
  const Dataset dataset = Dataset::open(path());
  const cv::Mat grey = dataset.image(0);
  EXPECT_EQ(cv::norm(grey, wideToGrey(ramp), cv::NORM_INF), 0) << "as the node does it";
  EXPECT_GT(grey.at<uint8_t>(2, 95) - grey.at<uint8_t>(2, 5), 200);
  EXPECT_EQ(dataset.image(0, true).at<cv::Vec3b>(2, 95), cv::Vec3b::all(grey.at<uint8_t>(2, 95)));
}

TEST_F(TumTest, ImagesAreNotTurnedByTheirExifOrientation) {
  std::vector<uint8_t> jpeg;
  cv::imencode(".jpg", cv::Mat(16, 24, CV_8UC1, cv::Scalar(90)), jpeg);
  std::string photograph(jpeg.begin(), jpeg.end());
  setExifOrientation(6, photograph);
  write("a.jpg", photograph);
  write("rgb.txt", "1 a.jpg\n");
  write("depth.txt", "1 a.jpg\n");
  const Dataset dataset = Dataset::open(path());
  EXPECT_EQ(dataset.image(0).size(), cv::Size(24, 16)) << "camera.txt describes the pixels as they are";
  EXPECT_EQ(dataset.depth(0).size(), cv::Size(24, 16));
}

TEST_F(TumTest, PairsFollowGapAndStride) {
  write("rgb.txt", "1 a\n2 b\n3 c\n4 d\n5 e\n6 f\n");
  const Dataset dataset = Dataset::open(path());
  const auto pairs = dataset.pairs(2, 3);
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_EQ(pairs[1].reference, 3);
  EXPECT_EQ(pairs[1].current, 5);
  EXPECT_TRUE(dataset.pairs(6, 1).empty());
}

TEST_F(TumTest, ComplainsWithFileAndLine) {
  const std::string entry = "expected a time stamp and a file name",
                    pose = "expected a pose (stamp tx ty tz qx qy qz qw)";
  const std::string camera = "expected fx fy cx cy [k1 k2 p1 p2 [k3]]";
  expectRefused({{"rgb.txt", "# nothing\n", ": lists no image"},
                 {"rgb.txt", "1.0 a.png\n# fine\n2.0\n", ":3: " + entry},
                 {"rgb.txt", "1.0 a.png\nsoon b.png\n", ":2: " + entry + ", but 'soon' is not a finite number"}});
  write("rgb.txt", "1.0 a.png\n");
  expectRefused({{"groundtruth.txt", "1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0\n", ":2: " + pose + ", found 7 fields"},
                 {"groundtruth.txt", "1 0 0 nan 0 0 0 1\n", ":1: " + pose + ", but 'nan' is not a finite number"},
                 {"groundtruth.txt", "1 0 0 0 0 0 0 0\n", ":1: the quaternion is not of unit length"},
                 // Its squares are beyond a double.
                 {"groundtruth.txt", "1 0 0 0 1e200 0 0 0\n", ":1: the quaternion is not of unit length"},
                 {"groundtruth.txt", "2 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n", ":2: the time stamps run backwards"},
                 {"camera.txt", "500 500 320\n", ":1: " + camera + ", found 3 numbers"},
                 {"camera.txt", "\n500 five 320 240\n", ":2: 'five' is not a finite number"},
                 {"camera.txt", "500 0 320 240\n", ":1: the focal lengths fx and fy must be positive"},
                 {"camera.txt", "", ":1: " + camera + ", but the file is empty"},
                 {"camera.txt", "1 2 3 4\n5 6 7 8\n", ":2: expected one line with fx fy cx cy [k1 k2 p1 p2 [k3]]"}});
  DatasetOptions options;
  options.intrinsics = "1,2";
  EXPECT_EQ(complaint("", options), "--intrinsics: " + camera + ", found 2 numbers");
  options.intrinsics = "equidistant,1,2,3,4";
  EXPECT_EQ(complaint("", options), "--intrinsics: expected equidistant fx fy cx cy k1 k2 k3 k4, found 4 numbers");
}

TEST_F(TumTest, OpensNoPipeAndNoDevice) {
  // One would wait for the other end of the pipe, and read the device until the memory is full.
  ASSERT_EQ(mkfifo(path("rgb.txt").c_str(), 0600), 0);
  EXPECT_NE(complaint().find("holds neither rgb.txt"), std::string::npos);
  fs::remove(path("rgb.txt"));
  fs::create_symlink("/dev/zero", path("rgb.txt"));
  EXPECT_NE(complaint().find("holds neither rgb.txt"), std::string::npos);
}

TEST_F(TumTest, GoesOnWithoutDepthImagesThatAreNotThere) {
  write("rgb.txt", "1.0 a.png\n2.0 b.png\n");
  write("depth.txt", "1.0 depth/a.png\n2.0 depth/b.png\n");
  writeImage("depth/b.png", 2500, CV_16UC1);
  const Dataset dataset = Dataset::open(path());
  EXPECT_EQ(dataset.notes(), std::vector<std::string>{path("depth.txt") + ": 1 of the 2 images are not there; their "
                                                                          "frames have no depth"});
  EXPECT_TRUE(dataset.depth(0).empty());
  EXPECT_FALSE(dataset.depth(1).empty());
  writeImage("depth/a.png", 2500, CV_16UC1);
  EXPECT_TRUE(Dataset::open(path()).notes().empty());
}

TEST_F(TumTest, ComplainsAboutImagesWhenTheyAreRead) {
  write("rgb.txt", "1.0 gone.png\n2.0 text.png\n");
  write("text.png", "not a picture");
  const Dataset dataset = Dataset::open(path());
  for (const auto& [frame, sentence] :
       {std::pair<int, std::string>{0, "/gone.png: no such image"}, {1, "/text.png: cannot be read as an image"}}) {
    try {
      dataset.image(frame);
      FAIL() << "read " << dataset.frames()[static_cast<size_t>(frame)].name;
    } catch (const DatasetError& error) {
      EXPECT_EQ(error.what(), path() + sentence);
    }
  }
}

TEST_F(KittiTest, ReadsImagesInNameOrderWithPosesTimesAndCalibration) {
  for (const char* name : {"image_0/000001.png", "image_0/000000.png", "image_0/000002.png"}) writeImage(name, 1);
  write("image_0/readme.txt", "not an image");
  write("calib.txt", "P0: 700 0 600 0 0 701 180 0 0 0 1 0\nP1: 1 0 0 0 0 1 0 0 0 0 1 0\n");
  write("poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n0 0 1 5 0 1 0 6 -1 0 0 7\n");
  write("times.txt", "0.0\n1.036e-01\n2.0e-01\n");
  const Dataset dataset = Dataset::open(path());
  EXPECT_EQ(dataset.kind(), DatasetKind::kKitti);
  ASSERT_EQ(dataset.frames().size(), 3u);
  EXPECT_EQ(dataset.frames()[1].name, "image_0/000001.png");
  EXPECT_DOUBLE_EQ(dataset.frames()[1].stamp, 0.1036);
  EXPECT_EQ(dataset.frames()[1].pose->translation(), Eigen::Vector3d(5, 6, 7));
  EXPECT_EQ((*dataset.frames()[1].pose)(0, 2), 1);
  EXPECT_FALSE(dataset.frames()[2].pose);
  EXPECT_DOUBLE_EQ(dataset.intrinsics()->fy, 701);
  write("camera.txt", "1 2 3 4");
  EXPECT_DOUBLE_EQ(Dataset::open(path()).intrinsics()->fy, 2) << "camera.txt goes before calib.txt";
}

TEST_F(KittiTest, SaysWhichImagesHaveAPoseWhereNotAllDo) {
  const std::string pose = "1 0 0 0 0 1 0 0 0 0 1 0\n";
  for (const char* name : {"image_0/0.png", "image_0/1.png"}) writeImage(name, 1);
  for (const auto& [poses, end] :
       {std::pair<int, std::string>{1, "last images have no true pose"}, {3, "last lines are not used"}}) {
    std::string lines;
    for (int i = 0; i < poses; ++i) lines += pose;
    write("poses.txt", lines);
    const Dataset dataset = Dataset::open(path());
    EXPECT_EQ(dataset.notes(), std::vector<std::string>{path("poses.txt") + ": has " + std::to_string(poses) +
                                                        " poses for 2 images; line i belongs to the i-th image in name "
                                                        "order, and the " +
                                                        end});
    EXPECT_EQ(dataset.frames()[1].pose.has_value(), poses == 3);
  }
  write("poses.txt", pose + pose);
  EXPECT_TRUE(Dataset::open(path()).notes().empty());
}

TEST_F(KittiTest, ReadsTheOtherCameraWithItsCalibrationAndPlace) {
  for (const char* name : {"image_0/0.png", "image_1/0.png", "image_1/1.png"}) writeImage(name, 1);
  write("calib.txt", "P0: 700 0 600 0 0 701 180 0 0 0 1 0\nP1: 710 0 600 -355 0 701 180 0 0 0 1 0\n");
  write("poses.txt", "0 0 1 5 0 1 0 6 -1 0 0 7\n");  // looks along x, so that the right of the camera is -z
  const Dataset dataset = Dataset::open(path("image_1/"));
  EXPECT_EQ(dataset.kind(), DatasetKind::kKitti);
  EXPECT_EQ(dataset.name(), fs::path(path()).filename().string() + "/image_1");
  ASSERT_EQ(dataset.frames().size(), 2u);
  EXPECT_EQ(dataset.image(1).rows, dataset.image(0).rows);
  EXPECT_DOUBLE_EQ(dataset.intrinsics()->fx, 710);
  EXPECT_NE(dataset.calibrationText().find("calib.txt, P1"), std::string::npos);
  EXPECT_TRUE(dataset.frames()[0].pose->translation().isApprox(Eigen::Vector3d(5, 6, 6.5)));
  EXPECT_EQ(layoutOf(path("image_1")), DatasetKind::kKitti);
  EXPECT_FALSE(layoutOf(path("image_7"))) << "is not there";
}

TEST_F(KittiTest, HasTheImagesOfTheRightCamera) {
  for (const char* name : {"image_0/0.png", "image_0/1.png", "image_1/1.png"}) writeImage(name, 1);
  EXPECT_FALSE(Dataset::open(path()).rightCamera()) << "nothing says where it is";
  write("calib.txt", "P0: 700 0 600 0 0 701 180 0 0 0 1 0\nP1: 710 0 600 -355 0 701 180 0 0 0 1 0\n");
  const Dataset dataset = Dataset::open(path());
  ASSERT_TRUE(dataset.rightCamera());
  EXPECT_DOUBLE_EQ(dataset.rightCamera()->baseline, 0.5);
  EXPECT_DOUBLE_EQ(dataset.rightCamera()->intrinsics.fx, 710);
  EXPECT_EQ(dataset.frames()[1].right, "image_1/1.png");
  EXPECT_EQ(dataset.right(1).size(), dataset.image(1).size());
  EXPECT_TRUE(dataset.right(0).empty());
  EXPECT_FALSE(Dataset::open(path("image_1")).rightCamera());
}

TEST_F(KittiTest, AcceptsTheOtherFolderNameAndMissingFiles) {
  writeImage("image_l/000000.jpg", 1);
  const Dataset dataset = Dataset::open(path());
  EXPECT_EQ(dataset.frames().at(0).name, "image_l/000000.jpg");
  EXPECT_FALSE(dataset.intrinsics());
}

TEST_F(KittiTest, ComplainsWithFileAndLine) {
  EXPECT_EQ(complaint(), path() + ": holds neither rgb.txt (TUM), image_0/ (KITTI) nor pairs.txt (image pairs)");
  fs::create_directories(path("image_0"));
  EXPECT_EQ(complaint(), "image_0: holds no .png, .jpg or .pgm image");
  writeImage("image_0/000000.png", 1);
  writeImage("image_0/000001.png", 1);
  const std::string pose = "expected twelve numbers of a 3 x 4 pose", no_number = " is not a finite number";
  expectRefused({{"calib.txt", "P1: 1 0 0 0 0 1 0 0 0 0 1 0\n", ": has no line that starts with 'P0:'"},
                 {"calib.txt", "\nP0: 700 0 600 0 0 701\n",
                  ":2: expected P0: and twelve numbers of a 3 x 4 projection matrix, found 7 fields"},
                 {"calib.txt", "P0: 0 0 600 0 0 701 180 0 0 0 1 0\n", ":1: the focal lengths in P0 must be positive"},
                 {"poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1\n", ":2: " + pose + ", found 11 fields"},
                 {"poses.txt", "1 0 0 0 0 1 0 0 0 0 one 0\n", ":1: " + pose + ", but 'one'" + no_number},
                 {"poses.txt", "1 0 0 0 0 2 0 0 0 0 1 0\n", ":1: the left 3 x 3 part is not a rotation"},
                 {"poses.txt", "1 0 0 0 0 -1 0 0 0 0 1 0\n", ":1: the left 3 x 3 part is not a rotation"},  // a mirror
                 {"times.txt", "0.0\n", ":1: the file ends after 1 lines, but there are 2 images"},
                 {"times.txt", "0.0\nlater\n", ":2: expected one time stamp, but 'later'" + no_number}});
}

TEST_F(PairsTest, ACornerAtAnEdgeMayBelongToEitherSurface) {
  write("pairs.txt", "a.png b.png DISP=disp.png SCALE=1\n");
  cv::Mat disparity(20, 40, CV_8UC1, cv::Scalar(5));
  disparity.colRange(20, 40) = 15;
  cv::imwrite(path() + "/disp.png", disparity);
  const Dataset dataset = Dataset::open(path());
  const PairTruth truth(dataset, dataset.pairs(1, 1).front(), Camera());
  EXPECT_NEAR(*truth.transferDistance({18, 10}, {13, 10}), 0, 1e-6) << "of the left surface";
  EXPECT_NEAR(*truth.transferDistance({18, 10}, {3, 10}), 10, 1e-6);
  EXPECT_NEAR(*truth.transferDistance({18, 10}, {3, 10}, 3), 0, 1e-6) << "of the right one, two pixels beside it";
  EXPECT_NEAR(*truth.transferDistance({16, 10}, {1, 10}, 3), 10, 1e-6) << "four pixels";
  EXPECT_FALSE(truth.transferDistance({-5, 10}, {3, 10}, 3));
}

TEST_F(PairsTest, ReadsHomographyFundamentalAndDisparity) {
  write("pairs.txt",
        "# list\na.png b.png H=ab\na.png c.png F=ac\na.png d.png DISP=disp.png SCALE=4\na.png e.png ab\nb.png c.png\n");
  write("ab", "1 0 10\n0 1 20\n0 0 1\n");
  write("ac", " 0 0 0 \n0 0 -1\n0 1 0\n");
  writeImage("disp.png", 10);
  const Dataset dataset = Dataset::open(path());
  EXPECT_EQ(dataset.kind(), DatasetKind::kImagePairs);
  EXPECT_EQ(dataset.frames().size(), 5u) << "shared images are listed once";
  const auto pairs = dataset.pairs(7, 1);
  ASSERT_EQ(pairs.size(), 5u);
  EXPECT_EQ((*pairs[0].homography)(1, 2), 20);
  EXPECT_EQ((*pairs[1].fundamental)(1, 2), -1);
  EXPECT_FLOAT_EQ(dataset.disparity(pairs[2]).at<float>(1, 1), 2.5f);
  EXPECT_TRUE(pairs[3].homography) << "a bare file is a homography";
  EXPECT_FALSE(pairs[4].homography || pairs[4].fundamental || pairs[4].disparity);
  EXPECT_TRUE(dataset.disparity(pairs[4]).empty());
  EXPECT_EQ(pairs[2].reference, 0);
  EXPECT_EQ(dataset.pairs(1, 2).size(), 3u);
}

TEST_F(PairsTest, ComplainsWithFileAndLine) {
  const std::string list = "pairs.txt";
  expectRefused({{list, "# empty\n", ": lists no pair"},
                 {list, "a.png\n", ":1: expected two image paths and, optionally, H=, F= or DISP= truth"},
                 {list, "a.png b.png\na.png b.png Q=x\n", ":2: unknown key 'Q'; known are H, F, DISP and SCALE"},
                 {list, "a.png b.png SCALE=3\n", ":1: SCALE= without DISP="},
                 {list, "a.png b.png DISP=d.png SCALE=0\n", ":1: SCALE must be positive"},
                 {list, "a.png b.png DISP=d.png SCALE=x\n",
                  ":1: expected SCALE= and grey values per pixel of disparity, but 'x' is not a finite number"}});
  write(list, "a.png b.png H=h\n");
  EXPECT_EQ(complaint(), "h: cannot be opened");
  const std::string matrix = ": expected a 3 x 3 matrix, ";
  expectRefused({{"h", "1 0 0\n0 1\n", ":2: expected three numbers of a 3 x 3 matrix, found 2 fields"},
                 {"h", "1 0 0\n0 1 0\n", ":2" + matrix + "but the file ends after 2 rows"},
                 {"h", "1 0 0\n0 1 0\n0 0 1\n0 0 0\n", ":4" + matrix + "found a fourth row"}});
}

sensor_msgs::Image grayMessage(double stamp, int value) {
  std_msgs::Header header;
  header.stamp = ros::Time(stamp);
  header.frame_id = "/camera";
  return *cv_bridge::CvImage(header, "mono8", cv::Mat(4, 6, CV_8UC1, cv::Scalar(value))).toImageMsg();
}

TEST_F(BagTest, ReadsImagesCameraInfoAndTransforms) {
  {
    rosbag::Bag bag(path("set.bag"), rosbag::bagmode::Write);
    sensor_msgs::CameraInfo info;
    info.P[0] = 700;
    info.P[5] = 701;
    info.P[2] = info.P[6] = 300;
    bag.write("/cam/camera_info", ros::Time(10), info);
    for (int i = 0; i < 3; ++i) {
      // Received at the same instant: told apart by their own stamps.
      bag.write("/cam/image_raw", ros::Time(10), grayMessage(5 + 0.1 * i, 50 + i));
      tf2_msgs::TFMessage transforms;
      transforms.transforms.resize(1);
      transforms.transforms[0].header.frame_id = "/world";
      transforms.transforms[0].header.stamp = ros::Time(5 + 0.2 * i);
      transforms.transforms[0].child_frame_id = "/camera";
      transforms.transforms[0].transform.translation.x = 2.0 * i;
      transforms.transforms[0].transform.rotation.w = 1;
      bag.write("/tf", ros::Time(10), transforms);
    }
  }
  const Dataset dataset = Dataset::open(path("set.bag"));
  EXPECT_EQ(dataset.kind(), DatasetKind::kBag);
  ASSERT_EQ(dataset.frames().size(), 3u);
  EXPECT_EQ(dataset.image(1).at<uint8_t>(2, 2), 51);
  EXPECT_EQ(dataset.image(2, true).type(), CV_8UC3);
  ASSERT_TRUE(dataset.frames()[1].pose);
  EXPECT_NEAR(dataset.frames()[1].pose->translation().x(), 1.0, 1e-6);
  ASSERT_TRUE(dataset.intrinsics()) << "K is zero, so P counts";
  EXPECT_DOUBLE_EQ(dataset.intrinsics()->fy, 701);
}

TEST_F(BagTest, HasTheCalibrationThatTheNodeTakes) {
  const auto text = [this](const std::string& model, std::vector<double> D, const std::string& topic,
                           Rectified rectified = Rectified::kAuto) {
    {
      rosbag::Bag bag(path("set.bag"), rosbag::bagmode::Write);
      sensor_msgs::CameraInfo info;
      info.K[0] = info.K[4] = 500;
      info.P[0] = info.P[5] = 400;
      info.K[2] = info.K[5] = info.P[2] = info.P[6] = 300;
      info.distortion_model = model;
      info.D = D;
      info.binning_x = info.binning_y = 2;
      bag.write(topic.substr(0, topic.rfind('/')) + "/camera_info", ros::Time(10), info);
      bag.write(topic, ros::Time(10), grayMessage(5, 50));
    }
    DatasetOptions options;
    options.rectified = rectified;
    return Dataset::open(path("set.bag"), options).calibrationText();
  };
  const std::string of_p = ", P: fx 200, fy 200, cx 150, cy 150, no distortion";
  const std::string of_k = ", K and D: fx 250, fy 250, cx 150, cy 150, ";
  EXPECT_EQ(text("fisheye", {0, 0, 0, 0}, "/cam/image_raw", Rectified::kFalse),
            "calibration of /cam/camera_info" + of_k + "equidistant 0 0 0 0");
  EXPECT_EQ(text("radtan", {0, 0, 0, 0}, "/cam/image_raw"), "calibration of /cam/camera_info" + of_p);
  EXPECT_EQ(text("plumb_bob", {0.1, 0, 0, 0}, "/cam/image_rect", Rectified::kTrue),
            "calibration of /cam/camera_info" + of_p);
  EXPECT_EQ(text("plumb_bob", {0.1, 0, 0, 0}, "/cam/image_raw"),
            "calibration of /cam/camera_info" + of_k +
                "plumb_bob 0.1 0 0 0 (taken as not rectified; if they are, give --input-is-rectified true)");
  // A raw drive of kitti2bag: rectified images next to the K and D of the camera before.
  EXPECT_EQ(text("plumb_bob", {-0.37, 0.2, 0, 0, 0}, "/kitti/camera_gray_left/image_raw"),
            "calibration of /kitti/camera_gray_left/camera_info" + of_p +
                " (taken as rectified by the topic's name; if they are not, give --input-is-rectified false)");
}

TEST_F(BagTest, ADepthImageIsNoneToMatch) {
  for (const char* encoding : {"32FC1", "16UC1"}) {
    {
      rosbag::Bag bag(path("set.bag"), rosbag::bagmode::Write);
      const cv::Mat depth(4, 6, cv_bridge::getCvType(encoding), cv::Scalar(2));
      bag.write("/camera/depth/image", ros::Time(10), cv_bridge::CvImage({}, encoding, depth).toImageMsg());
    }
    DatasetOptions options;
    options.topic = "/camera/depth/image";
    const Dataset dataset = Dataset::open(path("set.bag"), options);
    try {
      dataset.image(0);
      FAIL() << encoding;
    } catch (const DatasetError& error) {
      EXPECT_EQ(error.what(), path("set.bag") + ": image 0 of /camera/depth/image: its encoding " + encoding +
                                  " is that of a depth image; choose grey or colour with --topic");
    }
  }
}

TEST_F(BagTest, ReadsEncodingsWithoutAColourFormat) {
  constexpr const char* kEncodings[] = {"8UC1", "8UC3", "8UC4", "16UC1", "mono16"};
  {
    rosbag::Bag bag(path("set.bag"), rosbag::bagmode::Write);
    for (const std::string encoding : kEncodings) {
      const int type = cv_bridge::getCvType(encoding);
      const cv::Mat pixels(4, 6, type, cv::Scalar::all(CV_MAT_DEPTH(type) == CV_16U ? 51 * 257 : 51));
      bag.write("/cam/image_raw", ros::Time(10), cv_bridge::CvImage({}, encoding, pixels).toImageMsg());
    }
  }
  const Dataset dataset = Dataset::open(path("set.bag"));
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(dataset.image(i).type(), CV_8UC1) << kEncodings[i];
    EXPECT_EQ(dataset.image(i, true).type(), CV_8UC3) << kEncodings[i];
    EXPECT_NEAR(dataset.image(i).at<uint8_t>(2, 2), i < 3 ? 51 : 128, 16) << kEncodings[i];  // plain ones mid-grey
  }
}

TEST_F(BagTest, ACompressedMosaicIsThatOfABayerCamera) {
  cv::Mat mosaic(32, 32, CV_8UC1, cv::Scalar(0));
  for (int y = 0; y < mosaic.rows; y += 2) {
    for (int x = 0; x < mosaic.cols; x += 2) mosaic.at<uint8_t>(y, x) = 200;  // all red
  }
  {
    rosbag::Bag bag(path("set.bag"), rosbag::bagmode::Write);
    sensor_msgs::CompressedImage packed;
    packed.format = "bayer_rggb8; png compressed ";
    cv::imencode(".png", mosaic, packed.data);
    bag.write("/cam/image_raw/compressed", ros::Time(10), packed);
  }
  const Dataset dataset = Dataset::open(path("set.bag"));
  EXPECT_NEAR(dataset.image(0).at<uint8_t>(16, 17), 0.299 * 200, 1) << "red as grey, at a pixel of green";
  EXPECT_EQ(dataset.image(0, true).at<cv::Vec3b>(16, 17), cv::Vec3b(0, 0, 200));
}

TEST_F(BagTest, ComplainsInASentence) {
  EXPECT_EQ(complaint("none.bag"), "none.bag: no such folder or bag");
  write("text.bag", "not a bag");
  EXPECT_EQ(complaint("text.bag").rfind("text.bag: cannot be read as a bag (", 0), 0u);
  write("file.png", "");
  EXPECT_EQ(complaint("file.png"), "file.png: is neither a folder nor a .bag file");
  { rosbag::Bag(path("empty.bag"), rosbag::bagmode::Write); }
  EXPECT_EQ(complaint("empty.bag"), "empty.bag: holds no image topic");
  {
    rosbag::Bag bag(path("two.bag"), rosbag::bagmode::Write);
    bag.write("/b/image", ros::Time(10), grayMessage(1, 1));
    bag.write("/a/image", ros::Time(10), grayMessage(1, 2));
    bag.write("/info", ros::Time(10), sensor_msgs::CameraInfo());
  }
  EXPECT_EQ(complaint("two.bag"), "two.bag: holds several image topics (/a/image, /b/image); choose one with --topic");
  DatasetOptions options;
  options.topic = "/info";
  EXPECT_EQ(complaint("two.bag", options), "two.bag: topic /info carries sensor_msgs/CameraInfo, not images");
  options.topic = "/none";
  EXPECT_EQ(complaint("two.bag", options), "two.bag: topic /none holds no image");
  options.topic = "/a/image";
  EXPECT_EQ(Dataset::open(path("two.bag"), options).image(0).at<uint8_t>(0, 0), 2);
}

TEST_F(BagTest, MayEndAnywhere) {
  {
    rosbag::Bag bag(path("set.bag"), rosbag::bagmode::Write);
    bag.write("/image", ros::Time(10), grayMessage(5, 50));
  }
  EXPECT_EQ(Dataset::open(path("set.bag")).image(0).at<uint8_t>(0, 0), 50);
  std::ifstream stream(path("set.bag"), std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  for (size_t length = 0; length < bytes.size(); length += 101) {
    write("set.bag", bytes.substr(0, length));
    EXPECT_EQ(complaint("set.bag").rfind("set.bag: cannot be read as a bag (", 0), 0u) << length;
  }
}

}  // namespace
}  // namespace gms_ransac
