// The package's extractor against OpenCV step by step (corners, pyramid, angle, descriptor), and as a whole; either
// extractor under a mask.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "features/corner_detector.h"
#include "features/corner_selector.h"
#include "features/pyramid.h"
#include "gms_ransac/feature_extractor.h"
#include "shared_data.h"
#include "simd_levels.h"

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

TEST(CornerDetector, FindsTheCornersAndResponsesOfCvFast) {
  const int kBorder = 4;
  for (const cv::Mat& image : images()) {
    for (int threshold : {0, 1, 7, 20, 60, 254}) {
      std::vector<Corner> corners;
      CornerDetector detector;
      const Plane plane = planeOf(image);
      detector.detect(plane, kBorder, {threshold, 0}, featureKernels(detectSimdLevel()), corners);

      std::vector<cv::KeyPoint> expected, plain;
      cv::FAST(image, expected, threshold, true, cv::FastFeatureDetector::TYPE_9_16);
      cv::KeyPointsFilter::runByImageBorder(expected, image.size(), kBorder);
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

TEST(SimdOrbExtractor, ItsDescriptorsAreCvOrbsAtTheSamePositionLevelAndAngle) {
  for (const cv::Mat& image : images()) {
    for (double scale_factor : kScaleFactors) {
      FeatureExtractorOptions options;
      options.pyramid_levels = kLevels;
      options.pyramid_scale = scale_factor;
      Features features;
      makeFeatureExtractor(options)->extract(image, features);
      Pyramid pyramid(kLevels, scale_factor, 1, featureKernels(options.simd));
      pyramid.build(image);

      std::vector<cv::KeyPoint> keypoints = features.keypoints;
      for (size_t i = 0; i < keypoints.size(); ++i) {
        // In pixels of its level, before the sub-pixel refinement.
        const cv::Point2f scale = pyramid.scale(keypoints[i].octave);
        const cv::Point2f position(std::round((keypoints[i].pt.x + 0.5f) / scale.x - 0.5f),
                                   std::round((keypoints[i].pt.y + 0.5f) / scale.y - 0.5f));
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
  std::vector<std::pair<SimdLevel, int>> ways;  // threads do not depend on the instruction set, nor it on them
  for (SimdLevel simd : supportedLevels()) ways.emplace_back(simd, 1);
  for (int threads : {2, 3, 8}) ways.emplace_back(detectSimdLevel(), threads);
  for (const cv::Mat& image : images()) {
    for (int count : {50, 2000, 10000}) {
      Features expected, found;
      FeatureExtractorOptions options;
      options.features = count;
      for (const auto& [simd, threads] : ways) {
        options.simd = simd;
        options.threads = threads;
        const auto extractor = makeFeatureExtractor(options);
        extractor->extract(noise(100, 80, 5), found);
        extractor->extract(image, found);
        if (expected.size() == 0) expected = found;
        expectSame(found, expected);
      }
    }
  }
}

TEST(SimdOrbExtractor, GivesAsManyAsAskedAndCoversTheImage) {
  FeatureExtractorOptions options;
  Features features;
  makeFeatureExtractor(options)->extract(drawnScene(640, 480, 6), features);
  EXPECT_EQ(features.size(), options.features);
  cv::Mat cells = cv::Mat::zeros(6, 8, CV_32SC1);
  for (const cv::KeyPoint& k : features.keypoints) {
    ++cells.at<int>(static_cast<int>(k.pt.y) / 80, static_cast<int>(k.pt.x) / 80);
  }
  EXPECT_EQ(cv::countNonZero(cells), static_cast<int>(cells.total()));
}

TEST(SimdOrbExtractor, FindsInADarkImageWhatALightOneShows) {
  const cv::Mat light = drawnScene(640, 480, 3);
  const auto extractor = makeFeatureExtractor(FeatureExtractorOptions());
  const auto extracted = [&](const cv::Mat& image) {
    Features features;
    extractor->extract(image, features);
    return features;
  };
  cv::Mat dark, covered(480, 640, CV_8UC1);
  light.convertTo(dark, CV_8U, 0.05);
  const Features bright = extracted(light), found = extracted(dark);
  EXPECT_GT(found.size(), 0.9 * bright.size());
  int again = 0;
  for (const cv::KeyPoint& keypoint : found.keypoints) {
    again += std::any_of(bright.keypoints.begin(), bright.keypoints.end(),
                         [&](const cv::KeyPoint& other) { return cv::norm(other.pt - keypoint.pt) < 2; });
  }
  EXPECT_GT(again, 0.5 * found.size());
  // The noise of a covered lens is not amplified.
  cv::RNG(1).fill(covered, cv::RNG::NORMAL, 2, 1);
  EXPECT_LT(extracted(covered).size(), 100);
  EXPECT_EQ(extracted(cv::Mat::zeros(480, 640, CV_8UC1)).size(), 0);
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
    Features features;
    makeFeatureExtractor({})->extract(image, features);
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
      std::copy_if(all.begin(), all.end(), std::back_inserter(strong), [&](auto& c) { return c.strength > floor; });
      if (!selector.select(kWidth, kHeight, kQuota, floor, strong)) continue;
      ++certain;
      const auto same = [](const Corner& a, const Corner& b) { return a.x == b.x && a.y == b.y; };
      ASSERT_TRUE(std::equal(strong.begin(), strong.end(), expected.begin(), expected.end(), same)) << floor;
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
  const cv::Mat noisy = noise(320, 240, 13), blank(size, CV_8UC1, cv::Scalar(9));
  const Frame frames[] = {{scene, {}, 200},   {noisy, {}, 200},     {scene, {}, 400}, {scene, {}, 80},
                          {scene, mask, 100}, {half_flat, {}, 200}, {faint, {}, 200}, {blank, {}, 200}};
  constexpr int kUntilTrusted = 10;  // images after a forecast that failed
  FeatureExtractorOptions options;
  for (SimdLevel simd : {SimdLevel::kScalar, detectSimdLevel()}) {
    options.simd = simd;
    const auto used = makeFeatureExtractor(options);
    for (const Frame& before : {frames[0], frames[1]}) {
      for (const Frame& frame : frames) {
        Features answer, expected;
        makeFeatureExtractor(options)->extract(frame.image, expected, frame.mask, frame.at_most);
        for (int i = 0; i < kUntilTrusted; ++i) used->extract(before.image, answer, before.mask, before.at_most);
        for (int i = 0; i < 2; ++i) {
          used->extract(frame.image, answer, frame.mask, frame.at_most);
          expectSame(answer, expected);
        }
      }
    }
  }
}

TEST(SimdOrbExtractor, TakesImagesOfAnySizeAndContents) {
  const auto extractor = makeFeatureExtractor({});
  Features features;
  const cv::Mat whole = noise(700, 300, 7);
  for (cv::Size size : {cv::Size(1, 1), cv::Size(700, 1), cv::Size(1, 300), cv::Size(9, 9), cv::Size(32, 24),
                        cv::Size(64, 64), cv::Size(37, 300), cv::Size(699, 299), cv::Size(65, 130)}) {
    const cv::Mat part = whole(cv::Rect(cv::Point(0, 0), size));
    extractor->extract(part, features);
    EXPECT_EQ(features.image_size, size);
    Features copied;
    extractor->extract(part.clone(), copied);
    expectSame(features, copied);
    const int shorter = std::min(size.width, size.height);
    EXPECT_EQ(features.size() > 0, shorter >= 24) << size;  // nine pixels are border even when enlarged
    for (const cv::KeyPoint& k : features.keypoints) {
      EXPECT_TRUE(cv::Rect2f(cv::Point2f(0, 0), cv::Size2f(size)).contains(k.pt));
    }
  }
  for (int grey : {0, 128, 255}) {
    extractor->extract(cv::Mat(480, 640, CV_8UC1, cv::Scalar(grey)), features);
    EXPECT_EQ(features.size(), 0);
  }
  extractor->extract(cv::Mat(), features);
  EXPECT_EQ(features.size(), 0);
  const cv::Mat widest = noise(Features::kLargestSide + 1, 64, 7);
  extractor->extract(widest, features);
  EXPECT_EQ(features.size(), 0);
  extractor->extract(widest.colRange(1, widest.cols), features);
  EXPECT_GT(features.size(), 0);
}

class ExtractorMask : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Extractors, ExtractorMask, testing::Values("simd_orb", "opencv"));

TEST_P(ExtractorMask, TakesNoKeypointUnderItAndAllThatAreAskedForElsewhere) {
  FeatureExtractorOptions options;
  options.extractor = GetParam();
  options.features = 1000;
  const auto extractor = makeFeatureExtractor(options);
  const cv::Mat image = drawnScene(640, 480, 5);
  const auto extract = [&](const cv::Mat& mask) {
    Features features;
    extractor->extract(image, features, mask);
    return features;
  };
  // The lower half is masked, and a slanted bar that no level of the pyramid is aligned with.
  cv::Mat mask(image.size(), CV_8UC1, cv::Scalar(1)), depth;
  mask.rowRange(240, 480).setTo(0);
  cv::line(mask, {31, 17}, {607, 211}, cv::Scalar(0), 23);
  cv::distanceTransform(mask == 0, depth, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  const Features features = extract(mask);
  EXPECT_GE(features.size(), 0.99 * options.features);
  const float most = options.extractor == "simd_orb" ? 0 : 3;  // half a pixel of the highest level, along either axis
  for (const cv::KeyPoint& k : features.keypoints) {
    EXPECT_LE(depth.at<float>(cvRound(k.pt.y), cvRound(k.pt.x)), most) << k.pt;
  }
  expectSame(extract(cv::Mat()), extract(cv::Mat(image.size(), CV_8UC1, cv::Scalar(255))));
  EXPECT_EQ(extract(cv::Mat::zeros(image.size(), CV_8UC1)).size(), 0);
  EXPECT_THROW(extract(cv::Mat::zeros(240, 320, CV_8UC1)), std::invalid_argument);
  EXPECT_THROW(extract(cv::Mat::zeros(480, 640, CV_8UC3)), std::invalid_argument);
}

}  // namespace
}  // namespace gms_ransac
