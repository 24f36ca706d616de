// The extractor's inner loops without vector instructions: one lane of everything.
#include <cmath>

#include "features/kernels_impl.h"

namespace gms_ransac {
namespace {

struct Scalar {
  static constexpr int kBytes = 1, kHalves = 1, kFloats = 1;
  static constexpr bool kShuffles = false;
  using U8 = uint8_t;
  using I16 = int16_t;
  using F32 = float;

  static U8 load(const uint8_t* p) { return *p; }
  static void store(uint8_t* p, U8 a) { *p = a; }
  static U8 set(uint8_t a) { return a; }
  static U8 min(U8 a, U8 b) { return a < b ? a : b; }
  static U8 max(U8 a, U8 b) { return a > b ? a : b; }
  static U8 otherMin(U8 a, U8 b) { return min(a, b); }
  static U8 otherMax(U8 a, U8 b) { return max(a, b); }
  static U8 subtract(U8 a, U8 b) { return a > b ? a - b : 0; }
  static U8 average(U8 a, U8 b) { return static_cast<U8>((a + b + 1) / 2); }
  static U8 addSaturated(U8 a, U8 b) { return a + b > 255 ? 255 : static_cast<U8>(a + b); }
  static bool anyGreater(U8 a, U8 b) { return a > b; }
  static U8 keepGreater(U8 a, U8 b) { return a > b ? a : 0; }
  static uint64_t greaterMask(U8 a, U8 b) { return a > b; }

  static int storeColumns(uint64_t mask, int x, uint16_t* columns) { return storeSetBits(mask, x, columns); }

  static I16 loadHalves(const uint16_t* p) { return static_cast<int16_t>(*p); }
  static void storeHalves(uint16_t* p, I16 a) { *p = static_cast<uint16_t>(a); }
  static I16 loadSigned(const int16_t* p) { return *p; }
  static I16 loadAsHalves(const uint8_t* p) { return *p; }
  static I16 setHalves(int16_t a) { return a; }
  static I16 bitAnd(I16 a, I16 b) { return a & b; }
  static I16 addHalves(I16 a, I16 b) { return static_cast<int16_t>(a + b); }
  static I16 subtractHalves(I16 a, I16 b) { return static_cast<int16_t>(a - b); }
  static I16 multiplyHalves(I16 a, I16 b) { return static_cast<int16_t>(a * b); }
  static int dot(I16 a, I16 b) { return a * b; }
  static I16 loadWindows(const uint8_t*, const int32_t*) { return 0; }
  static I16 shuffle(I16, const uint8_t*) { return 0; }
  static I16 blendBytes(I16, I16, I16) { return 0; }
  static int blendHalves(I16 a, I16 b, int weight) {
    return (static_cast<uint16_t>(a) * (256 - weight) + static_cast<uint16_t>(b) * weight + (1 << 15)) >> 16;
  }
  static void storeNarrow(uint8_t* p, int a) { *p = static_cast<uint8_t>(a); }

  static F32 setFloat(float a) { return a; }
  static F32 loadFloats(const float* p) { return *p; }
  static F32 loadAsFloats(const uint8_t* p) { return *p; }
  static void storeFloats(float* p, F32 a) { *p = a; }
  static F32 add(F32 a, F32 b) { return a + b; }
  static F32 subtractFloats(F32 a, F32 b) { return a - b; }
  static F32 multiply(F32 a, F32 b) { return a * b; }
  /// Fused in effect: the product of two floats is exact in double.
  static F32 multiplyAdd(F32 a, F32 b, F32 c) { return static_cast<float>(static_cast<double>(a) * b + c); }
  static void storeRounded(uint8_t* p, F32 a) { *p = static_cast<uint8_t>(std::lrint(a)); }
  static int32_t offsets(F32 column, F32 row, int stride) {
    return static_cast<int32_t>(std::lrint(row) * stride + std::lrint(column));
  }
  static void storeOffsets(int32_t* p, int32_t a) { *p = a; }
};

}  // namespace

const FeatureKernels& detail::scalarFeatureKernels() {
  static const FeatureKernels kernels = kernelsOf<Scalar>();
  return kernels;
}

}  // namespace gms_ransac
