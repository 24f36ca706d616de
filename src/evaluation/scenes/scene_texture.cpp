#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "scenes/scene_layout.h"

namespace gms_ransac {

namespace {

constexpr int kSubpixelBits = 4;  // of the drawing functions' fixed-point coordinates
constexpr int kSubpixel = 1 << kSubpixelBits;

/// Paints one texture; lengths are in metres.
class Painter {
 public:
  Painter(cv::Mat_<uint8_t>& image, double texel, uint64_t seed) : image_(image), texel_(texel), rng_(seed) {}

  void paint(TextureStyle style) {
    switch (style) {
      case TextureStyle::kBricks:
        bricks(0.24, 0.08, 0.012);
        return grain(0.02, 3, 14);
      case TextureStyle::kPlanks:
        bricks(1.4, 0.14, 0.006);
        scratches(12, 0.3);
        return grain(0.04, 3, 16);
      case TextureStyle::kPictures:
        fill(170);
        grain(1.2, 7, 34);
        return pictures();
      case TextureStyle::kShelves:
        shelves();
        return grain(0.03, 3, 10);
      case TextureStyle::kStones:
        fill(110);
        leaves(bounds(), 0.012, 0.12, 1.0, 45, 120);
        return grain(0.6, 6, 20);
      case TextureStyle::kFacade:
        bricks(0.5, 0.2, 0.02);
        windows();
        return grain(0.5, 5, 16);
      case TextureStyle::kCollage:
        fill(120);
        leaves(bounds(), 0.015, 0.35, 1.6, 90, 128);
        return grain(0.05, 3, 12);
      case TextureStyle::kPlaster:
        fill(190);
        grain(1.5, 8, 40);
        return leaves(bounds(), 0.01, 0.06, 0.06, 70, 120);
    }
  }

 private:
  cv::Rect2d bounds() const { return {0, 0, image_.cols * texel_, image_.rows * texel_}; }
  double uniform(double low, double high) { return rng_.uniform(low, high); }
  /// A grey level around `mean`, never saturated so that noise and shading keep their room.
  double tone(double mean, double spread) { return std::clamp(mean + rng_.gaussian(spread), 12.0, 243.0); }
  void fill(double grey) { image_.setTo(grey); }

  void polygon(const std::vector<cv::Point2d>& corners, double grey) {
    fixed_.clear();
    for (const cv::Point2d& p : corners) {
      fixed_.emplace_back(cvRound(p.x / texel_ * kSubpixel), cvRound(p.y / texel_ * kSubpixel));
    }
    cv::fillConvexPoly(image_, fixed_, cv::Scalar(grey), cv::LINE_AA, kSubpixelBits);
  }

  void rectangle(const cv::Rect2d& r, double grey) {
    polygon({r.tl(), {r.x + r.width, r.y}, r.br(), {r.x, r.y + r.height}}, grey);
  }

  /// Adds `octaves` layers of smooth noise, the coarsest with cells of `cell` metres, each half as large and 0.7
  /// times as strong as the one before.
  void grain(double cell, int octaves, double amplitude) {
    cv::Mat_<float> sum = image_;
    for (int i = 0; i < octaves; ++i, cell /= 2, amplitude *= 0.7) {
      const double cell_px = std::max(1.0, cell / texel_);
      cv::Mat_<float> coarse(cvCeil(image_.rows / cell_px) + 1, cvCeil(image_.cols / cell_px) + 1), fine;
      rng_.fill(coarse, cv::RNG::UNIFORM, -amplitude, amplitude);
      cv::resize(coarse, fine, image_.size(), 0, 0, cv::INTER_CUBIC);
      sum += fine;
    }
    sum.convertTo(image_, CV_8U);
  }

  /// Dead leaves: shapes of power-law size that cover each other, which gives edges and corners the scale statistics
  /// of natural images (Lee, Mumford and Huang 2001). `coverage` is the area drawn over the area of `roi`.
  void leaves(const cv::Rect2d& roi, double smallest, double largest, double coverage, double contrast, double mean) {
    const double roi_area = roi.area();
    for (double area = 0; area < coverage * roi_area;) {
      // Density proportional to radius^-3 between the bounds.
      const double a = 1 / (smallest * smallest), b = 1 / (largest * largest);
      const double radius = 1 / std::sqrt(a - uniform(0, 1) * (a - b));
      const cv::Point2d centre(uniform(roi.x, roi.x + roi.width), uniform(roi.y, roi.y + roi.height));
      const int corners = rng_.uniform(3, 7);
      const double turn = uniform(0, CV_2PI), squeeze = uniform(0.4, 1.0), c = std::cos(turn), s = std::sin(turn);
      std::vector<cv::Point2d> outline;
      for (int k = 0; k < corners; ++k) {
        const double angle = CV_2PI * (k + uniform(-0.2, 0.2)) / corners;
        const double x = radius * std::cos(angle), y = squeeze * radius * std::sin(angle);
        outline.emplace_back(std::clamp(centre.x + x * c - y * s, roi.x, roi.x + roi.width),
                             std::clamp(centre.y + x * s + y * c, roi.y, roi.y + roi.height));
      }
      polygon(outline, tone(mean, contrast));
      area += 2 * squeeze * radius * radius;
    }
  }

  /// Rows of blocks with joints, each row shifted and every block of its own tone and length.
  void bricks(double length, double height, double joint) {
    fill(95);
    const cv::Rect2d all = bounds();
    for (double y = 0; y < all.height; y += height) {
      for (double x = -uniform(0, length); x < all.width;) {
        const double l = length * uniform(0.7, 1.3);
        rectangle({x + joint / 2, y + joint / 2, l - joint, height - joint}, tone(140, 28));
        x += l;
      }
    }
  }

  void scratches(double per_square_metre, double longest) {
    const cv::Rect2d all = bounds();
    for (int i = 0; i < per_square_metre * all.area(); ++i) {
      const cv::Point2d p(uniform(0, all.width), uniform(0, all.height));
      const double angle = uniform(0, CV_PI), length = uniform(0.02, longest), width = uniform(0.004, 0.02);
      const cv::Point2d along(length * std::cos(angle), length * std::sin(angle));
      const cv::Point2d across(-width * std::sin(angle), width * std::cos(angle));
      polygon({p, p + along, p + along + across, p + across}, tone(110, 50));
    }
  }

  /// Framed pictures and notices hung side by side, at the height of the eyes and above.
  void pictures() {
    const cv::Rect2d all = bounds();
    for (double y = 0.25; y + 0.5 < all.height; y += 1.05) {
      for (double x = uniform(0.1, 0.4); x + 0.4 < all.width;) {
        const double w = uniform(0.45, 1.1), h = uniform(0.55, 0.95);
        rectangle({x, y, w, h}, tone(60, 25));
        const cv::Rect2d inside(x + 0.03, y + 0.03, w - 0.06, h - 0.06);
        rectangle(inside, tone(200, 25));
        leaves(inside, 0.012, 0.2, uniform(0.5, 1.8), 70, uniform(90, 160));
        x += w + uniform(0.1, 0.35);
      }
    }
  }

  /// Boards with books: upright spines of many widths, heights and tones, with a label on most.
  void shelves() {
    fill(45);
    const cv::Rect2d all = bounds();
    const double row = 0.36;
    for (double y = 0; y < all.height; y += row) {
      rectangle({0, y, all.width, 0.03}, tone(130, 12));
      for (double x = 0.02; x < all.width;) {
        const double w = uniform(0.02, 0.07), h = uniform(0.2, row - 0.05);
        if (uniform(0, 1) < 0.92) {
          const double grey = tone(130, 50);
          rectangle({x, y + row - h, w, h}, grey);
          const double label = uniform(0.15, 0.6) * h;
          rectangle({x + 0.15 * w, y + row - h + uniform(0.1, 0.3) * h, 0.7 * w, 0.3 * label}, tone(255 - grey, 35));
        }
        x += w + uniform(0.001, 0.006);
      }
    }
  }

  /// Windows with curtains or reflections in them, in floors.
  void windows() {
    const cv::Rect2d all = bounds();
    for (double y = 0.7; y + 1.2 < all.height; y += 2.6) {
      for (double x = uniform(0.3, 1.2); x + 1.0 < all.width;) {
        const double w = uniform(0.8, 1.6), h = uniform(1.1, 1.7);
        rectangle({x - 0.08, y - 0.08, w + 0.16, h + 0.16}, tone(200, 20));
        rectangle({x, y, w, h}, tone(60, 25));
        leaves({x, y, w, h}, 0.05, 0.5, 0.8, 55, uniform(50, 130));
        rectangle({x + w / 2 - 0.03, y, 0.06, h}, tone(205, 15));
        x += w + uniform(0.6, 1.8);
        if (uniform(0, 1) < 0.4) {  // a sign between two windows
          const cv::Rect2d sign(x - 0.5, y + uniform(0, 0.6), 0.4, uniform(0.4, 0.9));
          rectangle(sign, tone(180, 40));
          leaves(sign, 0.03, 0.15, 0.8, 70, 110);
        }
      }
    }
  }

  cv::Mat_<uint8_t>& image_;
  double texel_;
  cv::RNG rng_;
  std::vector<cv::Point> fixed_;  ///< corners of a polygon
};

/// Bilinear value at texture pixel (x, y), pixel centres at integers, edges repeated.
float bilinear(const cv::Mat_<uint8_t>& image, float x, float y) {
  x = std::clamp(x, 0.f, image.cols - 1.001f);
  y = std::clamp(y, 0.f, image.rows - 1.001f);
  const int c = static_cast<int>(x), r = static_cast<int>(y);
  const float a = x - c, b = y - r;
  const uint8_t* top = image.ptr(r) + c;
  const uint8_t* bottom = top + image.step[0];
  const float upper = top[0] + a * (top[1] - top[0]), lower = bottom[0] + a * (bottom[1] - bottom[0]);
  return upper + b * (lower - upper);
}

}  // namespace

void Texture::paint() const {
  cv::Mat_<uint8_t> image(std::max(2, cvCeil(height_ / texel_)), std::max(2, cvCeil(width_ / texel_)), uint8_t{0});
  Painter(image, texel_, seed_).paint(style_);
  levels_.push_back(image);
  while (std::min(image.rows, image.cols) >= 8) {
    cv::Mat_<uint8_t> half;
    cv::resize(image, half, cv::Size((image.cols + 1) / 2, (image.rows + 1) / 2), 0, 0, cv::INTER_AREA);
    levels_.push_back(half);
    image = half;
  }
}

float Texture::sample(float u, float v, float footprint) const {
  std::call_once(painted_, [this] { paint(); });
  const float level = std::clamp(std::log2(footprint / static_cast<float>(texel_)), 0.f, levels_.size() - 1.001f);
  const int fine = static_cast<int>(level);
  const float scale = 1 / (static_cast<float>(texel_) * (1 << fine));
  const float x = u * scale, y = v * scale;
  const float near = bilinear(levels_[fine], x - 0.5f, y - 0.5f);
  const float far = bilinear(levels_[fine + 1], 0.5f * x - 0.5f, 0.5f * y - 0.5f);
  return near + (level - fine) * (far - near);
}

}  // namespace gms_ransac
