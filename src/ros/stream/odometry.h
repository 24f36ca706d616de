// The answers of a stream, one image after the other, chained to the pose of the camera in the odometry frame.
#pragma once

#include "parameters.h"
#include "stream/motion_integrator.h"
#include "stream/processed_frame.h"

namespace gms_ransac {

/// Moves `place` on to the image of the answer, and says in the answer whether that is known.
void integrate(const Parameters& parameters, MotionIntegrator& place, ProcessedFrame& answer);

}  // namespace gms_ransac
