// One image of a stream: selects its reference, has them compared and moves the stream on. Publishes nothing.
#pragma once

#include <memory>

#include "stream/comparison.h"
#include "stream/recovery.h"

namespace gms_ransac {

/// Answers a usable image. The stream becomes that after the image; `recovery` keeps earlier ones. Never throws.
ProcessedFrame step(Pipeline& pipeline, Stream& stream, Recovery& recovery, Workspace& work,
                    const std::shared_ptr<PreparedFrame>& current);

}  // namespace gms_ransac
