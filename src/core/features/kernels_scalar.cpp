// The extractor's inner loops for any little-endian processor, over vectors of 16 bytes, which the compiler turns into
// the processor's own: SSE2 on x86, single numbers where there are none. On 64-bit ARM also with instructions that it
// does not find itself.
#define GMS_RANSAC_VECTOR_BYTES 16
#include "features/kernels_impl.h"

#if defined(__aarch64__)
#include <arm_neon.h>
#endif

namespace gms_ransac {
namespace {

struct Portable : Vectors {
  static constexpr bool kShuffles = false;
  using U64 [[gnu::vector_size(16)]] = uint64_t;
  using FourBytes [[gnu::vector_size(4)]] = uint8_t;
  using EightBytes [[gnu::vector_size(8)]] = uint8_t;
  using EightHalves [[gnu::vector_size(16)]] = uint16_t;
  using EightWords [[gnu::vector_size(32)]] = uint32_t;
  using FourDoubles [[gnu::vector_size(32)]] = double;

  static U8 subtract(U8 a, U8 b) { return max(a, b) - b; }
  static U8 average(U8 a, U8 b) { return (a | b) - ((a ^ b) >> 1); }
  static U8 addSaturated(U8 a, U8 b) { return a + min(b, ~a); }
  static bool anyGreater(U8 a, U8 b) {
    const auto greater = reinterpret_cast<U64>(a > b);
    return (greater[0] | greater[1]) != 0;
  }
  static uint64_t greaterMask(U8 a, U8 b) {
    // One bit of each byte, and the product gathers the eight of a word in its highest byte.
    const U64 bits = reinterpret_cast<U64>(a > b) & 0x8040201008040201u;
    return bits[0] * 0x0101010101010101u >> 56 | bits[1] * 0x0101010101010101u >> 56 << 8;
  }

  static void storeBlend(uint8_t* p, I16 upper, I16 lower, int weight) {
    const auto first = __builtin_convertvector(reinterpret_cast<EightHalves>(upper), EightWords);
    const auto second = __builtin_convertvector(reinterpret_cast<EightHalves>(lower), EightWords);
    const auto share = static_cast<uint32_t>(weight);
    const EightWords blend = (first * (256 - share) + second * share + (1 << 15)) >> 16;
    store(p, __builtin_convertvector(__builtin_convertvector(blend, EightHalves), EightBytes));
  }

  static F32 loadAsFloats(const uint8_t* p) { return __builtin_convertvector(loadAny<FourBytes>(p), F32); }
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
  static void storeRounded(uint8_t* p, F32 a) { store(p, __builtin_convertvector(rounded(a), FourBytes)); }
};

#if defined(__aarch64__)
struct Neon : Portable {
  static constexpr bool kShuffles = true;

  static U8 subtract(U8 a, U8 b) { return vqsubq_u8(a, b); }
  static U8 average(U8 a, U8 b) { return vrhaddq_u8(a, b); }
  static U8 addSaturated(U8 a, U8 b) { return vqaddq_u8(a, b); }
  static bool anyGreater(U8 a, U8 b) { return vmaxvq_u8(vqsubq_u8(a, b)) != 0; }

  /// Takes 128 off the pixels, because b adds up to zero over a disc.
  static I16 multiplyPairs(U8 a, const int8_t* b) {
    const int8x16_t pixels = vreinterpretq_s8_u8(a ^ 128), factors = vld1q_s8(b);
    return vpaddq_s16(vmull_s8(vget_low_s8(pixels), vget_low_s8(factors)), vmull_high_s8(pixels, factors));
  }
  static I32 addPairs(I16 a) { return vpaddlq_s16(a); }
  static int sum(I32 a) { return vaddvq_s32(a); }
  static U8 loadWindows(const uint8_t* source, const int32_t* window) { return load(source + window[0]); }
  static I16 shuffle(U8 window, const uint8_t* positions) {
    return reinterpret_cast<I16>(vqtbl1q_u8(window, load(positions)));
  }
  static void storeBlend(uint8_t* p, I16 upper, I16 lower, int weight) {
    const auto a = reinterpret_cast<EightHalves>(upper), b = reinterpret_cast<EightHalves>(lower);
    const auto first = static_cast<uint16_t>(256 - weight), second = static_cast<uint16_t>(weight);
    const uint32x4_t low = vmlal_n_u16(vmull_n_u16(vget_low_u16(a), first), vget_low_u16(b), second);
    const uint32x4_t high = vmlal_n_u16(vmull_n_u16(vget_high_u16(a), first), vget_high_u16(b), second);
    vst1_u8(p, vmovn_u16(vcombine_u16(vrshrn_n_u32(low, 16), vrshrn_n_u32(high, 16))));
  }

  static F32 loadAsFloats(const uint8_t* p) {
    uint32_t word;
    std::memcpy(&word, p, sizeof word);
    return vcvtq_f32_u32(vmovl_u16(vget_low_u16(vmovl_u8(vcreate_u8(word)))));
  }
  static F32 multiplyAdd(F32 a, F32 b, F32 c) { return vfmaq_f32(c, a, b); }
  static I32 rounded(F32 a) { return vcvtnq_s32_f32(a); }
  static void storeRounded(uint8_t* p, F32 a) {
    const uint16x4_t halves = vqmovn_u32(vcvtnq_u32_f32(a));
    const uint8x8_t bytes = vqmovn_u16(vcombine_u16(halves, halves));
    vst1_lane_u32(reinterpret_cast<uint32_t*>(p), vreinterpret_u32_u8(bytes), 0);
  }
};
#endif

}  // namespace

const FeatureKernels& detail::scalarFeatureKernels() {
  static const FeatureKernels kernels = kernelsOf<Portable>();
  return kernels;
}

#if defined(__aarch64__)
const FeatureKernels& detail::neonFeatureKernels() {
  static const FeatureKernels kernels = kernelsOf<Neon>();
  return kernels;
}
#endif

}  // namespace gms_ransac
