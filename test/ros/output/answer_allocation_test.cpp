// Allocations of the node for an answer: a message's columns once each, at their length, and some short texts. Both are
// counted, and neither grows with the number of matches.
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "allocation_counter.h"
#include "gms_ransac/Correspondences.h"
#include "output/message_conversion.h"
#include "processor_stream.h"
#include "scenes/scene.h"

namespace gms_ransac {
namespace {

constexpr int kColumns = 9;  // of Correspondences; `stage`, the tenth, is empty unless rejected matches are published

/// A stream that has seen each of its images, and what is allocated when it sees them again.
class AnswerAllocation : public testing::TestWithParam<int> {
 protected:
  AnswerAllocation() {
    ProcessorOptions options;
    options.core.extractor.features = GetParam();
    const Scene scene{SceneOptions()};
    stream_ = std::make_unique<ImageStream>(ScaleMode::kUnit, scene.intrinsics(), options);
    for (int i = 0; i < kImages; ++i) images_.push_back(scene.render(i).image);
    for (int round = 0; round < 2; ++round) {
      for (const cv::Mat& image : images_) stream_->process(image);
    }
  }

  static constexpr int kImages = 4;
  std::vector<cv::Mat> images_;
  std::unique_ptr<ImageStream> stream_;
};

TEST_P(AnswerAllocation, OfCorrespondencesIsOneAColumn) {
  for (const bool with_rejected : {false, true}) {
    const ProcessedFrame processed = stream_->process(images_[with_rejected]);
    ASSERT_TRUE(processed.poseValid()) << processed.text;
    Correspondences message;
    const long before = g_allocations;
    toMessage(processed, with_rejected, message);
    EXPECT_EQ(before + kColumns + with_rejected, g_allocations);
    const size_t rows = with_rejected ? processed.pair->result.raw.size() : size_t(processed.pair->result.inliers);
    EXPECT_EQ(std::vector<size_t>(2, 2 * rows),
              (std::vector<size_t>{message.reference_points.size(), message.current_points.size()}));
    EXPECT_EQ(std::vector<size_t>(7, rows),
              (std::vector<size_t>{message.track_id.size(), message.track_length.size(), message.confidence.size(),
                                   message.distance.size(), message.probability.size(), message.reference_sigma.size(),
                                   message.current_sigma.size()}));
    EXPECT_EQ(with_rejected ? rows : 0, message.stage.size());
  }
}

TEST_P(AnswerAllocation, OfStatsIsTheTextAndTheTrackLengths) {
  const ProcessedFrame processed = stream_->process(images_[0]);
  MatchStats message;
  const long before = g_allocations;
  toMessage(processed, {}, message);
  EXPECT_EQ(before + 2, g_allocations);
}

TEST_P(AnswerAllocation, OfAnImageIsItsColumnsAndSomeShortTexts) {
  constexpr int kOwnColumns = 18;  // an answer owns those of its pair
  for (const cv::Mat& image : images_) {
    ImageWithInfo input;
    input.image = stream_->message(image);
    const long before = g_allocations;
    stream_->process(input);
    EXPECT_GE(before + kOwnColumns + 3, g_allocations);
  }
}

INSTANTIATE_TEST_SUITE_P(Features, AnswerAllocation, testing::Values(500, 2000));

}  // namespace
}  // namespace gms_ransac
