// The 256 point pairs of the ORB descriptor, as OpenCV ships them.
#pragma once

#include <cstdint>

namespace gms_ransac {

/// One binary test: bit i of the descriptor is I(x0, y0) < I(x1, y1), in the keypoint's own, upright frame.
struct OrbTest {
  int8_t x0, y0, x1, y1;
};

constexpr int kOrbTests = 256;
extern const OrbTest kOrbPattern[kOrbTests];

}  // namespace gms_ransac
