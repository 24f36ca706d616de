// Second stage for descriptors that the Hamming kernels do not compare: any length in bytes, or floats.
#pragma once

#include <vector>

#include "gms_ransac/hamming_matcher.h"

namespace gms_ransac {

/// Pairs that are each other's nearest neighbour (cv::BFMatcher: Hamming distance of bytes, L2 of floats), in the order
/// of the reference. `distance` and `second_distance` have the range of 256 bits (see Match). Throws
/// std::invalid_argument if the two sets cannot be compared.
void matchMutually(const DescriptorSet& reference, const DescriptorSet& current, std::vector<Match>& matches);

}  // namespace gms_ransac
