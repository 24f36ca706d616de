// The extractor's inner loops for any little-endian processor, over vectors of 16 bytes. The compiler turns them into
// the processor's own: SSE2 on x86, single numbers where there are none.
#include "features/kernels_impl.h"

namespace gms_ransac {
namespace {

struct Portable {
  static constexpr int kBytes = 16, kHalves = 8, kFloats = 4;
  static constexpr bool kShuffles = false;
  using U8 [[gnu::vector_size(16)]] = uint8_t;
  using I16 [[gnu::vector_size(16)]] = int16_t;
  using F32 [[gnu::vector_size(16)]] = float;
  using I32 [[gnu::vector_size(16)]] = int32_t;
  using U64 [[gnu::vector_size(16)]] = uint64_t;
  using FourBytes [[gnu::vector_size(4)]] = uint8_t;
  using EightBytes [[gnu::vector_size(8)]] = uint8_t;
  using EightHalves [[gnu::vector_size(16)]] = uint16_t;
  using EightInts [[gnu::vector_size(32)]] = int32_t;
  using EightWords [[gnu::vector_size(32)]] = uint32_t;
  using FourDoubles [[gnu::vector_size(32)]] = double;

  template <typename Vector>
  static Vector loadAny(const void* p) {
    Vector a;
    std::memcpy(&a, p, sizeof a);
    return a;
  }
  template <typename Vector>
  static void storeAny(void* p, const Vector& a) {
    std::memcpy(p, &a, sizeof a);
  }

  static U8 load(const uint8_t* p) { return loadAny<U8>(p); }
  static void store(uint8_t* p, U8 a) { storeAny(p, a); }
  static U8 set(uint8_t a) { return a + U8{}; }
  static U8 min(U8 a, U8 b) { return a < b ? a : b; }
  static U8 max(U8 a, U8 b) { return a > b ? a : b; }
  static U8 otherMin(U8 a, U8 b) { return min(a, b); }
  static U8 otherMax(U8 a, U8 b) { return max(a, b); }
  static U8 subtract(U8 a, U8 b) { return max(a, b) - b; }
  static U8 average(U8 a, U8 b) { return (a | b) - ((a ^ b) >> 1); }
  static U8 addSaturated(U8 a, U8 b) { return a + min(b, ~a); }
  static bool anyGreater(U8 a, U8 b) {
    const auto greater = reinterpret_cast<U64>(a > b);
    return (greater[0] | greater[1]) != 0;
  }
  static U8 keepGreater(U8 a, U8 b) { return a > b ? a : U8{}; }
  static uint64_t greaterMask(U8 a, U8 b) {
    // One bit of each byte, and the product gathers the eight of a word in its highest byte.
    const U64 bits = reinterpret_cast<U64>(a > b) & 0x8040201008040201u;
    return bits[0] * 0x0101010101010101u >> 56 | bits[1] * 0x0101010101010101u >> 56 << 8;
  }

  static int storeColumns(uint64_t mask, int x, uint16_t* columns) { return storeSetBits(mask, x, columns); }

  static I16 loadHalves(const uint16_t* p) { return loadAny<I16>(p); }
  static void storeHalves(uint16_t* p, I16 a) { storeAny(p, a); }
  static I16 loadSigned(const int16_t* p) { return loadAny<I16>(p); }
  static I16 loadAsHalves(const uint8_t* p) { return __builtin_convertvector(loadAny<EightBytes>(p), I16); }
  static I16 setHalves(int16_t a) { return a + I16{}; }
  static I16 bitAnd(I16 a, I16 b) { return a & b; }
  static I16 addHalves(I16 a, I16 b) { return a + b; }
  static I16 subtractHalves(I16 a, I16 b) { return a - b; }
  static I16 multiplyHalves(I16 a, I16 b) { return a * b; }
  static int dot(I16 a, I16 b) {
    const EightInts products = __builtin_convertvector(a, EightInts) * __builtin_convertvector(b, EightInts);
    int sum = 0;
    for (int i = 0; i < kHalves; ++i) sum += products[i];
    return sum;
  }
  static EightHalves blendHalves(I16 a, I16 b, int weight) {
    const auto first = __builtin_convertvector(reinterpret_cast<EightHalves>(a), EightWords);
    const auto second = __builtin_convertvector(reinterpret_cast<EightHalves>(b), EightWords);
    const auto share = static_cast<uint32_t>(weight);
    return __builtin_convertvector((first * (256 - share) + second * share + (1 << 15)) >> 16, EightHalves);
  }
  static void storeNarrow(uint8_t* p, EightHalves a) { storeAny(p, __builtin_convertvector(a, EightBytes)); }

  static F32 setFloat(float a) { return F32{a, a, a, a}; }
  static F32 loadFloats(const float* p) { return loadAny<F32>(p); }
  static F32 loadAsFloats(const uint8_t* p) { return __builtin_convertvector(loadAny<FourBytes>(p), F32); }
  static void storeFloats(float* p, F32 a) { storeAny(p, a); }
  static F32 add(F32 a, F32 b) { return a + b; }
  static F32 subtractFloats(F32 a, F32 b) { return a - b; }
  static F32 multiply(F32 a, F32 b) { return a * b; }
  /// Fused in effect: the product of two floats is exact in double.
  static F32 multiplyAdd(F32 a, F32 b, F32 c) {
    const auto product = __builtin_convertvector(a, FourDoubles) * __builtin_convertvector(b, FourDoubles);
    return __builtin_convertvector(product + __builtin_convertvector(c, FourDoubles), F32);
  }
  /// To the nearest, halves to even, below 2^22: floats have no fraction where this is added.
  static I32 rounded(F32 a) {
    const F32 large = setFloat(3 << 22);
    return __builtin_convertvector(a + large - large, I32);
  }
  static void storeRounded(uint8_t* p, F32 a) { storeAny(p, __builtin_convertvector(rounded(a), FourBytes)); }
  static I32 offsets(F32 column, F32 row, int stride) { return rounded(row) * stride + rounded(column); }
  static void storeOffsets(int32_t* p, I32 a) { storeAny(p, a); }
};

}  // namespace

const FeatureKernels& detail::scalarFeatureKernels() {
  static const FeatureKernels kernels = kernelsOf<Portable>();
  return kernels;
}

}  // namespace gms_ransac
