#include "output/overlay.h"

#include <algorithm>
#include <array>

#include <opencv2/imgproc.hpp>

namespace gms_ransac {

namespace {

constexpr double kBackgroundGain = 0.55;  // so that the lines stand out of a bright scene
constexpr double kMaskedGain = 0.6;
constexpr double kRejectedOpacity = 0.35;
constexpr int kSubpixelBits = 3;  // positions are drawn to 1/8 px, or slow motion would look like steps

cv::Point fixedPoint(const cv::Point2f& p) {
  return {cvRound(p.x * (1 << kSubpixelBits)), cvRound(p.y * (1 << kSubpixelBits))};
}

void drawCaption(cv::Mat& picture, const std::string& caption) {
  const double scale = std::clamp(picture.cols / 1600.0, 0.4, 1.2);
  int baseline = 0;
  const cv::Size size = cv::getTextSize(caption, cv::FONT_HERSHEY_SIMPLEX, scale, 1, &baseline);
  const int bar = std::min(picture.rows, size.height + baseline + 6);
  cv::Mat top = picture.rowRange(0, bar);
  top.convertTo(top, -1, 0.3);
  cv::putText(picture, caption, {6, size.height + 4}, cv::FONT_HERSHEY_SIMPLEX, scale, cv::Scalar(255, 255, 255), 1,
              cv::LINE_AA);
}

/// Slanted lines in dark blue, which no image and no match looks like.
void shade(const cv::Mat& mask, cv::Mat& picture) {
  constexpr int kStep = 8;  // pixels between the lines
  cv::Mat hatched;
  cv::addWeighted(picture, kMaskedGain, cv::Scalar(50, 25, 0), 1, 0, hatched);
  for (int x = -picture.rows; x < picture.cols; x += kStep) {
    cv::line(hatched, {x, picture.rows}, {x + picture.rows, 0}, cv::Scalar(120, 75, 30), 1, cv::LINE_AA);
  }
  hatched.copyTo(picture, mask == 0);
}

}  // namespace

cv::Scalar probabilityColor(float probability) {
  static const std::array<cv::Scalar, 256> table = [] {
    cv::Mat ramp(1, 256, CV_8UC1), colors;
    for (int i = 0; i < 256; ++i) ramp.at<uint8_t>(i) = static_cast<uint8_t>(i);
    cv::applyColorMap(ramp, colors, cv::COLORMAP_PLASMA);
    std::array<cv::Scalar, 256> result;
    for (int i = 0; i < 256; ++i) {
      const cv::Vec3b& color = colors.at<cv::Vec3b>(i);
      result[i] = cv::Scalar(color[0], color[1], color[2]);
    }
    return result;
  }();
  // The darkest quarter of the map would vanish on the dimmed image.
  return table[64 + cvRound(191 * std::clamp(probability, 0.f, 1.f))];
}

cv::Mat drawOverlay(const cv::Mat& grey, const cv::Mat& mask, const Frame* reference, const Frame* current,
                    const MatchResult* result, const std::string& caption) {
  cv::Mat dimmed, picture;
  grey.convertTo(dimmed, CV_8U, kBackgroundGain);
  cv::cvtColor(dimmed, picture, cv::COLOR_GRAY2BGR);
  if (!mask.empty()) shade(mask, picture);
  if (result != nullptr && reference != nullptr && current != nullptr) {
    const auto ends = [&](size_t i) {
      return std::make_pair(fixedPoint(reference->features.keypoints[result->matches[i].reference].pt),
                            fixedPoint(current->features.keypoints[result->matches[i].current].pt));
    };
    cv::Mat rejected = picture.clone();
    std::vector<size_t> inliers;
    for (size_t i = 0; i < result->matches.size(); ++i) {
      if (result->stage[i] == MatchStage::kInlier) {
        inliers.push_back(i);
        continue;
      }
      const auto [from, to] = ends(i);
      cv::line(rejected, from, to, cv::Scalar(150, 150, 150), 1, cv::LINE_AA, kSubpixelBits);
    }
    cv::addWeighted(rejected, kRejectedOpacity, picture, 1 - kRejectedOpacity, 0, picture);
    // The most probable ones last, on top.
    std::sort(inliers.begin(), inliers.end(),
              [&](size_t a, size_t b) { return result->probability[a] < result->probability[b]; });
    for (size_t i : inliers) {
      const auto [from, to] = ends(i);
      const cv::Scalar color = probabilityColor(result->probability[i]);
      cv::line(picture, from, to, color, 1, cv::LINE_AA, kSubpixelBits);
      cv::circle(picture, to, 2 << kSubpixelBits, color, cv::FILLED, cv::LINE_AA, kSubpixelBits);
    }
  }
  drawCaption(picture, caption);
  return picture;
}

}  // namespace gms_ransac
