// The extractor's inner loops for 64-bit ARM.
#if defined(__aarch64__)
#include <arm_neon.h>

#include "features/kernels_impl.h"

namespace gms_ransac {
namespace {

struct Neon {
  static constexpr int kBytes = 16, kHalves = 8, kFloats = 4;
  static constexpr bool kShuffles = true;
  using U8 = uint8x16_t;
  using I16 = int16x8_t;
  using F32 = float32x4_t;

  static U8 load(const uint8_t* p) { return vld1q_u8(p); }
  static void store(uint8_t* p, U8 a) { vst1q_u8(p, a); }
  static U8 set(uint8_t a) { return vdupq_n_u8(a); }
  static U8 min(U8 a, U8 b) { return vminq_u8(a, b); }
  static U8 max(U8 a, U8 b) { return vmaxq_u8(a, b); }
  static U8 otherMin(U8 a, U8 b) { return min(a, b); }
  static U8 otherMax(U8 a, U8 b) { return max(a, b); }
  static U8 subtract(U8 a, U8 b) { return vqsubq_u8(a, b); }
  static U8 average(U8 a, U8 b) { return vrhaddq_u8(a, b); }
  static U8 addSaturated(U8 a, U8 b) { return vqaddq_u8(a, b); }
  static bool anyGreater(U8 a, U8 b) { return vmaxvq_u8(vqsubq_u8(a, b)) != 0; }
  static U8 keepGreater(U8 a, U8 b) { return vandq_u8(a, vcgtq_u8(a, b)); }
  static uint64_t greaterMask(U8 a, U8 b) {
    constexpr uint8_t kBits[16] = {1, 2, 4, 8, 16, 32, 64, 128, 1, 2, 4, 8, 16, 32, 64, 128};
    const uint8x16_t bits = vandq_u8(vcgtq_u8(a, b), vld1q_u8(kBits));
    return static_cast<uint64_t>(vaddv_u8(vget_low_u8(bits))) | static_cast<uint64_t>(vaddv_u8(vget_high_u8(bits)))
                                                                    << 8;
  }

  static int storeColumns(uint64_t mask, int x, uint16_t* columns) { return storeSetBits(mask, x, columns); }

  static I16 loadHalves(const uint16_t* p) { return vreinterpretq_s16_u16(vld1q_u16(p)); }
  static void storeHalves(uint16_t* p, I16 a) { vst1q_u16(p, vreinterpretq_u16_s16(a)); }
  static I16 loadSigned(const int16_t* p) { return vld1q_s16(p); }
  static I16 loadAsHalves(const uint8_t* p) { return vreinterpretq_s16_u16(vmovl_u8(vld1_u8(p))); }
  static I16 setHalves(int16_t a) { return vdupq_n_s16(a); }
  static I16 bitAnd(I16 a, I16 b) { return vandq_s16(a, b); }
  static I16 addHalves(I16 a, I16 b) { return vaddq_s16(a, b); }
  static I16 subtractHalves(I16 a, I16 b) { return vsubq_s16(a, b); }
  static I16 multiplyHalves(I16 a, I16 b) { return vmulq_s16(a, b); }
  static int dot(I16 a, I16 b) { return vaddvq_s32(vmlal_high_s16(vmull_s16(vget_low_s16(a), vget_low_s16(b)), a, b)); }
  static U8 loadWindows(const uint8_t* source, const int32_t* window) { return vld1q_u8(source + window[0]); }
  static I16 shuffle(U8 window, const uint8_t* positions) {
    return vreinterpretq_s16_u8(vqtbl1q_u8(window, vld1q_u8(positions)));
  }
  static I16 blendBytes(I16 first, I16 second, I16 weight) {
    return vmlaq_s16(vshlq_n_s16(first, 8), weight, vsubq_s16(second, first));
  }
  static uint8x8_t blendHalves(I16 upper, I16 lower, int weight) {
    const uint16x8_t a = vreinterpretq_u16_s16(upper), b = vreinterpretq_u16_s16(lower);
    const auto first = static_cast<uint16_t>(256 - weight), second = static_cast<uint16_t>(weight);
    const uint32x4_t low = vmlal_n_u16(vmull_n_u16(vget_low_u16(a), first), vget_low_u16(b), second);
    const uint32x4_t high = vmlal_n_u16(vmull_n_u16(vget_high_u16(a), first), vget_high_u16(b), second);
    return vmovn_u16(vcombine_u16(vrshrn_n_u32(low, 16), vrshrn_n_u32(high, 16)));
  }
  static void storeNarrow(uint8_t* p, uint8x8_t a) { vst1_u8(p, a); }

  static F32 setFloat(float a) { return vdupq_n_f32(a); }
  static F32 loadFloats(const float* p) { return vld1q_f32(p); }
  static F32 loadAsFloats(const uint8_t* p) {
    uint32_t word;
    std::memcpy(&word, p, sizeof word);
    const uint8x8_t bytes = vreinterpret_u8_u32(vdup_n_u32(word));
    return vcvtq_f32_u32(vmovl_u16(vget_low_u16(vmovl_u8(bytes))));
  }
  static void storeFloats(float* p, F32 a) { vst1q_f32(p, a); }
  static F32 add(F32 a, F32 b) { return vaddq_f32(a, b); }
  static F32 subtractFloats(F32 a, F32 b) { return vsubq_f32(a, b); }
  static F32 multiply(F32 a, F32 b) { return vmulq_f32(a, b); }
  static F32 multiplyAdd(F32 a, F32 b, F32 c) { return vfmaq_f32(c, a, b); }
  static void storeRounded(uint8_t* p, F32 a) {
    const uint16x4_t halves = vqmovn_u32(vcvtnq_u32_f32(a));
    const uint8x8_t bytes = vqmovn_u16(vcombine_u16(halves, halves));
    vst1_lane_u32(reinterpret_cast<uint32_t*>(p), vreinterpret_u32_u8(bytes), 0);
  }
  static int32x4_t offsets(F32 column, F32 row, int stride) {
    return vmlaq_n_s32(vcvtnq_s32_f32(column), vcvtnq_s32_f32(row), stride);
  }
  static void storeOffsets(int32_t* p, int32x4_t a) { vst1q_s32(p, a); }
};

}  // namespace

const FeatureKernels& detail::neonFeatureKernels() {
  static const FeatureKernels kernels = kernelsOf<Neon>();
  return kernels;
}

}  // namespace gms_ransac
#endif
