#include "scenes/drawn_scenes.h"

#include <cstdio>
#include <utility>

#include "random.h"

namespace gms_ransac {

namespace {

using Eigen::Vector3d;
using Options = TwoViewSceneOptions;
using Change = std::function<void(Options&, Random&)>;

constexpr double kDegree = M_PI / 180;
constexpr double kFilteredReach = 48;  // pixels: one and a half cells of the grid of motion statistics
constexpr double kVariation = 0.25;    // of motions about those of the scene, as a share of their length
constexpr double kTurn = 4 * kDegree;  // between images, for a rotating camera
constexpr double kShutterTurn = 2 * kDegree,
                 kReadout = 0.9;  // over the rows; of the time between images, as a Kinect's

const Vector3d kNone(0, 0, 0);
const Vector3d kForward(0.05, 0, 1), kDrivingTurn(0.005, 0.02, 0.005);

double between(double low, double high, Random& random) { return low + (high - low) * random.uniform(); }

Vector3d inCube(Random& random) {
  const double x = between(-1, 1, random), y = between(-1, 1, random), z = between(-1, 1, random);
  return {x, y, z};
}

Vector3d varied(const Vector3d& vector, Random& random) { return vector + kVariation * vector.norm() * inCube(random); }

Vector3d turnOf(double angle, Random& random) { return angle * inCube(random).normalized(); }

/// "%g" of the number.
std::string text(double number) {
  char buffer[32];
  std::snprintf(buffer, sizeof(buffer), "%g", number);
  return buffer;
}

Options ordinary() {
  Options options;
  options.outlier_ratio = 0.1;
  options.outlier_reach = kFilteredReach;
  options.octaves = options.as_measured = true;
  return options;
}

/// A scene that differs by `change` from the ordinary one, in a general motion unless the change sets another.
DrawnScene scene(std::string name, std::string summary, Change change) {
  const auto options = [change = std::move(change)](Random& random) {
    Options made = ordinary();
    made.translation = varied(made.translation, random);
    made.rotation = varied(made.rotation, random);
    change(made, random);
    return made;
  };
  return {std::move(name), std::move(summary), options};
}

void noise(Options& options, double pixels) {
  options.noise_px = pixels;
  options.octaves = false;
}

void driveForward(Options& options, Random& random) {
  options.translation = varied(kForward, random);
  options.rotation = varied(kDrivingTurn, random);
}

void turnOnly(Options& options, Random& random) {
  options.translation = kNone;
  options.rotation = turnOf(kTurn, random);
}

void stand(Options& options, Random&) { options.translation = options.rotation = kNone; }

void plane(Options& options, const Vector3d& normal, Random& random) {
  options.shape = SceneShape::kPlane;
  options.plane_normal = normal.normalized() + 0.1 * inCube(random);
}

/// A person or a vehicle near the camera: from a slow step to a car; half of them rotate as well.
MovingBody mover(double share, Random& random) {
  MovingBody body;
  body.share = share;
  const double step = 0.02 * std::pow(20, random.uniform());  // 2 to 40 cm from image to image: 3 to 50 px
  const double heading = between(0, 2 * M_PI, random);
  body.translation = step * Vector3d(std::cos(heading), 0.2 * inCube(random).y(), std::sin(heading));
  if (random.uniform() < 0.5) body.rotation = turnOf(between(0, 3 * kDegree, random), random);
  return body;
}

struct CameraMotion {
  const char* name;
  const char* summary;
  void (*set)(Options&, Random&);
};
constexpr CameraMotion kCameraMotions[] = {{"standing", "standing", stand},
                                           {"turning", "turning by 4 degrees", turnOnly},
                                           {"driving", "driving 1 m forward", driveForward}};

using Scenes = std::vector<DrawnScene>;

void addWellPosed(Scenes& scenes) {
  scenes.push_back(scene("general", "a general motion in a volume", [](Options&, Random&) {}));
  scenes.push_back(scene("general_2000", "the same, 2000 matches", [](Options& o, Random&) { o.matches = 2000; }));
  scenes.push_back(scene("forward", "1 m forward, points 4 to 12 m away", driveForward));
  scenes.push_back(scene("near_epipole", "the same, points within a tenth of the image about its middle",
                         [](Options& o, Random& random) {
                           driveForward(o, random);
                           o.image_share = 0.3;
                         }));
  for (const int percent : {20, 30, 40}) {
    scenes.push_back(scene("background_" + std::to_string(percent),
                           "a general motion, " + std::to_string(percent) + " % of the points 300 to 1000 m away",
                           [percent](Options& o, Random&) { o.background = percent / 100.; }));
  }
  scenes.push_back(scene("outliers_90", "a general motion, 90 % outliers anywhere", [](Options& o, Random&) {
    o.outlier_ratio = 0.9;
    o.outlier_reach = 0;
  }));
  scenes.push_back(scene("few_25", "a general motion, 25 matches, 30 % outliers anywhere", [](Options& o, Random&) {
    o.matches = 25;
    o.outlier_ratio = 0.3;
    o.outlier_reach = 0;
  }));
}

/// Exact model, few outliers below the threshold: the covariance can be checked against the truth.
void addExact(Scenes& scenes) {
  for (const double sigma : {0.2, 0.5, 1., 2.}) {
    scenes.push_back(scene("exact_noise_" + text(sigma),
                           "median displacement 10 px by the translation, noise " + text(sigma) + " px",
                           [sigma](Options& o, Random&) {
                             o = withMedianDisplacement(o, 10);
                             o.outlier_reach = 0;
                             noise(o, sigma);
                           }));
  }
}

void addSmallParallax(Scenes& scenes) {
  for (const double pixels : {0.1, 0.3, 0.5, 1., 1.5, 2., 3., 5.}) {
    for (const double sigma : {0.1, 0.2, 0.3}) {
      scenes.push_back(scene("parallax_" + text(pixels) + "_noise_" + text(sigma),
                             "median parallax " + text(pixels) + " px, noise " + text(sigma) + " px",
                             [pixels, sigma](Options& o, Random&) {
                               o = withMedianParallax(o, pixels);
                               noise(o, sigma);
                             }));
    }
  }
  for (const double pixels : {1., 1.5, 2., 5.}) {
    scenes.push_back(scene("displacement_" + text(pixels),
                           "median displacement " + text(pixels) + " px by the translation, noise 0.2 px",
                           [pixels](Options& o, Random&) {
                             o = withMedianDisplacement(o, pixels);
                             noise(o, 0.2);
                           }));
  }
  scenes.push_back(scene("far", "a general motion, everything 300 to 1000 m away", [](Options& o, Random&) {
    o.nearest = 300;
    o.farthest = 1000;
  }));
}

void addRotations(Scenes& scenes) {
  for (const double sigma : {0.3, 0.5, 1., 1.5, 2.}) {
    scenes.push_back(scene("rotation_noise_" + text(sigma), "pure rotation, noise " + text(sigma) + " px",
                           [sigma](Options& o, Random& random) {
                             turnOnly(o, random);
                             noise(o, sigma);
                           }));
  }
  const auto roll = [](Options& o, Random& random) {
    o.rotation = turnOf(kShutterTurn / kReadout, random);
    o.readout = kReadout;
  };
  scenes.push_back(scene("rolling_turning", "pure rotation, 2 degrees while the rows of an image are read",
                         [roll](Options& o, Random& random) {
                           o.translation = kNone;
                           roll(o, random);
                         }));
  scenes.push_back(scene("rolling_faster",
                         "pure rotation, 1 degree while the rows of the reference are read and 3 later",
                         [roll](Options& o, Random& random) {
                           o.translation = kNone;
                           roll(o, random);
                           o.acceleration = 0.5;
                         }));
  scenes.push_back(scene("rolling_driving", "1 m forward, 2 degrees while the rows of an image are read",
                         [roll](Options& o, Random& random) {
                           driveForward(o, random);
                           roll(o, random);
                         }));
  scenes.push_back(scene("rolling_straight", "the same on a straight way", [roll](Options& o, Random& random) {
    driveForward(o, random);
    roll(o, random);
    o.straight = true;
  }));
  scenes.push_back(
      scene("rolling_driving_faster", "rolling_driving with 1 degree and 3", [roll](Options& o, Random& random) {
        driveForward(o, random);
        roll(o, random);
        o.acceleration = 0.5;
      }));
}

void addPlanes(Scenes& scenes) {
  const Vector3d frontal(0, 0, 1), oblique(0.8, -0.3, 1);
  scenes.push_back(scene("plane_frontal", "a general motion before a wall",
                         [frontal](Options& o, Random& random) { plane(o, frontal, random); }));
  scenes.push_back(scene("plane_oblique", "the same, 40 degrees oblique",
                         [oblique](Options& o, Random& random) { plane(o, oblique, random); }));
  for (const double share : {0.03, 0.3}) {
    scenes.push_back(scene("plane_off_" + text(100 * share),
                           "the oblique one with " + text(100 * share) + " % of the points off it",
                           [share, oblique](Options& o, Random& random) {
                             plane(o, oblique, random);
                             o.off_plane = share;
                           }));
  }
}

void addWrongCalibration(Scenes& scenes) {
  for (const double error : {0.01, 0.03, 0.05}) {
    scenes.push_back(scene("focal_" + text(100 * error),
                           "a general motion, focal length " + text(100 * error) + " % longer than it is said to be",
                           [error](Options& o, Random&) { o.focal_error = error; }));
  }
  scenes.push_back(
      scene("distortion_small", "a general motion, radial distortion of -0.05 left in", [](Options& o, Random&) {
        o.radial = {-0.05, 0.01};
      }));
  scenes.push_back(scene("distortion_large", "the same, -0.28 and 0.07 as of a wide lens", [](Options& o, Random&) {
    o.radial = {-0.28, 0.07};
  }));
}

void addMovers(Scenes& scenes) {
  for (const CameraMotion& camera : kCameraMotions) {
    const std::string sight = std::string("camera ") + camera.summary + ", a body moves on ";
    const auto add = [&](int percent, double sigma, const std::string& suffix) {
      scenes.push_back(scene("body_" + std::to_string(percent) + "_" + camera.name + suffix,
                             sight + std::to_string(percent) + " % of the view, noise " + text(sigma) + " px",
                             [percent, sigma, set = camera.set](Options& o, Random& random) {
                               set(o, random);
                               o.noise_px = sigma;
                               o.bodies.push_back(mover(percent / 100., random));
                             }));
    };
    for (const int percent : {10, 20, 30, 40, 60}) add(percent, 0.3, "");
    add(40, 1, "_noise_1");
    scenes.push_back(scene(std::string("crowd_") + camera.name,
                           std::string("camera ") + camera.summary + ", twelve movers of 3 % of the view each",
                           [set = camera.set](Options& o, Random& random) {
                             set(o, random);
                             for (int k = 0; k < 12; ++k) o.bodies.push_back(mover(0.03, random));
                           }));
  }
}

/// Matches of one window with the next: points of the scene that seem to have moved by a period of it.
void addRepetition(Scenes& scenes) {
  const auto repeat = [](Options& o) {
    MovingBody shifted;
    shifted.share = 0.4;
    shifted.translation = {0.8, 0, 0};
    shifted.everywhere = true;
    o.bodies.push_back(shifted);
    o.informative = false;
  };
  scenes.push_back(scene("repeated_40", "a general motion, 40 % of the points matched a period of 0.8 m beside",
                         [repeat](Options& o, Random&) { repeat(o); }));
  scenes.push_back(scene("repeated_40_wall", "the same before an oblique wall", [repeat](Options& o, Random& random) {
    plane(o, {0.8, -0.3, 1}, random);
    repeat(o);
  }));
}

Scenes makeScenes() {
  Scenes scenes;
  for (auto* add : {addWellPosed, addExact, addSmallParallax, addRotations, addPlanes, addWrongCalibration, addMovers,
                    addRepetition}) {
    add(scenes);
  }
  return scenes;
}

}  // namespace

const std::vector<DrawnScene>& drawnScenes() {
  static const std::vector<DrawnScene> scenes = makeScenes();
  return scenes;
}

TwoViewScene drawPair(const DrawnScene& scene, int index) {
  Random random(static_cast<uint64_t>(index) + 1);
  Options options = scene.options(random);
  options.seed = random.next();
  return makeTwoViewScene(options);
}

}  // namespace gms_ransac
