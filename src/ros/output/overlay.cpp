#include "output/overlay.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <cv_bridge/cv_bridge.h>
#include <sensor_msgs/image_encodings.h>
#include <opencv2/imgproc.hpp>

#include "stream/status_text.h"

namespace gms_ransac {

namespace {

constexpr double kStandardArea = 640 * 480;  // text and lines are sized for a picture of this many pixels
constexpr double kLargestArea = 1280 * 960;
constexpr double kWide = 900;                       // from this width on, in units, one line of header text suffices
constexpr double kFont = 0.42;                      // of OpenCV's, for a unit of 1
constexpr double kLegend = 190, kStripLabels = 64;  // widths in the footer, units
constexpr double kNarrowest = 300;                  // of the picture, units: room for both and some of the strip
constexpr int kSubpixelBits = 3;                    // slow motion would look like steps if positions were whole pixels
constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
const cv::Scalar kNoPixels(96, 96, 96);  // behind keypoints that came without an image
const cv::Scalar kDark(28, 26, 24), kLight(235, 235, 235), kGrey(150, 150, 150);
// Indexed by MatchStage. The last is also for inliers without a value.
const std::array<cv::Scalar, 3> kStageColors = {kGrey, cv::Scalar(0, 94, 213), cv::Scalar(233, 180, 86)};
constexpr size_t kMostLines = 150;  // side by side
constexpr float kDrawnFirst = 4;    // less the stage: rank of a rejected match, above every quality

/// The least of 1, 1.5, 2, 3, 5, 7 and their multiples by powers of ten that is not below x.
float roundUp(float x) {
  if (!(x > 0 && std::isfinite(x))) return 1;
  const float power = std::pow(10.f, std::floor(std::log10(x)));
  for (const float step : {1.f, 1.5f, 2.f, 3.f, 5.f, 7.f}) {
    if (x <= 1.0001f * step * power) return step * power;
  }
  return 10 * power;
}

/// Quantity that the colour of an arrow shows. Without values: the stage of the match.
struct Quantity {
  std::string name;  ///< with its unit
  float anchor;      ///< the fixed end of the scale
  float reach;       ///< from there to the other end, negative where that is lower
  bool anchor_is_good;
  std::vector<float> values;  ///< one a match, or none; not finite: not known

  /// 0 poor .. 1 good; 2: not known.
  float quality(size_t row) const {
    if (values.empty() || !std::isfinite(values[row])) return 2;
    const float away = std::clamp((values[row] - anchor) / reach, 0.f, 1.f);
    return anchor_is_good ? 1 - away : away;
  }
};

/// `reach` has its sign alone.
Quantity measure(const ProcessedFrame& processed, OverlayColour colour) {
  const MatchResult& result = processed.pair->result;
  if (colour == OverlayColour::kStage) return {};
  const std::vector<float> unknown(result.matches.size(), kUnknown);
  if (colour == OverlayColour::kProbability) {
    Quantity probability = {"probability", 1, -1, true, result.robust.judgement.probability};
    probability.values.resize(result.matches.size(), 0);  // without a model there are none
    return probability;
  }
  if (colour == OverlayColour::kTrack) {
    const auto& lengths = processed.pair->track_lengths;
    return {"track length, images", 0, 1, false,
            lengths.empty() ? unknown : std::vector<float>(lengths.begin(), lengths.end())};
  }
  if (colour == OverlayColour::kDepth) {
    Quantity depth = {processed.metric_scale ? "depth, metres" : "depth, baselines", 0, 1, true, unknown};
    if (processed.status != MatchStats::OK || !processed.pair->triangulated) return depth;
    const Triangulation& points = processed.pair->points;
    for (int i = 0; i < points.size(); ++i) {
      if (points.valid[i]) depth.values[points.row[i]] = points.depth_current[i] * processed.pose.t.norm();
    }
    return depth;
  }
  return {cv::format("residual, sigma = %.2g px", result.robust.judgement.sigma_px), 0, 1, true,
          result.robust.judgement.residual.empty() ? unknown : result.robust.judgement.residual};
}

/// Stretches the scale over the values of the inliers but for the most extreme twentieth.
void stretch(const MatchResult& result, Quantity& quantity) {
  std::vector<float> away;
  for (size_t row = 0; row < quantity.values.size(); ++row) {
    const float value = quantity.values[row];
    if (result.isInlier(row) && std::isfinite(value)) away.push_back(std::abs(value - quantity.anchor));
  }
  if (away.empty()) return;
  const auto extreme = away.begin() + static_cast<std::ptrdiff_t>(0.95 * static_cast<double>(away.size() - 1));
  std::nth_element(away.begin(), extreme, away.end());
  quantity.reach *= roundUp(*extreme);
}

/// Fills `panel` with the image as it was received, in colour or grey.
void drawImage(const PreparedFrame& frame, cv::Mat panel) {
  if (frame.image.input.keypoints) panel = kNoPixels;
  cv::Mat image = receivedColours(frame);
  if (image.empty()) return;  // a reference from before a loss, whose pixels are gone
  const int filter = panel.cols < image.cols ? cv::INTER_AREA : cv::INTER_LINEAR;
  if (image.channels() == 3) return cv::resize(image, panel, panel.size(), 0, 0, filter);
  cv::resize(image, image, panel.size(), 0, 0, filter);
  cv::cvtColor(image, panel, cv::COLOR_GRAY2BGR);
}

/// Slanted lines in dark blue, which no image and no match looks like.
void hatch(const cv::Mat& mask, cv::Mat picture) {
  constexpr int kStep = 8;  // pixels between the lines
  cv::Mat hatched, free;
  cv::addWeighted(picture, 0.5, cv::Scalar(50, 25, 0), 1, 0, hatched);
  for (int x = -picture.rows; x < picture.cols; x += kStep) {
    cv::line(hatched, {x, picture.rows}, {x + picture.rows, 0}, cv::Scalar(120, 75, 30), 1, cv::LINE_AA);
  }
  cv::resize(mask, free, picture.size(), 0, 0, cv::INTER_NEAREST);
  hatched.copyTo(picture, free == 0);
}

/// One picture in the making. Lengths in units are pixels of a VGA picture, and larger on a larger one.
class Painter {
 public:
  Painter(const ProcessedFrame& processed, OverlayLayout layout) : processed_(processed) {
    const cv::Size image = processed.current->imageSize();
    const double area = image.area();
    const double enlarge = std::round(std::sqrt(kStandardArea / area));
    const double zoom = enlarge > 1 ? enlarge : 1 / std::ceil(std::sqrt(area / kLargestArea));
    const cv::Size panel(std::max(1, cvRound(zoom * image.width)), std::max(1, cvRound(zoom * image.height)));
    // Wide images one above the other, as in papers.
    const bool two = layout == OverlayLayout::kSideBySide, above = panel.width > 2 * panel.height;
    const cv::Size both(panel.width * (two && !above ? 2 : 1), panel.height * (two && above ? 2 : 1));
    unit_ = std::sqrt(both.area() / kStandardArea);
    const int width = std::max(both.width, px(kNarrowest));
    header_ = cv::Rect(0, 0, width, px(width < kWide * unit_ ? 50 : 35));
    reference_ = cv::Rect({0, header_.height}, panel);
    current_ = reference_ + cv::Point(both.width - panel.width, both.height - panel.height);
    footer_ = cv::Rect(0, current_.br().y, width, px(50));
    canvas_.create(footer_.br().y, width, CV_8UC3);
    if (width > both.width) canvas_ = kDark;
    canvas_(footer_) = kDark;
  }

  const cv::Mat& canvas() const { return canvas_; }
  void paintImages() {
    if (reference_ != current_) {
      canvas_(reference_) = kDark;
      if (processed_.pair != nullptr) drawImage(*processed_.pair->reference, canvas_(reference_));
    }
    drawImage(*processed_.current, canvas_(current_));
    if (!processed_.current->mask.empty()) hatch(processed_.current->mask, canvas_(current_));
    if (processed_.pair == nullptr) return;
    const LearnedMask& mask = processed_.pair->result.mask;
    if (!mask.empty()) hatch(mask.toImage(), canvas_(current_));
  }

  void paintMatches(OverlayColour colour) {
    const MatchResult& result = processed_.pair->result;
    Quantity quantity = measure(processed_, result.inliers == 0 ? OverlayColour::kStage : colour);
    stretch(result, quantity);
    const bool stages = quantity.values.empty();
    // Poor ones last, on top; rejected ones first.
    std::vector<std::pair<float, const Match*>> order;
    result.forEachRaw([&](const Match& match, MatchStage stage, size_t row) {
      if (stage == MatchStage::kInlier) {
        order.emplace_back(quantity.quality(row), &match);
      } else if (stages) {
        order.emplace_back(kDrawnFirst - static_cast<float>(stage), &match);
      }
    });
    std::sort(order.rbegin(), order.rend());
    if (reference_ != current_) step_ += order.size() / kMostLines;
    for (size_t k = step_ / 2; k < order.size(); k += step_) {
      const auto [quality, match] = order[k];
      arrow(*match, quality > 1 ? kStageColors[static_cast<size_t>(kDrawnFirst - quality)] : qualityColor(quality),
            quality < kDrawnFirst);
    }
    if (stages) {
      stageKey();
    } else {
      colorBar(quantity);
    }
  }

  void paintHeader() {
    canvas_(header_) = statusColor(processed_.publishedStatus());
    const int left = px(6), width = header_.width - 2 * left;
    const std::string name = statusName(processed_.publishedStatus());
    write(name, {left, px(13)}, width, cv::Scalar::all(0), cv::FONT_HERSHEY_DUPLEX);
    if (processed_.pair != nullptr) {
      const MatchResult& result = processed_.pair->result;
      std::string counts = cv::format("%zu matches > %d filtered > %d inliers   %.1f ms", result.raw.size(),
                                      result.size(), result.inliers, 1e3 * result.times.total());
      if (processed_.status == MatchStats::OK) {
        counts += processed_.metric_scale ? cv::format("   %.3g m", processed_.pose.t.norm()) : "   no scale";
      }
      if (step_ > 1) counts += cv::format("   1 line of %zu drawn", step_);
      const int start = left + textWidth(name) + px(14);
      write(counts, {start, px(13)}, header_.width - left - start, cv::Scalar::all(0));
    }
    // The first clause, broken between words where the line is full.
    std::string text = processed_.text.substr(0, processed_.text.find(';'));
    for (int y = px(28); y < header_.height && !text.empty(); y += px(15)) {
      size_t end = text.size();
      while (y + px(15) < header_.height && textWidth(text.substr(0, end)) > width) {
        const size_t space = text.rfind(' ', end - 1);
        if (space == std::string::npos || space == 0) break;
        end = space;
      }
      write(text.substr(0, end), {left, y}, width, cv::Scalar::all(0));
      text.erase(0, end + 1);
    }
  }

  /// A strip of 1 pixel an image, stretched; `highest`: what the top of the milliseconds stands for.
  void paintStrip(const cv::Mat& strip, double highest) {
    const cv::Rect place(px(kLegend), footer_.y + px(4), footer_.width - px(kLegend + kStripLabels), px(42));
    cv::resize(strip, canvas_(place), place.size(), 0, 0, cv::INTER_NEAREST);
    const int x = place.br().x + px(4);
    write("100 %", {x, place.y + px(9)}, px(kStripLabels - 6), kLight);
    write("inliers", {x, place.y + px(21)}, px(kStripLabels - 6), kLight);
    write(cv::format("%g ms", highest), {x, place.br().y - px(3)}, px(kStripLabels - 6), kLight);
  }

 private:
  int px(double units) const { return cvRound(units * unit_); }
  /// A keypoint in a panel, in fixed point.
  cv::Point placed(const Features& features, int keypoint, const cv::Rect& panel) const {
    const cv::Point2f pixel = features.keypoints[keypoint].pt;
    const auto fixed = [](int start, int length, float at, int size) {
      return cvRound((start + (at + 0.5) * length / size - 0.5) * (1 << kSubpixelBits));
    };
    return {fixed(panel.x, panel.width, pixel.x, features.image_size.width),
            fixed(panel.y, panel.height, pixel.y, features.image_size.height)};
  }

  void arrow(const Match& match, const cv::Scalar& color, bool cased) {
    const cv::Point from = placed(processed_.pair->reference->frame.features, match.reference, reference_);
    const cv::Point to = placed(processed_.current->frame.features, match.current, current_);
    if (cased) cv::line(canvas_, from, to, 0.4 * color, px(1) + 2, cv::LINE_8, kSubpixelBits);
    cv::line(canvas_, from, to, color, px(1), cv::LINE_AA, kSubpixelBits);
    if (cased) cv::circle(canvas_, to, px(2 << kSubpixelBits), color, cv::FILLED, cv::LINE_AA, kSubpixelBits);
  }

  void colorBar(const Quantity& quantity) {
    const cv::Rect bar(px(6), footer_.y + px(18), px(kLegend - 12), px(10));
    const float other = quantity.anchor + quantity.reach;
    const float low = std::min(quantity.anchor, other), high = std::max(quantity.anchor, other);
    for (int x = 0; x < bar.width; ++x) {
      const float along = static_cast<float>(x) / static_cast<float>(bar.width);
      canvas_(cv::Rect(bar.x + x, bar.y, 1, bar.height)) =
          qualityColor(quantity.anchor_is_good == (low == quantity.anchor) ? 1 - along : along);
    }
    write(quantity.name, {bar.x, footer_.y + px(13)}, bar.width, kLight);
    for (const float at : {0.f, 0.5f, 1.f}) {
      const std::string number = cv::format("%.4g", low + at * (high - low));
      const int width = textWidth(number);
      write(number, {bar.x + cvRound(at * static_cast<float>(bar.width - width)), footer_.y + px(43)}, width, kLight);
    }
  }

  void stageKey() {
    const std::array<const char*, 3> words = {"rejected by the filter", "rejected by the model", "inlier"};
    for (size_t stage = 0; stage < words.size(); ++stage) {
      const int y = footer_.y + px(43 - 15 * static_cast<double>(stage));
      cv::line(canvas_, {px(6), y - px(4)}, {px(20), y - px(4)}, kStageColors[stage], px(3));
      write(words[stage], {px(26), y}, px(kLegend - 30), kLight);
    }
  }

  int textWidth(const std::string& text) const {
    int baseline;
    return cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, kFont * unit_, px(1), &baseline).width;
  }

  /// Draws what fits in `width` pixels; `baseline` is the left end.
  void write(std::string text, const cv::Point& baseline, int width, const cv::Scalar& color,
             int font = cv::FONT_HERSHEY_SIMPLEX) {
    if (textWidth(text) > width) {
      while (!text.empty() && textWidth(text + "...") > width) text.pop_back();
      text += "...";
    }
    cv::putText(canvas_, text, baseline, font, kFont * unit_, color, px(1), cv::LINE_AA);
  }

  const ProcessedFrame& processed_;
  double unit_;
  cv::Rect header_, reference_, current_, footer_;  ///< the two are one without a panel for the reference
  size_t step_ = 1;                                 ///< one match of so many is drawn
  cv::Mat canvas_;
};

}  // namespace

cv::Mat receivedColours(const PreparedFrame& frame) {
  namespace encodings = sensor_msgs::image_encodings;
  const auto& message = frame.image.input.image;
  const auto has_colour = [](const std::string& encoding) {
    return encodings::bitDepth(encoding) == 8 && (encodings::numChannels(encoding) > 1 || encodings::isBayer(encoding));
  };
  try {
    if (!frame.image.grey.empty() && message && has_colour(message->encoding)) {
      return cv_bridge::toCvShare(message, encodings::BGR8)->image;
    }
  } catch (const std::runtime_error&) {  // an encoding or channels of no known colour: as they were matched, grey
  }
  return frame.image.grey;
}

cv::Scalar qualityColor(float quality) {
  static const cv::Mat colors = [] {
    cv::Mat ramp(1, 256, CV_8UC1), map;
    for (int i = 0; i < 256; ++i) ramp.at<uint8_t>(i) = static_cast<uint8_t>(i);
    cv::applyColorMap(ramp, map, cv::COLORMAP_PLASMA);
    return map;
  }();
  // The darkest fifth would vanish on a dark image.
  return colors.at<cv::Vec3b>(51 + cvRound(204 * std::clamp(quality, 0.f, 1.f)));
}

cv::Scalar statusColor(uint8_t status) {
  switch (status) {
    case MatchStats::OK:
      return {115, 158, 0};  // green
    case MatchStats::RECOVERED:
      return {167, 121, 204};  // purple
    case MatchStats::LOW_PARALLAX:
      return {66, 228, 240};  // yellow
    case MatchStats::MOTION_UNKNOWN:
      return {0, 159, 230};  // orange
    case MatchStats::UNCALIBRATED:
      return {233, 180, 86};  // sky blue
    case MatchStats::FIRST_FRAME:
    case MatchStats::TIME_RESET:
      return {190, 190, 190};
    default:
      return {0, 110, 230};  // vermilion
  }
}

void Overlay::add(const ProcessedFrame& processed) {
  Outcome outcome = {processed.publishedStatus(), 0, 0};
  if (processed.pair != nullptr) {
    const MatchResult& result = processed.pair->result;
    outcome.inlier_ratio = static_cast<float>(result.inliers) / static_cast<float>(std::max(1, result.size()));
    outcome.milliseconds = static_cast<float>(1e3 * processed.times.total());
  }
  history_.push_back(outcome);
  if (history_.size() > kHistory) history_.pop_front();
}

cv::Mat Overlay::draw(const ProcessedFrame& processed, const OverlayOptions& options) const {
  float slowest = 0;
  for (const Outcome& outcome : history_) slowest = std::max(slowest, outcome.milliseconds);
  const float highest = roundUp(slowest);
  constexpr int kRatio = 24, kStatus = 6, kRows = 42;  // rows: inlier ratio, status, milliseconds
  cv::Mat strip(kRows, static_cast<int>(kHistory), CV_8UC3, kDark);
  int x = strip.cols - static_cast<int>(history_.size());
  for (const Outcome& outcome : history_) {
    cv::Mat column = strip.col(x++);
    const cv::Scalar color = statusColor(outcome.status);
    column.rowRange(cvRound(kRatio * (1 - outcome.inlier_ratio)), kRatio) = color;
    column.rowRange(kRatio + 1, kRatio + kStatus) = color;
    column.rowRange(kRows - cvRound((kRows - kRatio - kStatus - 1) * outcome.milliseconds / highest), kRows) = kGrey;
  }
  Painter painter(processed, options.layout);
  painter.paintImages();
  painter.paintStrip(strip, highest);
  if (processed.pair != nullptr) painter.paintMatches(options.colour);
  painter.paintHeader();
  return painter.canvas();
}

}  // namespace gms_ransac
