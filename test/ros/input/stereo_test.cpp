// Two cameras: depth of keypoints against that of the rendered room, and motions in metres with a true covariance.
#include "input/stereo_depth.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>

#include <boost/make_shared.hpp>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "datasets/dataset.h"
#include "output/stereo_feature_stream.h"
#include "processor_stream.h"
#include "quantiles.h"
#include "rendered_scene.h"
#include "says.h"
#include "scenes/scene.h"
#include "shared_data.h"

namespace gms_ransac {
namespace {

constexpr double kBaseline = 0.12;
using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

SceneOptions roomOptions(double offset, const std::vector<double>& distortion) {
  SceneOptions options;
  options.offset = offset;
  options.distortion = distortion;
  return options;
}

/// The room seen by two cameras, as a calibration describes them. Their rectified cameras look `tilt` higher.
class StereoRoom {
 public:
  explicit StereoRoom(std::vector<double> distortion = {}, double tilt = 0)
      : left(roomOptions(0, distortion)), right(roomOptions(kBaseline, distortion)), tilt_(tilt) {}

  ImageWithInfo input(int frame) const {
    ImageWithInfo input;
    const double stamp = 100 + 0.1 * frame;
    input.image = imageMessage(left.render(frame).image, stamp);
    input.right = imageMessage(right.render(frame).image, stamp);
    input.camera_info = info(0);
    input.right_info = info(kBaseline);
    input.received = ros::Time(stamp);
    return input;
  }
  sensor_msgs::CameraInfoPtr info(double offset) const {
    auto message = boost::make_shared<sensor_msgs::CameraInfo>();
    const CameraIntrinsics& k = left.intrinsics();
    message->width = 640;
    message->height = 480;
    message->distortion_model = "plumb_bob";
    message->D = k.distortion;
    message->D.resize(5, 0);
    message->K = {k.fx, 0, k.cx, 0, k.fy, k.cy, 0, 0, 1};
    const RowMajor3d R(Eigen::AngleAxisd(tilt_, Eigen::Vector3d::UnitX()).toRotationMatrix());
    std::copy(R.data(), R.data() + 9, message->R.begin());
    const double f = tilt_ == 0 ? k.fx : 0.9 * k.fx;  // rectified cameras have a focal length of their own
    message->P = {f, 0, k.cx, -f * offset, 0, f, k.cy, 0, 0, 0, 1, 0};
    return message;
  }

  /// Error of the point that the right camera sees, pixels.
  double disparityError(int frame, const StereoFeature& feature) const {
    const CameraIntrinsics& k = left.intrinsics();
    const Camera camera(k, {640, 480});
    const double truth = left.depth(frame, pixelOf(camera, {feature.u0, feature.v0}));
    return k.fx * std::hypot(feature.u0 - kBaseline / truth - feature.u1, feature.v0 - feature.v1);
  }

  const Scene left, right;

 private:
  double tilt_;
};

struct StereoProcessor : Processor {
  StereoProcessor() : Processor(parameters(), {}, "left/") {}
  static Parameters parameters() {
    Parameters parameters;
    parameters.input = InputKind::kStereo;
    return parameters;
  }
};

double median(const std::vector<double>& values) { return quantilesOf(values).median; }

void expectTrueDepth(const StereoRoom& room) {
  StereoProcessor processor;
  const auto frame = processor.prepared(room.input(0));
  ASSERT_EQ(frame->depth_problem, "");
  std::vector<double> off;  // of the disparity, pixels
  int wrong = 0;
  for (int i = 0; i < frame->frame.features.size(); ++i) {
    const float depth = frame->stereo.depth[i];
    if (depth == 0) continue;
    const double truth = room.left.depth(0, frame->frame.features.keypoints[i].pt);
    off.push_back(kBaseline * room.left.intrinsics().fx * std::abs(1 / truth - 1 / depth));
    wrong += off.back() > 3;
  }
  EXPECT_GT(off.size(), 600u);
  EXPECT_LT(median(off), 0.4);
  EXPECT_LT(wrong, 0.1 * static_cast<double>(off.size()));
  ::testing::Test::RecordProperty("points", static_cast<int>(off.size()));
  ::testing::Test::RecordProperty("median_disparity_error", std::to_string(median(off)));
  ::testing::Test::RecordProperty("wrong", wrong);
}

TEST(StereoDepth, OfRectifiedImages) { expectTrueDepth(StereoRoom()); }

TEST(StereoDepth, OfImagesThatTheCalibrationRectifies) { expectTrueDepth(StereoRoom({-0.2, 0.05, 0, 0, 0}, 0.1)); }

TEST(StereoDepth, MotionsAreMetric) {
  const StereoRoom room;
  std::vector<double> errors, normalized;
  constexpr int kPairs = 6;
  for (int i = 0; i < 10 * kPairs; i += 10) {
    StereoProcessor processor;
    processor.ask(room.input(i));
    const ProcessedFrame processed = processor.ask(room.input(i + 1));
    ASSERT_EQ(processed.status, MatchStats::OK) << processed.text;
    ASSERT_TRUE(processed.metric_scale) << processed.text;
    const RelativePose truth = trueRelativePose(room.left, i, i + 1);
    errors.push_back((processed.pose.t - truth.t).norm() / truth.t.norm());
    normalized.push_back(nees(processed.pose, truth));
  }
  RecordProperty("median_error", std::to_string(median(errors)));
  RecordProperty("mean_nees", std::to_string(std::accumulate(normalized.begin(), normalized.end(), 0.) / kPairs));
  EXPECT_LT(median(errors), 0.03);
  EXPECT_LT(median(normalized), 4);
}

/// Follows what both cameras see; checks limit, rate, ids and where the right camera sees the points. `alone`: no other
/// output has a subscriber, so that the right image soon needs no keypoints.
class FollowedStereo {
 public:
  explicit FollowedStereo(bool alone) : alone_(alone) { options_.rate = 5; }

  void add(const StereoRoom& room, int image, const ImageWithInfo& input) {
    const bool right_keypoints = !alone_ || stream_.needsKeypoints();
    const ProcessedFrame processed = processor_.process(processor_.prepare(processor_.receive(input), right_keypoints));
    with_depth_ += !processed.current->stereo.depth.empty();
    metric_ = processed.metric_scale;
    text_ = processed.text;
    const auto message = stream_.next(processed, options_);
    if (!message) return;
    EXPECT_LE(message->features.size(), 220u);
    EXPECT_GT(message->features.size(), 100u);
    for (const StereoFeature& f : message->features) {
      EXPECT_TRUE(life_[f.id]++ == 0 || last_[f.id] == messages_ - 1) << "id " << f.id << " came back";
      last_[f.id] = messages_;
      off_.push_back(room.disparityError(image, f));
    }
    ++messages_;
  }

  void check(int images) const {
    EXPECT_NEAR(messages_, images / 2, 1);
    EXPECT_EQ(with_depth_, alone_ ? 2 : images - 1);
    EXPECT_EQ(metric_, !alone_) << text_;
    EXPECT_EQ(text_.find("no length: only features have a subscriber") != std::string::npos, alone_) << text_;
    EXPECT_LT(median(off_), 0.1);
    EXPECT_LT(std::count_if(off_.begin(), off_.end(), [](double e) { return e > 1; }),
              0.02 * static_cast<double>(off_.size()));
    const double mean_life = static_cast<double>(off_.size()) / static_cast<double>(life_.size());
    EXPECT_GT(mean_life, images / 5.4) << "messages";
    ::testing::Test::RecordProperty(alone_ ? "mean_life_alone" : "mean_life", std::to_string(mean_life));
  }

 private:
  const bool alone_;
  StereoProcessor processor_;
  StereoFeatureStream stream_;
  FeatureOptions options_;
  std::map<uint64_t, int> last_, life_;
  std::vector<double> off_;  ///< of the disparity, pixels
  int messages_ = 0, with_depth_ = 0;
  bool metric_ = false;  ///< the last pair
  std::string text_;
};

void expectTracks(const StereoRoom& room, int images) {
  FollowedStereo with_others(false), alone(true);
  for (int i = 0; i < images; ++i) {
    ImageWithInfo input = room.input(i);
    if (i == images / 2) input.right.reset();  // one message later, the tracks go on
    with_others.add(room, i, input);
    alone.add(room, i, input);
  }
  with_others.check(images);
  alone.check(images);
}

TEST(StereoFeatures, OfRectifiedImages) { expectTracks(StereoRoom(), 16); }

TEST(StereoFeatures, OfImagesThatTheCalibrationRectifies) {
  expectTracks(StereoRoom({-0.2, 0.05, 0, 0, 0}, 0.1), 8);  // whose rendering takes long
}

TEST(StereoDepth, SaysWhatIsMissing) {
  const StereoRoom room;
  const auto bent = room.info(kBaseline), uncalibrated = room.info(kBaseline);
  bent->D[0] = 0.1;
  bent->R[0] = 2;
  uncalibrated->K.fill(0);
  uncalibrated->P.fill(0);
  const ImageWithInfo seen = room.input(0);
  ImageWithInfo without_right = seen, without_info = seen, of_other_size = seen;
  without_right.right.reset();
  without_info.right_info.reset();
  of_other_size.right = imageMessage(cv::Mat::zeros(240, 320, CV_8UC1), 100);
  const auto with = [&](const sensor_msgs::CameraInfoPtr& right_info) {
    ImageWithInfo input = seen;
    input.right_info = right_info;
    return input;
  };
  const struct {
    ImageWithInfo input;
    std::vector<std::string> words;
  } rows[] = {
      {without_right, {"no image on right/image has its stamp"}},
      {without_info, {"right/camera_info"}},
      {with(room.info(0)), {"no distance between"}},
      {with(room.info(-0.1)), {"exchanged"}},
      {with(bent), {"no rotation"}},
      {of_other_size, {"the left image is 640x480, that on right/image 320x240"}},
      // ~camera describes one camera, and is refused: no word of it.
      {with(uncalibrated), {"right/camera_info is not calibrated (fx is 0 in K and in P); calibrate the camera"}},
      {seen, {}}};
  for (const auto& row : rows) {
    StereoProcessor processor;
    const std::string problem = processor.prepared(row.input)->depth_problem;
    EXPECT_TRUE(says(problem, row.words));
    EXPECT_EQ(problem.find("~camera"), std::string::npos);
  }
}

TEST(StereoDepth, OfARightImageThatRepeatsTheOneBeforeThereIsNone) {
  const StereoRoom room;
  StereoProcessor processor;
  const ImageWithInfo first = room.input(0);
  processor.ask(first);
  for (int i = 1; i < 4; ++i) {
    ImageWithInfo input = room.input(i);
    const auto frozen = boost::make_shared<sensor_msgs::Image>(*first.right);
    frozen->header.stamp = input.image->header.stamp;
    input.right = frozen;
    const ProcessedFrame answer = processor.ask(input);
    EXPECT_TRUE(says(answer.text, {"the right image: it is a copy of the image before it, bit for bit"}));
    EXPECT_TRUE(answer.current->stereo.depth.empty());
    EXPECT_EQ(answer.metric_scale, i == 1) << "by the depth of the first image: " << answer.text;
  }
}

TEST(StereoDepth, DoubtsBaselinesThatAreNotInMetres) {
  const StereoRoom room;
  const struct {
    double baseline;
    std::vector<std::string> words;
  } rows[] = {{kBaseline / 1000, {"put the cameras 0.00012 m apart", "P[3] of the right one must be -fx times"}},
              {kBaseline * 1000, {"put the cameras 120 m apart"}}};
  for (const auto& row : rows) {
    ImageWithInfo input = room.input(0);
    input.right_info = room.info(row.baseline);
    StereoProcessor processor;
    const ProcessedFrame answer = processor.ask(input);
    EXPECT_TRUE(says(answer.doubt, row.words)) << "beside what else is doubted";
    EXPECT_TRUE(says(answer.text, row.words));
    EXPECT_TRUE(says(answer.text, {"; doubtful: "}));
  }
  for (const auto& [baseline, doubted] :
       {std::pair(0.0099, true), std::pair(0.0101, false), std::pair(2.99, false), std::pair(3.01, true)}) {
    const CameraModel camera;
    const StereoRig rig(camera, *room.info(0), camera, *room.info(baseline));
    EXPECT_EQ(rig.problem, "");
    EXPECT_EQ(rig.doubt.find("put the cameras") != std::string::npos, doubted) << baseline << " " << rig.doubt;
  }
}

TEST(StereoDepth, DoubtsTheRightCamerasMatrix) {
  const StereoRoom room;
  ImageWithInfo input = room.input(0);
  const auto info = room.info(kBaseline);
  info->K[2] = info->P[2] = 100;
  input.right_info = info;
  StereoProcessor processor;
  EXPECT_TRUE(says(processor.prepared(input)->doubt, {"at 15.6 % of the width", "right/camera_info"}));
}

TEST(StereoDepth, SaysThatImagesAreNotRectified) {
  // Images of distorting lenses, one of which looks higher, with the calibration of rectified ones.
  const StereoRoom rectified;
  ImageWithInfo input = StereoRoom({-0.2, 0.05, 0, 0, 0}).input(0);
  input.camera_info = rectified.info(0);
  input.right_info = rectified.info(kBaseline);
  cv::Mat lower;
  const cv::Mat_<double> down = (cv::Mat_<double>(2, 3) << 1, 0, 0, 0, 1, 12);
  cv::warpAffine(rectified.right.render(0).image, lower, down, {640, 480});
  input.right = imageMessage(lower, 100);
  StereoProcessor processor;
  EXPECT_TRUE(says(processor.prepared(input)->depth_problem,
                   {"px above or below their rows on right/image: rectify both images"}));
}

/// Left and right images of a road, which may be exchanged or of different times.
class RoadStereo {
 public:
  /// `unit`: of the baseline in metres.
  explicit RoadStereo(const Dataset& set, double unit = 1) : set_(set), unit_(unit) {}

  /// Answers `count` images from `first` on, given by a function of the frame; returns the last answer's text and
  /// doubt.
  struct Answer {
    std::string text, doubt;
    int metric = 0;  ///< pairs with a length
    std::optional<LearntRig> rig;
  };
  /// `reset`: before the last two images.
  template <typename Right>
  Answer ask(const Right& right, int first = 4, int count = 3, bool reset = false) const {
    StereoProcessor processor;
    Answer answer;
    for (int i = first; i < first + count; ++i) {
      const auto [image, other] = right(i);
      ImageWithInfo input;
      input.image = imageMessage(image, 100 + 0.1 * i);
      input.right = imageMessage(other, 100 + 0.1 * i);
      input.camera_info = info(image.size(), 0);
      input.right_info = info(image.size(), unit_ * set_.rightCamera()->baseline);
      input.received = ros::Time(100 + 0.1 * i);
      if (reset && i == first + count - 2) processor.requestReset();
      const ProcessedFrame processed = processor.ask(input);
      answer.rig = processed.rig;
      answer.text = processed.text;
      answer.doubt = processed.doubt;
      answer.metric += processed.metric_scale;
    }
    return answer;
  }
  cv::Mat left(int i) const { return set_.image(i); }
  cv::Mat right(int i) const { return set_.right(i); }

 private:
  sensor_msgs::CameraInfoPtr info(cv::Size size, double offset) const {
    auto message = boost::make_shared<sensor_msgs::CameraInfo>();
    const CameraIntrinsics& k = *set_.intrinsics();
    message->width = static_cast<uint32_t>(size.width);
    message->height = static_cast<uint32_t>(size.height);
    message->distortion_model = "plumb_bob";
    message->D.assign(5, 0);
    message->K = {k.fx, 0, k.cx, 0, k.fy, k.cy, 0, 0, 1};
    message->P = {k.fx, 0, k.cx, -k.fx * offset, 0, k.fy, k.cy, 0, 0, 0, 1, 0};
    return message;
  }
  const Dataset& set_;
  const double unit_;
};

using Images = std::pair<cv::Mat, cv::Mat>;

TEST(StereoRoad, CamerasThatAreNotExposedTogetherGiveNoLength) {
  OPEN_OR_SKIP(set, "kitti_06");
  const RoadStereo road(*set);
  const auto good = road.ask([&](int i) { return Images(road.left(i), road.right(i)); });
  EXPECT_EQ(good.doubt, "") << good.doubt;
  EXPECT_EQ(good.metric, 2);
  for (const int late : {1, -1}) {
    for (const int first : {4, 13, 30}) {
      const auto apart = road.ask([&](int i) { return Images(road.left(i), road.right(i + late)); }, first);
      EXPECT_TRUE(says(apart.doubt, {"expose both cameras at the same time"})) << late << " from " << first;
      EXPECT_TRUE(says(apart.text, {"no length: points of the left image lie"}));
      EXPECT_EQ(apart.metric, 0);
    }
  }
}

TEST(StereoRoad, LearnsWhatItsCalibrationLeaves) {
  OPEN_OR_SKIP(set, "kitti_06");
  const RoadStereo road(*set);
  const cv::Mat_<double> farther = (cv::Mat_<double>(2, 3) << 1, 0, 1.5, 0, 1, 0);  // disparities too small
  const auto shifted = [&](int i) {
    cv::Mat right;
    cv::warpAffine(road.right(i), right, farther, road.left(i).size(), cv::INTER_CUBIC);
    return Images(road.left(i), right);
  };
  const auto as_it_is = road.ask([&](int i) { return Images(road.left(i), road.right(i)); }, 0, 32);
  const auto wrong = road.ask(shifted, 0, 32), reset = road.ask(shifted, 0, 32, true);
  ASSERT_TRUE(as_it_is.rig && wrong.rig && reset.rig);
  EXPECT_TRUE(wrong.rig->isOff());
  EXPECT_LT(wrong.rig->deviation()[0], 0.3);
  EXPECT_NEAR(wrong.rig->mean()[0] - as_it_is.rig->mean()[0], 1.5, 0.3);
  EXPECT_TRUE(reset.rig->mean().isZero()) << reset.rig->mean().transpose();
}

TEST(StereoRoad, RowsThatAreOffGiveNoLength) {
  OPEN_OR_SKIP(set, "kitti_06");
  const RoadStereo road(*set);
  for (const int down : {-20, -3, 3, 6}) {
    const auto lower = [&](const cv::Mat& image) {
      cv::Mat moved;
      const cv::Mat_<double> motion = (cv::Mat_<double>(2, 3) << 1, 0, 0, 0, 1, down);
      cv::warpAffine(image, moved, motion, image.size());
      return moved;
    };
    const auto off = road.ask([&](int i) { return Images(road.left(i), lower(road.right(i))); });
    EXPECT_TRUE(says(off.doubt, {"px above or below their rows on right/image: rectify both images"})) << down;
    EXPECT_EQ(off.metric, 0) << down;
  }
}

TEST(StereoRoad, TheSameImageTwiceAndExchangedImagesAreNamed) {
  OPEN_OR_SKIP(set, "kitti_06");
  const RoadStereo road(*set);
  const auto same = road.ask([&](int i) { return Images(road.left(i), road.left(i)); });
  EXPECT_TRUE(says(same.doubt, {"without disparity: remap left and right to two cameras"}));
  EXPECT_EQ(same.text.find("doubtful"), std::string::npos) << same.text << ": once is enough";
  const auto exchanged = road.ask([&](int i) { return Images(road.right(i), road.left(i)); });
  EXPECT_TRUE(says(exchanged.doubt, {"left and right are exchanged"}));
}

TEST(StereoRoad, ABaselineInMillimetresIsDoubted) {
  OPEN_OR_SKIP(set, "kitti_06");
  const RoadStereo road(*set, 1000);
  const auto answer = road.ask([&](int i) { return Images(road.left(i), road.right(i)); });
  EXPECT_TRUE(says(answer.text, {"doubtful: the camera_infos put the cameras 537 m apart"}));
  EXPECT_EQ(answer.metric, 2) << "its user may have another unit in mind";
}

}  // namespace
}  // namespace gms_ransac
