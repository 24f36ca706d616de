// The drawn two-view scenes by name: well-posed motions, degenerate ones, and what tries to fool an estimator.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "scenes/two_view_scene.h"

namespace gms_ransac {

struct DrawnScene {
  std::string name;
  std::string summary;  ///< what is seen, one line
  /// Of one pair, its seed apart; the motion varies from pair to pair about that of the name.
  std::function<TwoViewSceneOptions(Random&)> options;
};

/// In the order of reading. Unless a name says otherwise: 1000 matches, a tenth of them outliers within 48 px of their
/// place (what GMS lets through), 0.3 px of noise at octave 0. Scenes whose name tells the noise have octave 0 alone,
/// so that it is the noise of every match.
const std::vector<DrawnScene>& drawnScenes();

/// The `index`-th pair of a scene: the same one on every machine.
TwoViewScene drawPair(const DrawnScene& scene, int index);

}  // namespace gms_ransac
