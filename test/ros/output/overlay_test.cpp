// ~match_image: what its colours, words and strip say, and that they are legible at any size of image.
#include "output/overlay.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "processor_stream.h"
#include "scenes/scene.h"
#include "stream/status_text.h"

namespace gms_ransac {
namespace {

const cv::Size kVga(640, 480);
constexpr int kHeader = 50, kFooter = 50;  // rows at VGA
constexpr double kFont = 0.42;             // at VGA
const cv::Scalar kGround(28, 26, 24);      // of the footer
const std::vector<uint8_t> kStatuses = {
    MatchStats::OK,           MatchStats::FIRST_FRAME,   MatchStats::TOO_FEW_KEYPOINTS, MatchStats::TOO_FEW_MATCHES,
    MatchStats::GMS_REJECTED, MatchStats::RANSAC_FAILED, MatchStats::LOW_PARALLAX,      MatchStats::UNCALIBRATED,
    MatchStats::TIME_RESET};

/// A pair with one isolated match in each of 20 columns, moved to the right by 10 pixels; the given residuals.
struct DrawnPair {
  explicit DrawnPair(const cv::Size& size = kVga, uint8_t grey = 90) {
    for (PreparedFrame* frame : {&reference, &current}) {
      frame->image.grey = cv::Mat(size, CV_8UC1, cv::Scalar(grey));
      frame->frame.features.image_size = size;
    }
    result.status = Status::kOk;
    for (int i = 0; i < 20; ++i) {
      const cv::Point2f from((0.04F * static_cast<float>(i) + 0.1F) * static_cast<float>(size.width),
                             0.5F * static_cast<float>(size.height));
      add(from, from + cv::Point2f(10, 0), MatchStage::kInlier, 0.1F * static_cast<float>(i));
    }
    processed.status = MatchStats::OK;
    processed.text = "20 of 20 filtered matches agree on one motion";
    processed.current = current_frame;
    processed.pair = compared;
  }

  void add(const cv::Point2f& from, const cv::Point2f& to, MatchStage stage, float residual) {
    const auto i = static_cast<int>(result.raw.size());
    reference.frame.features.keypoints.emplace_back(from, 31.F);
    current.frame.features.keypoints.emplace_back(to, 31.F);
    Match match = {};
    match.reference = match.current = i;
    result.raw.push_back(match);
    if (stage == MatchStage::kRaw) return;
    result.matches.push_back(match);
    result.current_pixel.push_back(to);
    result.inlier.push_back(stage == MatchStage::kInlier);
    result.robust.judgement.probability.push_back(0.9F);
    result.robust.judgement.residual.push_back(residual);
    result.inliers += stage == MatchStage::kInlier ? 1 : 0;
  }
  cv::Mat draw(const OverlayOptions& options = {}) const {
    Overlay overlay;
    overlay.add(processed);
    return overlay.draw(processed, options);
  }

  const std::shared_ptr<PreparedFrame> current_frame = std::make_shared<PreparedFrame>();
  const std::shared_ptr<ComparedPair> compared = std::make_shared<ComparedPair>();
  PreparedFrame& current = *current_frame;
  PreparedFrame& reference = *(compared->reference = std::make_shared<PreparedFrame>());
  MatchResult& result = compared->result;
  ProcessedFrame processed;
};

cv::Scalar at(const cv::Mat& picture, const cv::Point& pixel) {
  const auto color = picture.at<cv::Vec3b>(pixel);
  return {double(color[0]), double(color[1]), double(color[2])};
}

double difference(const cv::Scalar& a, const cv::Scalar& b) {
  return std::max({std::abs(a[0] - b[0]), std::abs(a[1] - b[1]), std::abs(a[2] - b[2])});
}

/// Where the dot of a match of a VGA pair is in the picture.
cv::Point dotOf(const DrawnPair& pair, size_t match) {
  const cv::Point2f p = pair.current.frame.features.keypoints[match].pt;
  return {cvRound(p.x), cvRound(p.y) + kHeader};
}

/// Returns true if this part of the picture contains the words, as OpenCV writes them.
bool hasWords(const std::string& words, const cv::Mat& part, double scale, const cv::Scalar& color,
              const cv::Scalar& ground, int font = cv::FONT_HERSHEY_SIMPLEX) {
  int baseline;
  const int thickness = cvRound(scale / kFont);
  const cv::Size size = cv::getTextSize(words, font, scale, thickness, &baseline);
  if (size.width > part.cols) return false;
  cv::Mat expected(size.height + 2, size.width, CV_8UC3, ground), likeness;
  cv::putText(expected, words, {0, size.height}, font, scale, color, thickness, cv::LINE_AA);
  cv::matchTemplate(part, expected, likeness, cv::TM_CCOEFF_NORMED);
  double best;
  cv::minMaxLoc(likeness, nullptr, &best);
  return best > 0.97;
}

bool inHeader(const std::string& words, const cv::Mat& picture, uint8_t status, double unit = 1,
              int font = cv::FONT_HERSHEY_SIMPLEX) {
  const int rows = cvRound(kHeader * unit);
  return hasWords(words, picture.rowRange(0, rows), kFont * unit, cv::Scalar::all(0), statusColor(status), font);
}

/// Relative luminance, as WCAG defines it.
double luminance(const cv::Scalar& bgr) {
  double sum = 0;
  const double weight[3] = {0.0722, 0.7152, 0.2126};
  for (int i = 0; i < 3; ++i) {
    const double c = bgr[i] / 255;
    sum += weight[i] * (c <= 0.03928 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
  }
  return sum;
}

TEST(Overlay, ArrowsHaveTheColorOfTheirResidualInTheBarWhichFollowsTheValues) {
  for (const float factor : {1.F, 10.F}) {
    DrawnPair pair;
    for (float& residual : pair.result.robust.judgement.residual) residual *= factor;
    const cv::Mat picture = pair.draw();
    // 95 % of the residuals are below 2 sigma, or 20, which is where the bar ends.
    const cv::Mat footer = picture.rowRange(picture.rows - kFooter, picture.rows);
    EXPECT_TRUE(hasWords(factor == 1 ? "2" : "20", footer.colRange(150, 190), kFont, cv::Scalar::all(235), kGround));
    const cv::Rect bar(6, picture.rows - kFooter + 18, 178, 10);
    for (size_t i = 0; i < 20; ++i) {
      const double along = 0.05 * static_cast<double>(i);
      const cv::Point in_bar(bar.x + static_cast<int>(bar.width * along), bar.y + 5);
      EXPECT_LE(difference(at(picture, dotOf(pair, i)), at(picture, in_bar)), 8) << along;
      EXPECT_LE(difference(at(picture, dotOf(pair, i)), qualityColor(static_cast<float>(1 - along))), 4);
    }
  }
  EXPECT_GT(luminance(qualityColor(1)), 4 * luminance(qualityColor(0)));
  for (int k = 1; k <= 10; ++k) {
    EXPECT_GT(luminance(qualityColor(0.1F * static_cast<float>(k))),
              luminance(qualityColor(0.1F * static_cast<float>(k - 1))))
        << "brighter means better, whatever colours an eye sees";
  }
}

TEST(Overlay, HatchesWhatTheStreamHasLearntToLeaveOut) {
  DrawnPair pair;
  const cv::Mat plain = pair.draw();
  LearnedMask& mask = pair.result.mask = LearnedMask(kVga);
  const cv::Rect fixed(32, 24, 64, 48);
  for (const cv::Point2f cell : {cv::Point2f(33, 25), cv::Point2f(65, 25), cv::Point2f(33, 49), cv::Point2f(65, 49)}) {
    for (int n = 0; n < 6; ++n) mask.add(mask.cellOf(cell), true);
  }
  const cv::Mat picture = pair.draw();
  cv::Mat changed, lines;
  cv::inRange(picture - plain + (plain - picture), cv::Scalar::all(0), cv::Scalar::all(0), changed);
  cv::bitwise_not(changed, changed);
  EXPECT_EQ(cv::boundingRect(changed), fixed + cv::Point(0, kHeader));
  EXPECT_EQ(cv::countNonZero(changed), fixed.area());
  // Bluer than the grey image, and striped.
  cv::inRange(picture(fixed + cv::Point(0, kHeader)), cv::Scalar(100, 0, 0), cv::Scalar(255, 255, 70), lines);
  EXPECT_GT(cv::countNonZero(lines), fixed.area() / 16);
  EXPECT_LT(cv::countNonZero(lines), fixed.area() / 2);
  const cv::Scalar mean = cv::mean(picture(fixed + cv::Point(0, kHeader)));
  EXPECT_GT(mean[0], mean[2] + 40);
}

TEST(Overlay, ColorsOfTheOtherQuantities) {
  DrawnPair pair;
  std::vector<uint16_t>& lengths = pair.compared->track_lengths;
  lengths.assign(20, 2);
  lengths[3] = 10;
  lengths[4] = 10;
  pair.result.robust.judgement.probability[5] = 0.5F;
  pair.result.robust.judgement.probability[6] = 0.5F;
  const cv::Mat tracks = pair.draw({OverlayColour::kTrack, OverlayLayout::kFlow});
  EXPECT_LE(difference(at(tracks, dotOf(pair, 3)), qualityColor(1)), 4) << "long tracks are bright";
  EXPECT_LE(difference(at(tracks, dotOf(pair, 0)), qualityColor(0.2F)), 4);
  const cv::Mat probabilities = pair.draw({OverlayColour::kProbability, OverlayLayout::kFlow});
  EXPECT_LE(difference(at(probabilities, dotOf(pair, 5)), qualityColor(0)), 4);
  EXPECT_LE(difference(at(probabilities, dotOf(pair, 0)), qualityColor(0.8F)), 4);
}

TEST(Overlay, RejectedMatchesAreShownOnlyWhenAskedForOrWhenThereAreNoOthers) {
  DrawnPair pair;
  pair.add({100, 400}, {300, 400}, MatchStage::kRaw, 0);
  pair.add({100, 440}, {300, 440}, MatchStage::kGms, 9);
  const cv::Point by_filter(200, 400 + kHeader), by_model(200, 440 + kHeader);
  const cv::Scalar ground = cv::Scalar::all(90);
  cv::Mat picture = pair.draw();
  EXPECT_EQ(0, difference(at(picture, by_filter), ground));
  EXPECT_EQ(0, difference(at(picture, by_model), ground));
  for (const bool failed : {false, true}) {
    if (failed) pair.result.reject();
    picture = pair.draw({failed ? OverlayColour::kResidual : OverlayColour::kStage, OverlayLayout::kFlow});
    const cv::Scalar grey = at(picture, by_filter), model = at(picture, by_model);
    EXPECT_GT(difference(grey, ground), 40);
    EXPECT_GT(difference(model, grey), 40) << "who rejected a match is seen";
    if (!failed) {
      EXPECT_GT(difference(model, at(picture, dotOf(pair, 0))), 40);
    }
    const cv::Mat footer = picture.rowRange(picture.rows - kFooter, picture.rows);
    EXPECT_TRUE(hasWords("rejected by the filter", footer, kFont, cv::Scalar::all(235), kGround));
  }
}

TEST(Overlay, SizesOfTheLayouts) {
  EXPECT_EQ(cv::Size(640, 480 + kHeader + kFooter), DrawnPair().draw().size());
  const cv::Mat both = DrawnPair().draw({OverlayColour::kResidual, OverlayLayout::kSideBySide});
  EXPECT_EQ(1280, both.cols);
  const cv::Mat wide = DrawnPair({1226, 370}).draw({OverlayColour::kResidual, OverlayLayout::kSideBySide});
  EXPECT_EQ(1226, wide.cols) << "wide images one above the other";
  EXPECT_GT(wide.rows, 2 * 370);
  EXPECT_EQ(cv::Size(640, 480 + kHeader + kFooter), DrawnPair({320, 240}).draw().size()) << "enlarged";
  EXPECT_EQ(1280, DrawnPair({3840, 2160}).draw().cols) << "reduced";
  EXPECT_FALSE(DrawnPair({17, 3}).draw().empty());
  EXPECT_FALSE(DrawnPair({64, 480}).draw().empty()) << "a footer wider than the image";
}

TEST(Overlay, LinesOfTheSideBySideLayoutJoinBothPlaces) {
  DrawnPair pair(kVga, 90);
  const cv::Mat picture = pair.draw({OverlayColour::kStage, OverlayLayout::kSideBySide});
  const int header = cvRound(std::sqrt(2) * 35);
  const cv::Point2f to = pair.current.frame.features.keypoints[7].pt;
  EXPECT_GT(difference(at(picture, {cvRound(to.x) + 640, cvRound(to.y) + header}), cv::Scalar::all(90)), 40);
  for (int i = 0; i < 1000; ++i) pair.add({100, 100}, {110, 100}, MatchStage::kInlier, 1);
  const cv::Mat many = pair.draw({OverlayColour::kStage, OverlayLayout::kSideBySide});
  EXPECT_TRUE(hasWords("1 line of 7 drawn", many.rowRange(0, header), kFont * std::sqrt(2), cv::Scalar::all(0),
                       statusColor(MatchStats::OK)));
}

TEST(Overlay, TheHeaderSaysStatusReasonAndCounts) {
  for (const uint8_t status : kStatuses) {
    DrawnPair pair;
    pair.processed.status = status;
    pair.processed.text = "a reason in a few words; and a remark";
    const cv::Mat picture = pair.draw();
    EXPECT_TRUE(inHeader(statusName(status), picture, status, 1, cv::FONT_HERSHEY_DUPLEX)) << statusName(status);
    EXPECT_TRUE(inHeader("a reason in a few words", picture, status)) << statusName(status);
    EXPECT_FALSE(inHeader("and a remark", picture, status));
    EXPECT_TRUE(inHeader("20 matches > 20 filtered > 20 inliers", picture, status));
    EXPECT_EQ(status == MatchStats::OK, inHeader("no scale", picture, status)) << statusName(status);
    EXPECT_GT(luminance(statusColor(status)) + 0.05, 4.5 * 0.05) << "WCAG AA for black on it";
  }
  EXPECT_GT(luminance(statusColor(MatchStats::LOW_PARALLAX)), 2 * luminance(statusColor(MatchStats::OK)))
      << "told apart without colours";
  DrawnPair pair;
  pair.processed.metric_scale = true;
  pair.processed.pose.t = Eigen::Vector3d(0, 0.3, 0.4);
  EXPECT_TRUE(inHeader("0.5 m", pair.draw(), MatchStats::OK));
}

TEST(Overlay, TextStaysInTheFrameAtAnySize) {
  for (const cv::Size& size : {cv::Size(320, 240), cv::Size(3840, 2160), cv::Size(1226, 370), cv::Size(240, 320)}) {
    for (const OverlayLayout layout : {OverlayLayout::kFlow, OverlayLayout::kSideBySide}) {
      DrawnPair pair(size);
      pair.processed.status = MatchStats::LOW_PARALLAX;
      for (int i = 0; i < 40; ++i) pair.processed.text += ", and one more reason";
      const cv::Mat picture = pair.draw({OverlayColour::kResidual, layout});
      int header = 0;
      while (difference(at(picture, {picture.cols - 1, header}), statusColor(MatchStats::LOW_PARALLAX)) == 0) ++header;
      EXPECT_GT(header, 30);
      const cv::Mat right = picture(cv::Rect(picture.cols - 3, 0, 3, header));
      const cv::Mat free(right.size(), right.type(), statusColor(MatchStats::LOW_PARALLAX));
      EXPECT_EQ(0, cv::norm(right, free, cv::NORM_INF)) << size;
      // Where the whole picture is looked at in 640 columns, a line of text has at least twelve rows.
      const bool two_across = layout == OverlayLayout::kSideBySide && size.width <= 2 * size.height;
      const int lines = header * 640 > 45 * picture.cols ? 3 : 2;
      EXPECT_GE(header * 640 / picture.cols * (two_across ? 2 : 1) / lines, 9) << size;
    }
  }
}

TEST(Overlay, TheStripShowsTheLastImages) {
  DrawnPair good, lost;
  good.result.matches.resize(40);  // half of them inliers
  good.result.inlier.resize(40);
  lost.processed.status = MatchStats::GMS_REJECTED;
  lost.result.inliers = 0;
  Overlay overlay;
  for (int i = 0; i < 3; ++i) overlay.add(lost.processed);  // too long ago
  for (int i = 0; i < 100; ++i) overlay.add(lost.processed);
  for (int i = 0; i < 100; ++i) overlay.add(good.processed);
  const cv::Mat picture = overlay.draw(good.processed, {});
  const int top = picture.rows - kFooter + 4, left = 190, right = 640 - 64, middle = (left + right) / 2;
  const cv::Scalar ok = statusColor(MatchStats::OK), failed = statusColor(MatchStats::GMS_REJECTED);
  for (int x = left; x < right; x += 3) {
    const cv::Scalar status = at(picture, {x, top + 27});
    if (std::abs(x - middle) > 3) {
      EXPECT_EQ(0, difference(status, x < middle ? failed : ok)) << x;
    }
  }
  EXPECT_EQ(0, difference(at(picture, {right - 2, top + 14}), ok)) << "half of the height: half are inliers";
  EXPECT_EQ(0, difference(at(picture, {right - 2, top + 9}), kGround));
  EXPECT_EQ(0, difference(at(picture, {left + 2, top + 20}), kGround)) << "no inliers";
}

TEST(Overlay, AColourImageStaysOne) {
  const cv::Mat color(kVga, CV_8UC3, cv::Scalar(200, 60, 20));
  for (const std::string encoding : {"bgr8", "rgb8", "8UC3"}) {
    DrawnPair pair;
    pair.current.image.input.image = cv_bridge::CvImage(std_msgs::Header(), encoding, color).toImageMsg();
    cv::Scalar expected(90, 90, 90);  // the colours of 8UC3 are not known: as it was matched
    if (encoding == "bgr8") expected = cv::Scalar(200, 60, 20);
    if (encoding == "rgb8") expected = cv::Scalar(20, 60, 200);
    EXPECT_EQ(0, difference(at(pair.draw(), {5, 300}), expected)) << encoding;
  }
}

TEST(Overlay, AMaskedPartIsShadedInBlue) {
  DrawnPair pair;
  pair.current.mask = cv::Mat(kVga, CV_8UC1, cv::Scalar(255));
  pair.current.mask.colRange(320, 640) = cv::Scalar(0);
  const cv::Mat picture = pair.draw().rowRange(kHeader, kHeader + 200);  // above the arrows
  cv::Mat channels[3];
  cv::split(picture, channels);
  const cv::Mat blue = channels[0] > channels[2] + 20;
  EXPECT_EQ(cv::countNonZero(blue.colRange(0, 320)), 0);
  EXPECT_GT(cv::countNonZero(blue.colRange(320, 640)), 0.9 * 320 * 200);
}

TEST(Overlay, ResidualsOfARealPairAreInStandardDeviations) {
  const Scene scene{SceneOptions()};
  ImageStream stream(ScaleMode::kUnit, scene.intrinsics(), {});
  stream.process(scene.render(0).image);
  const ProcessedFrame processed = stream.process(scene.render(3).image);
  ASSERT_EQ(MatchStats::OK, processed.status) << processed.text;
  const RobustResult& robust = processed.pair->result.robust;
  ASSERT_EQ(robust.inlier.size(), robust.judgement.residual.size());
  double squares = 0;
  for (size_t k = 0; k < robust.inlier.size(); ++k)
    squares += robust.inlier[k] ? std::pow(robust.judgement.residual[k], 2) : 0;
  const double rms = std::sqrt(squares / robust.inlier_count);
  EXPECT_GT(rms, 0.7);
  EXPECT_LT(rms, 1.6);
  // In pixels they agree with the RMS error of the result.
  EXPECT_NEAR(rms * robust.judgement.sigma_px, robust.rms_error_px, 0.35 * robust.rms_error_px);
}

}  // namespace
}  // namespace gms_ransac
