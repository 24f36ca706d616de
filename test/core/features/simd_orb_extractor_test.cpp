// The package's extractor against OpenCV step by step (corners, pyramid, angle, descriptor), and as a whole; either
// extractor under a mask.
#include "features/simd_orb_extractor.h"
#include "shared_data.h"
#include "simd_levels.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>

#include <gtest/gtest.h>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace gms_ransac {
namespace {

cv::Mat noise(int width, int height, int seed) {
  cv::Mat image(height, width, CV_8UC1);
  cv::RNG rng(seed);
  rng.fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

/// Rectangles and discs over blurred noise: corners of every contrast at every scale, and flat regions.
cv::Mat drawnScene(int width, int height, int seed) {
  cv::Mat image = noise(width, height, seed);
  cv::GaussianBlur(image, image, cv::Size(9, 9), 3);
  cv::RNG rng(seed);
  for (int i = 0; i < width * height / 700; ++i) {
    const cv::Point centre(rng.uniform(0, width), rng.uniform(0, height));
    const cv::Point half(rng.uniform(2, 30), rng.uniform(2, 30));
    const cv::Scalar grey(rng.uniform(0, 256));
    if (i % 3) {
      cv::rectangle(image, centre - half, centre + half, grey, cv::FILLED);
    } else {
      cv::circle(image, centre, half.x, grey, cv::FILLED);
    }
  }
  cv::GaussianBlur(image, image, cv::Size(3, 3), 0.7);
  return image;
}

std::vector<cv::Mat> images() {
  std::vector<cv::Mat> all = {noise(203, 155, 1), drawnScene(640, 480, 2), drawnScene(333, 250, 3)};
  for (const char* name : {"kitti_06/image_0/000010.png", "tum_fr3_cabinet/rgb/1341841278.8427.jpg"}) {
    cv::Mat image = cv::imread((dataFolder() / name).string(), cv::IMREAD_GRAYSCALE);
    if (!image.empty()) all.push_back(image);
  }
  return all;
}

Plane planeOf(const cv::Mat& image) {
  Plane plane;
  plane.resize(image.cols, image.rows);
  for (int y = 0; y < image.rows; ++y) std::copy_n(image.ptr(y), image.cols, plane.row(y));
  return plane;
}

int differentBits(const uint8_t* a, const uint8_t* b) {
  int count = 0;
  for (int i = 0; i < kDescriptorBytes; ++i) count += __builtin_popcount(a[i] ^ b[i]);
  return count;
}

/// Bits by which a descriptor may differ from the installed cv::ORB, on average. None if OpenCV fuses products as we do
/// (4.6 on a processor with FMA). Otherwise its blur differs by one grey level in one pixel of 10^5, in 4.5 and earlier
/// in more.
double allowedBits() {
#if CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR == 6 && defined(__x86_64__)
  return simdLevelSupported(SimdLevel::kAvx2) ? 0 : 0.05;
#else
  return 2;
#endif
}

class CornerDetection : public testing::TestWithParam<SimdLevel> {};
INSTANTIATE_TEST_SUITE_P(Levels, CornerDetection, testing::ValuesIn(supportedLevels()),
                         [](const auto& info) { return toString(info.param); });

TEST_P(CornerDetection, FindsTheCornersAndResponsesOfCvFast) {
  const int kBorder = 4;
  for (const cv::Mat& image : images()) {
    for (int threshold : {0, 1, 7, 20, 60, 254}) {
      std::vector<Corner> corners;
      CornerDetector detector;
      const Plane plane = planeOf(image);
      detector.detect(plane, kBorder, {threshold, 0}, featureKernels(GetParam()), corners);

      std::vector<cv::KeyPoint> expected, plain;
      cv::FAST(image, expected, threshold, true, cv::FastFeatureDetector::TYPE_9_16);
      const auto inside = [&](const cv::KeyPoint& k) {
        return k.pt.x >= kBorder && k.pt.y >= kBorder && k.pt.x < image.cols - kBorder && k.pt.y < image.rows - kBorder;
      };
      expected.erase(std::remove_if(expected.begin(), expected.end(), std::not_fn(inside)), expected.end());
      // At threshold 0 cv::FAST drops a maximum of contrast 1, whose response is its zero for "no corner".
      const auto dropped = [](const Corner& c) { return c.contrast == 1; };
      corners.erase(std::remove_if(corners.begin(), corners.end(), dropped), corners.end());
      ASSERT_EQ(corners.size(), expected.size()) << image.size() << " threshold " << threshold;
      for (size_t i = 0; i < corners.size(); ++i) {
        ASSERT_EQ(cv::Point2f(corners[i].x, corners[i].y), expected[i].pt);
        ASSERT_EQ(corners[i].contrast - 1, expected[i].response);
      }

      cv::FAST(image, plain, threshold, false, cv::FastFeatureDetector::TYPE_9_16);
      cv::Mat is_corner = cv::Mat::zeros(image.size(), CV_8UC1);
      for (const cv::KeyPoint& k : plain) is_corner.at<uint8_t>(k.pt) = 1;
      for (int y = kBorder; y < image.rows - kBorder; ++y) {
        for (int x = kBorder; x < image.cols - kBorder; ++x) {
          ASSERT_EQ(detector.contrast().row(y)[x] > 0, is_corner.at<uint8_t>(y, x) > 0) << x << " " << y;
        }
      }
    }
  }
}

constexpr int kLevels = 5;
constexpr double kScaleFactors[] = {1.2, 1.44, 2.0};

TEST(SimdOrbExtractor, AngleIsCvOrbsOnItsKeypoints) {
  const FeatureKernels& kernels = featureKernels(detectSimdLevel());
  for (const cv::Mat& image : images()) {
    for (double scale_factor : kScaleFactors) {
      std::vector<cv::KeyPoint> keypoints;
      cv::ORB::create(3000, static_cast<float>(scale_factor), kLevels)->detect(image, keypoints);
      ASSERT_GT(keypoints.size(), 30u);
      Pyramid pyramid(kLevels, scale_factor, 2 * kDescriptorRadius + 1, kernels);
      pyramid.build(image);
      for (const cv::KeyPoint& keypoint : keypoints) {
        const auto inverse = 1.0f / static_cast<float>(pyramid.nominalScale(keypoint.octave));
        const Plane& level = pyramid.level(keypoint.octave);
        int m10, m01;
        kernels.moments(level.row(cvRound(keypoint.pt.y * inverse)) + cvRound(keypoint.pt.x * inverse), level.stride(),
                        m10, m01);
        ASSERT_EQ(cv::fastAtan2(static_cast<float>(m01), static_cast<float>(m10)), keypoint.angle);
      }
    }
  }
}

TEST(SimdOrbExtractor, BlurReachesEveryPixelThatATestMayRead) {
  // Every corner alone, where a block, the ring of rows or the side of the image might cut it off, and a few together.
  const cv::Mat image = noise(194, 155, 8);  // two columns more than whole blocks
  cv::Mat expected;
  cv::GaussianBlur(image, expected, cv::Size(7, 7), 2, 2, cv::BORDER_REFLECT_101);
  const Plane plane = planeOf(image);
  std::vector<Corner> all;
  for (int y = kDescriptorRadius; y < image.rows - kDescriptorRadius; y += 13) {
    for (int x = kDescriptorRadius; x < image.cols - kDescriptorRadius; x += 17) {
      all.push_back({static_cast<uint16_t>(x), static_cast<uint16_t>(y), 0, 0});
    }
  }
  for (int right = 1; right < 8; ++right) {
    const int x = image.cols - kDescriptorRadius - right, y = image.rows - kDescriptorRadius - 1;
    all.push_back({static_cast<uint16_t>(x), static_cast<uint16_t>(y), 0, 0});
  }
  for (SimdLevel simd : supportedLevels()) {
    for (size_t count : {size_t{1}, size_t{3}}) {
      for (size_t i = 0; i + count <= all.size(); ++i) {
        const std::vector<Corner> corners(all.begin() + i, all.begin() + i + count);
        Blur blur;
        Plane blurred;
        blur.apply(plane, corners, featureKernels(simd), blurred);
        for (const Corner& corner : corners) {
          for (int y = corner.y - kDescriptorRadius; y <= corner.y + kDescriptorRadius; ++y) {
            for (int x = corner.x - kDescriptorRadius; x <= corner.x + kDescriptorRadius; ++x) {
              // OpenCV's rounding varies with its version, see allowedBits().
              ASSERT_NEAR(blurred.row(y)[x], expected.at<uint8_t>(y, x), 1) << toString(simd) << " " << x << " " << y;
            }
          }
        }
      }
    }
  }
}

/// Position of a keypoint in pixels of its level, before the sub-pixel refinement.
cv::Point2f levelPosition(const cv::KeyPoint& keypoint, const Pyramid& pyramid) {
  const cv::Point2f scale = pyramid.scale(keypoint.octave);
  return {std::round((keypoint.pt.x + 0.5f) / scale.x - 0.5f), std::round((keypoint.pt.y + 0.5f) / scale.y - 0.5f)};
}

TEST(SimdOrbExtractor, ItsDescriptorsAreCvOrbsAtTheSamePositionLevelAndAngle) {
  for (const cv::Mat& image : images()) {
    for (double scale_factor : kScaleFactors) {
      FeatureExtractorOptions options;
      options.pyramid_levels = kLevels;
      options.pyramid_scale = scale_factor;
      Features features;
      SimdOrbExtractor(options).extract(image, features);
      Pyramid pyramid(kLevels, scale_factor, 1, featureKernels(options.simd));
      pyramid.build(image);

      std::vector<cv::KeyPoint> keypoints = features.keypoints;
      for (size_t i = 0; i < keypoints.size(); ++i) {
        const cv::Point2f position = levelPosition(keypoints[i], pyramid);
        keypoints[i].pt = position * static_cast<float>(pyramid.nominalScale(keypoints[i].octave));
        keypoints[i].class_id = static_cast<int>(i);
      }
      // No border in cv::ORB: it would drop keypoints near the sides.
      cv::Mat descriptors;
      cv::ORB::create(500, static_cast<float>(scale_factor), kLevels, 1)->compute(image, keypoints, descriptors);
      ASSERT_EQ(keypoints.size(), features.keypoints.size());
      double bits = 0;
      for (size_t i = 0; i < keypoints.size(); ++i) {
        bits += differentBits(features.descriptors.row(keypoints[i].class_id), descriptors.ptr(static_cast<int>(i)));
      }
      EXPECT_LE(bits / keypoints.size(), allowedBits()) << scale_factor << image.size();
    }
  }
}

void expectSame(const Features& a, const Features& b) {
  ASSERT_EQ(a.size(), b.size());
  for (int i = 0; i < a.size(); ++i) {
    const cv::KeyPoint &p = a.keypoints[i], &q = b.keypoints[i];
    ASSERT_EQ(p.pt, q.pt) << i;
    ASSERT_EQ(p.angle, q.angle) << i;
    ASSERT_EQ(p.octave, q.octave) << i;
    ASSERT_EQ(p.response, q.response) << i;
    ASSERT_EQ(differentBits(a.descriptors.row(i), b.descriptors.row(i)), 0) << i;
  }
}

TEST(SimdOrbExtractor, IsTheSameOnEveryInstructionSetAndNumberOfThreads) {
  for (const cv::Mat& image : images()) {
    for (int features : {50, 2000, 10000}) {
      FeatureExtractorOptions options;
      options.features = features;
      options.simd = SimdLevel::kScalar;
      Features expected;
      SimdOrbExtractor(options).extract(image, expected);
      std::vector<std::pair<SimdLevel, int>> ways;  // threads do not depend on the instruction set, nor it on them
      for (SimdLevel simd : supportedLevels()) ways.emplace_back(simd, 1);
      for (int threads : {2, 3, 8}) ways.emplace_back(detectSimdLevel(), threads);
      for (const auto& [simd, threads] : ways) {
        options.simd = simd;
        options.threads = threads;
        SimdOrbExtractor extractor(options);
        Features found;
        extractor.extract(noise(100, 80, 5), found);
        extractor.extract(image, found);
        expectSame(found, expected);
      }
    }
  }
}

TEST(SimdOrbExtractor, GivesAsManyAsAskedAndCoversTheImage) {
  FeatureExtractorOptions options;
  SimdOrbExtractor extractor(options);
  Features features;
  const cv::Mat image = drawnScene(640, 480, 6);
  extractor.extract(image, features);
  EXPECT_EQ(features.size(), options.features);
  cv::Mat cells = cv::Mat::zeros(6, 8, CV_32SC1);
  for (const cv::KeyPoint& k : features.keypoints) {
    ++cells.at<int>(static_cast<int>(k.pt.y) / 80, static_cast<int>(k.pt.x) / 80);
  }
  EXPECT_EQ(cv::countNonZero(cells), static_cast<int>(cells.total()));
}

TEST(SimdOrbExtractor, LocatesACornerBetweenPixels) {
  // A blob whose centre moves in steps of a quarter pixel: the keypoint on it must follow on every level.
  for (int step = 0; step < 8; ++step) {
    const double x0 = 160 + 0.25 * step, y0 = 120 - 0.25 * step;
    cv::Mat image(240, 320, CV_8UC1);
    for (int y = 0; y < image.rows; ++y) {
      for (int x = 0; x < image.cols; ++x) {
        const double squared = (x - x0) * (x - x0) + (y - y0) * (y - y0);
        image.at<uint8_t>(y, x) = cv::saturate_cast<uint8_t>(20 + 220 * std::exp(-squared / (2 * 2.5 * 2.5)));
      }
    }
    FeatureExtractorOptions options;
    SimdOrbExtractor extractor(options);
    Features features;
    extractor.extract(image, features);
    ASSERT_GT(features.size(), 0);
    for (const cv::KeyPoint& k : features.keypoints) {
      EXPECT_NEAR(k.pt.x, x0, 0.35 * std::pow(1.2, k.octave)) << "octave " << k.octave;
      EXPECT_NEAR(k.pt.y, y0, 0.35 * std::pow(1.2, k.octave)) << "octave " << k.octave;
    }
  }
}

TEST(CornerSelector, KnowsWhenMissingWeakCornersMightHaveBeenKept) {
  const int kWidth = 800, kHeight = 400, kQuota = 300;  // two cells
  cv::RNG random(3);
  // Few corners on the left, of which weak ones are kept; then as many as on the right.
  for (int left : {30, 2000}) {
    std::vector<Corner> all;
    for (int i = 0; i < left + 2000; ++i) {
      const int x = i < left ? random.uniform(0, kWidth / 2) : random.uniform(kWidth / 2, kWidth);
      const auto strength = static_cast<uint8_t>(random.uniform(1, 256));
      all.push_back({static_cast<uint16_t>(x), static_cast<uint16_t>(random.uniform(0, kHeight)), 1, strength});
    }
    CornerSelector selector;
    std::vector<Corner> expected = all;
    ASSERT_TRUE(selector.select(kWidth, kHeight, kQuota, 0, expected));
    int certain = 0;
    for (int floor = 1; floor < 255; ++floor) {
      std::vector<Corner> strong;
      for (const Corner& corner : all) {
        if (corner.strength > floor) strong.push_back(corner);
      }
      if (!selector.select(kWidth, kHeight, kQuota, floor, strong)) continue;
      ++certain;
      ASSERT_EQ(strong.size(), expected.size()) << floor;
      for (size_t i = 0; i < strong.size(); ++i) {
        ASSERT_TRUE(strong[i].x == expected[i].x && strong[i].y == expected[i].y) << left << " " << floor;
      }
    }
    EXPECT_GT(certain, 20);
    EXPECT_LT(certain, 254);
  }
}

TEST(SimdOrbExtractor, PassesOverWeakCornersOnlyWhereItChangesNothing) {
  // The forecast from one image holds for the next or does not: contrast that falls and rises, parts that lose their
  // texture, a mask, other numbers of features.
  const cv::Size size(320, 240);
  const cv::Mat scene = drawnScene(size.width, size.height, 12);
  cv::Mat faint, half_flat = scene.clone(), flat_half = half_flat.colRange(0, size.width / 2), mask(size, CV_8UC1, 255);
  scene.convertTo(faint, -1, 0.2, 90);
  flat_half.convertTo(flat_half, -1, 0.1, 100);
  mask(cv::Rect(0, 0, 250, 150)).setTo(0);
  struct Frame {
    cv::Mat image, mask;
    int at_most;
  };
  const std::vector<Frame> frames = {{scene, {}, 400},
                                     {scene, {}, 200},
                                     {scene, {}, 80},
                                     {scene, mask, 100},
                                     {half_flat, {}, 200},
                                     {faint, {}, 200},
                                     {noise(320, 240, 13), {}, 200},
                                     {cv::Mat(size, CV_8UC1, cv::Scalar(9)), {}, 200}};
  constexpr int kUntilTrusted = 10;  // images after a forecast that failed
  FeatureExtractorOptions options;
  for (SimdLevel simd : {SimdLevel::kScalar, detectSimdLevel()}) {
    options.simd = simd;
    SimdOrbExtractor used(options);
    for (const Frame& before : {frames[1], frames[6]}) {
      for (const Frame& frame : frames) {
        Features answer, expected;
        SimdOrbExtractor(options).extract(frame.image, expected, frame.mask, frame.at_most);
        for (int i = 0; i < kUntilTrusted; ++i) used.extract(before.image, answer, before.mask, before.at_most);
        for (int i = 0; i < 2; ++i) {
          used.extract(frame.image, answer, frame.mask, frame.at_most);
          expectSame(answer, expected);
        }
      }
    }
  }
}

TEST(SimdOrbExtractor, TakesImagesOfAnySizeAndContents) {
  FeatureExtractorOptions options;
  SimdOrbExtractor extractor(options);
  Features features;
  const cv::Mat whole = noise(700, 300, 7);
  for (cv::Size size : {cv::Size(1, 1), cv::Size(700, 1), cv::Size(1, 300), cv::Size(36, 36), cv::Size(37, 37),
                        cv::Size(64, 64), cv::Size(37, 300), cv::Size(699, 299), cv::Size(65, 130)}) {
    const cv::Mat part = whole(cv::Rect(cv::Point(0, 0), size));
    extractor.extract(part, features);
    EXPECT_EQ(features.image_size, size);
    Features copied;
    extractor.extract(part.clone(), copied);
    expectSame(features, copied);
    const int shorter = std::min(size.width, size.height);
    EXPECT_TRUE(shorter < 37 ? features.size() == 0 : shorter < 64 || features.size() > 0) << size;
    for (const cv::KeyPoint& k : features.keypoints) {
      EXPECT_TRUE(cv::Rect2f(cv::Point2f(0, 0), cv::Size2f(size)).contains(k.pt));
    }
  }
  for (int grey : {0, 128, 255}) {
    extractor.extract(cv::Mat(480, 640, CV_8UC1, cv::Scalar(grey)), features);
    EXPECT_EQ(features.size(), 0);
  }
  extractor.extract(cv::Mat(), features);
  EXPECT_EQ(features.size(), 0);
}

/// The lower half is masked, and a slanted bar that no level of the pyramid is aligned with.
cv::Mat halfAndBar() {
  cv::Mat mask(480, 640, CV_8UC1, cv::Scalar(1));
  mask.rowRange(240, 480).setTo(0);
  cv::line(mask, {31, 17}, {607, 211}, cv::Scalar(0), 23);
  return mask;
}

/// Largest distance of a keypoint inside the masked part from the nearest pixel that may be used, pixels.
float deepest(const Features& features, const cv::Mat& mask) {
  cv::Mat distance;
  cv::distanceTransform(mask == 0, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  float most = 0;
  for (const cv::KeyPoint& k : features.keypoints) {
    most = std::max(most, distance.at<float>(cvRound(k.pt.y), cvRound(k.pt.x)));
  }
  return most;
}

class ExtractorMask : public testing::TestWithParam<const char*> {
 protected:
  static FeatureExtractorOptions options() {
    FeatureExtractorOptions options;
    options.extractor = GetParam();
    options.features = 1000;
    return options;
  }
  Features extract(const cv::Mat& mask) {
    Features features;
    extractor_->extract(image_, features, mask);
    return features;
  }

  const cv::Mat image_ = drawnScene(640, 480, 5);
  const std::unique_ptr<FeatureExtractor> extractor_ = makeFeatureExtractor(options());
};
INSTANTIATE_TEST_SUITE_P(Extractors, ExtractorMask, testing::Values("simd_orb", "opencv"));

TEST_P(ExtractorMask, TakesNoKeypointUnderItAndAllThatAreAskedForElsewhere) {
  const cv::Mat mask = halfAndBar();
  const Features features = extract(mask);
  EXPECT_GE(features.size(), 0.99 * options().features);
  const bool ours = std::string(GetParam()) == "simd_orb";
  EXPECT_LE(deepest(features, mask), ours ? 0 : 3) << "cv::ORB: half a pixel of its highest level, along either axis";
}

TEST_P(ExtractorMask, MakesNoDifferenceWhereItMasksNothing) {
  const Features plain = extract(cv::Mat()), masked = extract(cv::Mat(480, 640, CV_8UC1, cv::Scalar(255)));
  expectSame(plain, masked);
}

TEST_P(ExtractorMask, LeavesNothingWhereItMasksAll) { EXPECT_EQ(extract(cv::Mat::zeros(480, 640, CV_8UC1)).size(), 0); }

TEST_P(ExtractorMask, IsRefusedInAnotherSizeOrType) {
  EXPECT_THROW(extract(cv::Mat::zeros(240, 320, CV_8UC1)), std::invalid_argument);
  EXPECT_THROW(extract(cv::Mat::zeros(480, 640, CV_8UC3)), std::invalid_argument);
}

}  // namespace
}  // namespace gms_ransac
