#include "scenes/drawn_scenes.h"

#include <utility>

#include "parameters/parameter.h"
#include "support/random.h"

namespace gms_ransac {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Options = TwoViewSceneOptions;
using Change = std::function<void(Options&, Random&)>;

constexpr double kDegree = M_PI / 180;
constexpr double kFilteredReach = 48;      // pixels: one and a half cells of the grid of motion statistics
constexpr double kVariation = 0.25;        // of motions about those of the scene, as a share of their length
constexpr double kRotation = 4 * kDegree;  // between images, for a rotating camera
constexpr double kReadoutRotation = 2 * kDegree,
                 kReadout = 0.9;  // over the rows; of the time between images, as a Kinect's

const Vector3d kNone(0, 0, 0), kForward(0.05, 0, 1), kDrivingRotation(0.005, 0.02, 0.005);
const Vector3d kFrontal(0, 0, 1), kOblique(0.8, -0.3, 1);

Vector3d varied(const Vector3d& vector, Random& random) { return vector + kVariation * vector.norm() * inCube(random); }

Vector3d rotationOf(double angle, Random& random) { return angle * inCube(random).normalized(); }

/// A person or a vehicle near the camera: from a slow step to a car; half of them rotate as well.
MovingBody mover(double share, Random& random) {
  MovingBody body;
  body.share = share;
  const double step = 0.02 * std::pow(20, random.uniform());  // 2 to 40 cm from image to image: 3 to 50 px
  const double heading = between(0, 2 * M_PI, random);
  body.translation = step * Vector3d(std::cos(heading), 0.2 * inCube(random).y(), std::sin(heading));
  if (random.uniform() < 0.5) body.rotation = rotationOf(between(0, 3 * kDegree, random), random);
  return body;
}

// Differences of a scene from the ordinary one.

template <typename Value>
Change with(Value Options::*field, Value value) {
  return [=](Options& options, Random&) { options.*field = value; };
}

Change noise(double pixels) {
  return [=](Options& options, Random&) {
    options.noise_px = pixels;
    options.octaves = false;
  };
}

Change outliersAnywhere(double ratio) {
  return [=](Options& options, Random&) {
    options.outlier_ratio = ratio;
    options.outlier_reach = 0;
  };
}

Change displaced(double pixels) {
  return [=](Options& options, Random&) { options = withMedian(medianDisplacement, pixels, options); };
}

Change parallax(double pixels) {
  return [=](Options& options, Random&) { options = withMedian(medianParallax, pixels, options); };
}

Change plane(const Vector3d& normal) {
  return [=](Options& options, Random& random) {
    options.shape = SceneShape::kPlane;
    options.plane_normal = normal.normalized() + 0.1 * inCube(random);
  };
}

Change movers(int count, double share) {
  return [=](Options& options, Random& random) {
    for (int k = 0; k < count; ++k) options.bodies.push_back(mover(share, random));
  };
}

void driveForward(Options& options, Random& random) {
  options.translation = varied(kForward, random);
  options.rotation = varied(kDrivingRotation, random);
}

void rotateOnly(Options& options, Random& random) {
  options.translation = kNone;
  options.rotation = rotationOf(kRotation, random);
}

void stand(Options& options, Random&) { options.translation = options.rotation = kNone; }

/// Rotates during the readout of an image.
void roll(Options& options, Random& random) {
  options.rotation = rotationOf(kReadoutRotation / kReadout, random);
  options.readout = kReadout;
}

/// Matches of one window with the next: points of the scene that seem to have moved by a period of it.
void repeat(Options& options, Random&) {
  MovingBody shifted;
  shifted.share = 0.4;
  shifted.translation = {0.8, 0, 0};
  shifted.everywhere = true;
  options.bodies.push_back(shifted);
  options.informative = false;
}

Options ordinary(Random& random) {
  Options options;
  options.outlier_ratio = 0.1;
  options.outlier_reach = kFilteredReach;
  options.octaves = options.as_measured = true;
  options.translation = varied(options.translation, random);
  options.rotation = varied(options.rotation, random);
  return options;
}

std::vector<DrawnScene> makeScenes() {
  std::vector<DrawnScene> scenes;
  const auto add = [&](std::string name, std::string summary, std::vector<Change> changes) {
    const auto options = [changes = std::move(changes)](Random& random) {
      Options made = ordinary(random);
      for (const Change& change : changes) change(made, random);
      return made;
    };
    scenes.push_back({std::move(name), std::move(summary), options});
  };

  // Well-posed.
  add("general", "a general motion in a volume", {});
  add("general_2000", "the same, 2000 matches", {with(&Options::matches, 2000)});
  add("forward", "1 m forward, points 4 to 12 m away", {driveForward});
  add("near_epipole", "the same, points within a tenth of the image about its middle",
      {driveForward, with(&Options::image_share, 0.3)});
  for (const double percent : {20, 30, 40}) {
    add("background_" + toText(percent), "a general motion, " + toText(percent) + " % of the points 300 to 1000 m away",
        {with(&Options::background, percent / 100)});
  }
  add("outliers_90", "a general motion, 90 % outliers anywhere", {outliersAnywhere(0.9)});
  add("few_25", "a general motion, 25 matches, 30 % outliers anywhere",
      {with(&Options::matches, 25), outliersAnywhere(0.3)});

  // Exact model, few outliers below the threshold: the covariance can be checked against the truth.
  for (const double sigma : {0.2, 0.5, 1., 2.}) {
    add("exact_noise_" + toText(sigma), "median displacement 10 px by the translation, noise " + toText(sigma) + " px",
        {displaced(10), with(&Options::outlier_reach, 0.), noise(sigma)});
  }

  // Small parallax.
  for (const double pixels : {0.1, 0.3, 0.5, 1., 1.5, 2., 3., 5.}) {
    for (const double sigma : {0.1, 0.2, 0.3}) {
      add("parallax_" + toText(pixels) + "_noise_" + toText(sigma),
          "median parallax " + toText(pixels) + " px, noise " + toText(sigma) + " px",
          {parallax(pixels), noise(sigma)});
    }
  }
  for (const double pixels : {1., 1.5, 2., 5.}) {
    add("displacement_" + toText(pixels),
        "median displacement " + toText(pixels) + " px by the translation, noise 0.2 px",
        {displaced(pixels), noise(0.2)});
  }
  add("far", "a general motion, everything 300 to 1000 m away",
      {with(&Options::nearest, 300.), with(&Options::farthest, 1000.)});

  // Rotations.
  for (const double sigma : {0.3, 0.5, 1., 1.5, 2.}) {
    add("rotation_noise_" + toText(sigma), "pure rotation, noise " + toText(sigma) + " px", {rotateOnly, noise(sigma)});
  }
  const Change on_the_spot = with(&Options::translation, kNone), faster = with(&Options::acceleration, 0.5);
  add("rolling_turning", "pure rotation, 2 degrees during the readout of an image", {on_the_spot, roll});
  add("rolling_faster", "pure rotation, 1 degree while the rows of the reference are read and 3 later",
      {on_the_spot, roll, faster});
  add("rolling_driving", "1 m forward, 2 degrees during the readout of an image", {driveForward, roll});
  add("rolling_straight", "the same on a straight way", {driveForward, roll, with(&Options::straight, true)});
  add("rolling_driving_faster", "rolling_driving with 1 degree and 3", {driveForward, roll, faster});

  // Planes.
  add("plane_frontal", "a general motion before a wall", {plane(kFrontal)});
  add("plane_oblique", "the same, 40 degrees oblique", {plane(kOblique)});
  for (const double share : {0.03, 0.3}) {
    add("plane_off_" + toText(100 * share), "the oblique one with " + toText(100 * share) + " % of the points off it",
        {plane(kOblique), with(&Options::off_plane, share)});
  }

  // Wrong calibration.
  for (const double error : {0.01, 0.03, 0.05}) {
    add("focal_" + toText(100 * error),
        "a general motion, focal length " + toText(100 * error) + " % longer than it is said to be",
        {with(&Options::focal_error, error)});
  }
  add("distortion_small", "a general motion, radial distortion of -0.05 left in",
      {with(&Options::radial, Vector2d(-0.05, 0.01))});
  add("distortion_large", "the same, -0.28 and 0.07 as of a wide lens",
      {with(&Options::radial, Vector2d(-0.28, 0.07))});

  // Moving bodies.
  const struct {
    std::string name, summary;
    Change motion;
  } cameras[] = {{"standing", "standing", stand},
                 {"turning", "rotation by 4 degrees", rotateOnly},
                 {"driving", "driving 1 m forward", driveForward}};
  for (const auto& camera : cameras) {
    const auto add_body = [&](double percent, double sigma, const std::string& suffix) {
      add("body_" + toText(percent) + "_" + camera.name + suffix,
          "camera " + camera.summary + ", a body moves on " + toText(percent) + " % of the view, noise " +
              toText(sigma) + " px",
          {camera.motion, with(&Options::noise_px, sigma), movers(1, percent / 100)});
    };
    for (const double percent : {10, 20, 30, 40, 60}) add_body(percent, 0.3, "");
    add_body(40, 1, "_noise_1");
    add("crowd_" + camera.name, "camera " + camera.summary + ", twelve movers of 3 % of the view each",
        {camera.motion, movers(12, 0.03)});
  }

  // Repetition.
  add("repeated_40", "a general motion, 40 % of the points matched a period of 0.8 m beside", {repeat});
  add("repeated_40_wall", "the same before an oblique wall", {plane(kOblique), repeat});
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
