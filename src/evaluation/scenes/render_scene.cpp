// Program: renders a textured 3-D scene with exact poses and depth, to a folder in TUM layout or to a bag.
#include <filesystem>
#include <initializer_list>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>

#include <boost/lexical_cast.hpp>
#include <boost/program_options.hpp>

#include "program.h"
#include "scenes/scene_writer.h"

namespace {

namespace po = boost::program_options;
using namespace gms_ransac;

std::vector<double> parseNumbers(const std::string& text, const std::string& option) {
  std::vector<double> numbers;
  for (const std::string& word : splitAtCommas({text})) {
    if (!boost::conversion::try_lexical_convert(word, numbers.emplace_back())) {
      throw std::invalid_argument(option + ": '" + word + "' is not a number");
    }
  }
  return numbers;
}

/// x,y,z,qx,qy,qz,qw or the rows of a matrix, with or without its last one.
Eigen::Isometry3d parseTransform(const std::string& text, const std::string& option) {
  const std::vector<double> n = parseNumbers(text, option);
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  if (n.size() == 7) {
    transform.translation() << n[0], n[1], n[2];
    transform.linear() = Eigen::Quaterniond(n[6], n[3], n[4], n[5]).toRotationMatrix();
  } else if (n.size() == 12 || n.size() == 16) {
    transform.affine() = Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(n.data());
  } else {
    throw std::invalid_argument(option + ": expected x,y,z,qx,qy,qz,qw or the 12 or 16 numbers of a matrix, found " +
                                std::to_string(n.size()));
  }
  constexpr double kRounding = 0.01;
  if (!transform.linear().isUnitary(kRounding) || transform.linear().determinant() < 0)
    throw std::invalid_argument(option + ": not a rotation; give a quaternion of unit length or a matrix row by row");
  transform.linear() = Eigen::Quaterniond(transform.linear()).normalized().toRotationMatrix();
  return transform;
}

/// Throws std::invalid_argument about the first of these options that is given.
void refuse(const po::variables_map& given, std::initializer_list<const char*> options, const std::string& why) {
  for (const char* option : options) {
    if (given.count(option) > 0 && !given[option].defaulted())
      throw std::invalid_argument("--" + std::string(option) + " " + why);
  }
}

/// Sets the trajectory and the IMU on its camera by the options.
void setMotion(const po::variables_map& given, TrajectoryOptions trajectory, SceneOptions& scene) {
  if (given.count("camera-in-imu") > 0) {
    scene.imu.camera_in_imu = parseTransform(given["camera-in-imu"].as<std::string>(), "--camera-in-imu");
    trajectory.camera_in_imu = scene.imu.camera_in_imu;
  }
  if (scene.imu.rate == 0) {
    refuse(given, {"gyro-noise", "accelerometer-noise", "gyro-walk", "accelerometer-walk", "imu-delay"},
           "needs --imu-rate");
  }
  if (trajectory.file.empty()) {
    if (scene.imu.rate == 0) refuse(given, {"camera-in-imu"}, "needs --imu-rate or --trajectory");
    return refuse(given, {"pose-rate", "from", "duration", "scale", "poses-of"}, "needs --trajectory");
  }
  refuse(given, {"step", "turn", "sway"}, "has no effect with --trajectory");
  if (given.count("poses-of") > 0) {
    const std::string body = given["poses-of"].as<std::string>();
    if (body != "camera" && body != "imu")
      throw std::invalid_argument("--poses-of is '" + body + "'; it must be camera or imu");
    trajectory.imu = body == "imu";
  }
  scene.trajectory = std::make_shared<Trajectory>(readTrajectory(trajectory));
}

int renderScene(const Arguments& arguments) {
  SceneOptions scene_options;
  int frames = 90;
  std::string out, distortion;
  TrajectoryOptions trajectory;
  ImuOptions& imu = scene_options.imu;
  po::options_description options;
  auto add = options.add_options();
  add("frames,n", withDefault(frames), "frames to render; of a trajectory all");
  add("scene", withDefault(scene_options.scene), "room or street");
  add("width", withDefault(scene_options.size.width), "pixels");
  add("height", withDefault(scene_options.size.height), "pixels");
  add("focal-length", withDefault(scene_options.focal_length), "pixels; 0: 525 per 640 of width");
  add("distortion", po::value(&distortion), "plumb_bob k1,k2,p1,p2[,k3]; default none");
  add("step", withDefault(scene_options.step),
      "metres of path per frame; negative: 0.08 in the room, 0.3 in the street; 0: the camera only rotates");
  add("turn", withDefault(scene_options.turn), "additional heading per frame, degrees");
  add("sway", withDefault(scene_options.sway), "factor on the slow hand motion, 0..3");
  add("offset", withDefault(scene_options.offset),
      "metres that the camera is moved to its right: once without and once with it, a stereo pair");
  add("rate", withDefault(scene_options.rate), "frames per second");
  add("grey", po::bool_switch(), "grey images instead of colour");
  add("noise", withDefault(scene_options.noise), "standard deviation, grey levels");
  add("blur", withDefault(scene_options.blur), "standard deviation, pixels");
  add("movers", withDefault(scene_options.movers), "boards that sway before the camera by themselves");
  add("repetition", withDefault(scene_options.repetition), "textures repeat themselves after so many metres; 0: not");
  add("readout", withDefault(scene_options.readout),
      "rolling shutter: share of the time between frames in which the rows are read");
  add("exposure", withDefault(scene_options.exposure),
      "motion blur: share of the time between frames in which the shutter is open");
  add("brightness", withDefault(scene_options.brightness), "factor on the image before its noise, 0..1");
  add("seed", withDefault(scene_options.seed), "of textures, furniture and noise");
  add("trajectory", po::value(&trajectory.file),
      "file of poses to move along: TUM's text, KITTI's text or EuRoC's CSV. The path is moved into the scene, whose "
      "room grows until it holds it. z of the file's world points up (KITTI: y down)");
  add("pose-rate", withDefault(trajectory.pose_rate), "poses per second of KITTI's text");
  add("from", withDefault(trajectory.from), "seconds of the trajectory to leave out");
  add("duration", withDefault(trajectory.duration), "seconds of the trajectory; 0: to its end");
  add("scale", withDefault(trajectory.scale), "factor on the positions of the trajectory");
  add("poses-of", po::value<std::string>(), "camera or imu; default: imu in EuRoC's CSV, else camera");
  add("camera-in-imu", po::value<std::string>(),
      "x,y,z,qx,qy,qz,qw or a matrix row by row (EuRoC's T_BS of the camera); default: both have the same axes");
  add("imu-rate", withDefault(imu.rate), "samples per second of an IMU: /imu in a bag, imu.csv in a folder; 0: none");
  add("gyro-noise", withDefault(imu.gyro_noise), "rad/s/sqrt(Hz)");
  add("accelerometer-noise", withDefault(imu.accelerometer_noise), "m/s^2/sqrt(Hz)");
  add("gyro-walk", withDefault(imu.gyro_walk), "random walk of the bias, rad/s^2/sqrt(Hz)");
  add("accelerometer-walk", withDefault(imu.accelerometer_walk), "random walk of the bias, m/s^3/sqrt(Hz)");
  add("imu-delay", withDefault(imu.delay), "seconds by which the stamps of the IMU are late");
  const char* usage =
      "render_scene OUT [options]\n\nRenders a textured 3-D scene seen from a moving camera. OUT is a folder (TUM "
      "layout:\nrgb.txt, depth.txt, groundtruth.txt, camera.txt) or a file that ends in .bag (topics of the\nofficial "
      "TUM bags). Poses, depth and intrinsics are exact.\n\n"
      "The camera follows a path of the scene, or poses that were recorded:\n"
      "  render_scene flight.bag --trajectory state_groundtruth_estimate0/data.csv \\\n"
      "    --camera-in-imu 0.015,-1.000,0.004,-0.022,1.000,0.015,0.026,-0.065,-0.026,0.004,1.000,0.010 --imu-rate 200";
  const auto given = parseCommandLine(arguments, usage, options, {{"out", 1, po::value(&out)}});
  if (!given) return 0;
  if (out.empty()) throw std::invalid_argument("no output given; see render_scene --help");
  requireAtLeastOne({{"--frames", frames}});
  scene_options.colour = !(*given)["grey"].as<bool>();
  scene_options.distortion = parseNumbers(distortion, "--distortion");

  setMotion(*given, trajectory, scene_options);

  const Scene scene(scene_options);
  if (scene_options.trajectory && (*given)["frames"].defaulted()) frames = std::max(1, scene.frameCount());
  if (frames > scene.frameCount()) {
    throw std::invalid_argument("--frames is " + std::to_string(frames) + "; the path ends after " +
                                std::to_string(scene.frameCount()) + " frames" +
                                (scene_options.trajectory ? "" : " of this step"));
  }
  scene.requireFreePath(frames);
  watchInterrupts();
  Progress progress("rendering frame", frames);
  const bool bag = std::filesystem::path(out).extension() == ".bag";
  (bag ? writeBag : writeTumFolder)(scene, frames, out, [&progress] { progress.advanceUnlessInterrupted(); });
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return gms_ransac::runProgram(argc, argv, renderScene); }
