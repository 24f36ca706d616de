// Where points are in the current image if the camera turned as another sensor says and moved little otherwise.
#pragma once

#include "gms_ransac/camera.h"
#include "gms_ransac/motion_prediction.h"
#include "gms_ransac/rotation_prior.h"

namespace gms_ransac {

/// Fills `prediction`, in pixels of the received images of a calibrated camera. A cell is not known where a ray of it
/// is not, or turns out of the view. Its reach holds the uncertainty of the turn and some parallax, of which a sensor
/// of rotations tells nothing.
void predictTurn(const RotationPrior& prior, const Camera& camera, MotionPrediction& prediction);

}  // namespace gms_ransac
