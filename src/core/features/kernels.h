// The inner loops of the extractor, one table of functions for each instruction set. All levels compute the same bits.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "features/orb_pattern.h"
#include "gms_ransac/simd.h"

namespace gms_ransac {

/// Where each pixel of a resized row comes from: source[offset] * (256 - weight) + source[offset + 1] * weight, the
/// 8.8 fixed point of OpenCV's INTER_LINEAR_EXACT.
struct ResizeTable {
  static constexpr int kGroup = 8;     ///< outputs that share one window of the source
  static constexpr int kWindow = 16;   ///< bytes
  static constexpr int kPadding = 64;  ///< extra outputs, so that vector code needs no tail

  std::vector<uint16_t> offset;
  std::vector<uint16_t> weight;
  // The same per group, as byte shuffles that widen to 16 bit. Empty where a group does not fit in a window (scale near
  // 2).
  std::vector<int32_t> window;
  std::vector<uint8_t> first;
  std::vector<uint8_t> second;

  void build(int source, int target);
};

constexpr int kBlurTaps = 7;  ///< of the Gaussian that cv::ORB applies before the binary tests
constexpr int kBlurRadius = 3;
constexpr int kAngleRadius = 15;       ///< of the disc of the intensity centroid
constexpr int kDescriptorRadius = 18;  ///< largest rounded coordinate of a rotated test point

constexpr int kRowWindowWidth = 9, kRowWindowHeight = 7;  ///< compared along a row
constexpr int kMostGradient = 31;                         ///< of the images that are compared, which lie at 0..62

/// Below which corners need not be found.
struct CornerFloors {
  int contrast = 0;  ///< lower contrasts, and this one, count as none
  int strength = 0;  ///< corners may be passed over that are not stronger

  /// True if skipping whole blocks of pixels saves time: not at low strength.
  bool passBlocks() const { return (strength + 1) / 2 >= std::max(contrast + 1, kWorthPassing); }
  /// A corner of this contrast or less may be passed over: its neighbours have less, so that its strength is less than
  /// twice the contrast.
  int passedContrast() const { return passBlocks() ? (strength + 1) / 2 : contrast; }

 private:
  static constexpr int kWorthPassing = 15;  ///< 11 saves no time, 31 does: doc/measured/constants.md
};

struct MaximaCount {
  int all = 0;     ///< whose contrast is above CornerFloors::passedContrast()
  int strong = 0;  ///< of these, whose strength is above the floor
};

/// The blocks of a row of pixels, each as wide as a vector of the kernels, after contrastRow().
struct BlockRow {
  uint8_t* passed_over;  ///< by block: 1 where contrasts were not computed, and are zero, although the floor is lower
  uint16_t* candidates;  ///< first columns of the blocks with a contrast above CornerFloors::passedContrast()
};

struct FeatureKernels {
  /// One row of the horizontal pass, 8.8 fixed point. Writes up to ResizeTable::kPadding entries past `width`.
  void (*resizeRow)(const uint8_t* source, const ResizeTable& table, int width, uint16_t* target);
  /// Vertical pass: (upper * (256 - weight) + lower * weight) / 65536, rounded. May write Plane::kSlack past `width`.
  void (*blendRows)(const uint16_t* upper, const uint16_t* lower, int weight, int width, uint8_t* target);

  /// FAST-9/16 contrast of a row: the largest c such that nine contiguous pixels of the circle are all brighter or
  /// darker than the centre by c or more; 0 where not above `floor`. (cv::FAST's response is one less.) Blocks without
  /// any above floors.passedContrast() may be passed over. Returns how many are candidates; writes one entry past each
  /// of `blocks` at most.
  int (*contrastRow)(const uint8_t* image, ptrdiff_t stride, int width, const CornerFloors& floors, uint8_t* contrast,
                     const BlockRow& blocks);
  /// Columns in [begin, end), begin < 64, whose contrast exceeds that of all eight neighbours and whose strength is
  /// above floors.strength. Writes up to 15 entries past them. Strength is 3/2 of the neighbours' mean plus half the
  /// contrast, at most 255. Blocks that contrastRow() passed over are searched now if they touch a maximum. `rows`: the
  /// one above, this one with so many candidates, the one below; `passed_over` is read from one before the first block
  /// to one after the last.
  MaximaCount (*maximaRow)(const uint8_t* image, uint8_t* contrast, ptrdiff_t stride, const BlockRow (&rows)[3],
                           int candidates, const CornerFloors& floors, int begin, int end, uint16_t* columns,
                           uint8_t* strength);

  void (*widenRow)(const uint8_t* source, int width, float* target);
  /// The 7-tap Gaussian for two adjacent rows, which share loads: filters `pixels`, three more on either side, into
  /// rows[6] and rows[7], then the columns of rows[0..6] and rows[1..7], rounded half to even.
  void (*blurTwoRows)(const float* const pixels[2], float* const rows[kBlurTaps + 1], int width,
                      uint8_t* const target[2]);

  void (*moments)(const uint8_t* centre, ptrdiff_t stride, int& m10, int& m01);
  void (*describe)(const uint8_t* centre, ptrdiff_t stride, float cosine, float sine, uint8_t* descriptor);

  /// Difference of the pixels right and left, at most kMostGradient either way, plus kMostGradient. Reads one
  /// pixel before the row, and up to Plane::kSlack past `width`, where it writes as many.
  void (*gradientRow)(const uint8_t* row, int width, uint8_t* gradients);
  /// Sums of absolute differences of the window at `left` and those at `right` + 0..`count` - 1, first pixels of both.
  /// No pixel exceeds 2 * kMostGradient. Reads and writes up to Plane::kSlack entries past `count`.
  void (*compareRow)(const uint8_t* left, const uint8_t* right, ptrdiff_t stride, int count, int16_t* sums);
};

const FeatureKernels& featureKernels(SimdLevel level);

namespace detail {
const FeatureKernels& scalarFeatureKernels();
const FeatureKernels& avx2FeatureKernels();
const FeatureKernels& avx512FeatureKernels();
const FeatureKernels& neonFeatureKernels();

/// Gaussian of 7 taps and sigma 2, as cv::getGaussianKernel gives it in float.
extern const float kBlurKernel[kBlurTaps];
/// The disc of the intensity centroid: coordinates of its pixels, zero outside of it. One entry holds columns -15..16
/// of the row v below the centre, then of the row v above.
struct Disc {
  static constexpr int kRow = 2 * kAngleRadius + 2;
  int8_t x[kAngleRadius + 1][2 * kRow], y[kAngleRadius + 1][2 * kRow];
};
extern const Disc kDisc;
/// Rotations by 90 degrees, which only exchange and negate coordinates, make the 375 points of kOrbPattern from 174.
struct QuarterPattern {
  static constexpr int kPoints = 176;  ///< 174, and the centre as padding to whole vectors
  static constexpr int kTurns = 4;
  alignas(64) float x[kPoints] = {}, y[kPoints] = {};
  uint16_t slot[2][kOrbTests] = {};  ///< of each end of a test: its rotation * kPoints + its point

  constexpr QuarterPattern() {
    int points = 0;
    for (int i = 0; i < kOrbTests; ++i) {
      const OrbTest& test = kOrbPattern[i];
      slot[0][i] = slotOf(test.x0, test.y0, points);
      slot[1][i] = slotOf(test.x1, test.y1, points);
    }
  }

 private:
  constexpr uint16_t slotOf(int to_x, int to_y, int& points) {
    int turns = 0, point = 0;
    for (; to_x < 0 || to_y < 0 || (to_x == 0 && to_y > 0); ++turns) {
      const int before = to_x;
      to_x = to_y;
      to_y = -before;
    }
    while (point < points && !(x[point] == to_x && y[point] == to_y)) ++point;
    if (point == points) ++points;
    x[point] = static_cast<float>(to_x);
    y[point] = static_cast<float>(to_y);
    return static_cast<uint16_t>(turns * kPoints + point);
  }
};
struct DistinctPattern {
  static constexpr int kPoints = 384;  ///< 375, and the centre as padding to whole vectors
  static constexpr int kTable = 128;   ///< points among which one byte permutation chooses
  static constexpr int kTables = kPoints / kTable;
  alignas(64) float x[kPoints];
  alignas(64) float y[kPoints];
  alignas(64) uint8_t place[2][kOrbTests];        ///< of the point of each end in its table
  uint64_t in_table[2][kTables][kOrbTests / 64];  ///< a bit for each test
};
extern const DistinctPattern kDistinctPattern;
/// The AVX-512 kernels as Intel's processors run them fastest, or AMD's.
const FeatureKernels& avx512FeatureKernels(bool intel);
}  // namespace detail

}  // namespace gms_ransac
