// One length for the queues of all outputs.
#pragma once

#include <cstdint>

namespace gms_ransac {

constexpr uint32_t kPublisherQueue = 10;  ///< messages that wait for a slow listener

}  // namespace gms_ransac
