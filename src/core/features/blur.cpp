#include "features/blur.h"

namespace gms_ransac {

namespace {
constexpr int kRing = 8;         // rows kept, a power of two that holds kBlurTaps
constexpr int kLine = 16;        // floats in a cache line
constexpr int kFloatSlack = 32;  // what vector code may overrun

int reflect(int i, int size) { return i < 0 ? -i : i >= size ? 2 * size - 2 - i : i; }
}  // namespace

void Blur::apply(const Plane& source, const FeatureKernels& kernels, Plane& target) {
  const int width = source.width(), height = source.height();
  target.resize(width, height);
  const size_t stride = (width + 2 * kFloatSlack + kLine - 1) / kLine * kLine;
  storage_.resize((kRing + 1) * stride + kLine);
  const auto address = reinterpret_cast<uintptr_t>(storage_.data()) / sizeof(float);
  float* first = storage_.data() + (kLine - address % kLine) % kLine;
  float* pixels = first + kFloatSlack;
  float* ring = first + stride;
  const auto ringRow = [&](int y) { return ring + (reflect(y, height) % kRing) * stride; };
  const auto filterRow = [&](int y) {
    kernels.widenRow(source.row(y), width, pixels);
    for (int i = 1; i <= kBlurRadius; ++i) {
      pixels[-i] = pixels[i];
      pixels[width - 1 + i] = pixels[width - 1 - i];
    }
    kernels.blurRow(pixels, width, ringRow(y));
  };
  for (int y = 0; y < kBlurRadius; ++y) filterRow(y);
  for (int y = 0; y < height; ++y) {
    if (y + kBlurRadius < height) filterRow(y + kBlurRadius);
    const float* rows[kBlurTaps];
    for (int k = 0; k < kBlurTaps; ++k) rows[k] = ringRow(y + k - kBlurRadius);
    kernels.blurColumns(rows, width, target.row(y));
  }
}

}  // namespace gms_ransac
