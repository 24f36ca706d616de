#include "scenes/scene_writer.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include <opencv2/imgcodecs.hpp>

namespace gms_ransac {

namespace {

namespace fs = std::filesystem;

constexpr double kDepthUnitsPerMetre = 5000;  // of TUM's depth images

std::ofstream openText(const fs::path& path) {
  std::ofstream file(path.string());
  if (!file) throw std::runtime_error(path.string() + ": cannot be written");
  return file;
}

void writeImageFile(const fs::path& path, const cv::Mat& image) {
  if (!cv::imwrite(path.string(), image)) throw std::runtime_error(path.string() + ": cannot be written");
}

/// EuRoC's imu0/data.csv.
void writeImuFile(const std::vector<ImuSample>& samples, const fs::path& path) {
  std::ofstream file = openText(path);
  file.precision(12);
  file << "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],a_RS_S_y [m "
          "s^-2],a_RS_S_z [m s^-2]\n";
  for (const ImuSample& sample : samples) {
    file << std::llround(sample.time * 1e9);
    for (const Eigen::Vector3d& vector : {sample.angular_velocity, sample.specific_force})
      file << ',' << vector.x() << ',' << vector.y() << ',' << vector.z();
    file << '\n';
  }
}

}  // namespace

void writeTumFolder(const Scene& scene, int frames, const std::string& folder, const std::function<void()>& written) {
  const fs::path root(folder);
  std::error_code failure;
  for (const char* name : {"rgb", "depth"}) {
    fs::create_directories(root / name, failure);
    if (!fs::is_directory(root / name)) throw std::runtime_error((root / name).string() + ": cannot be made");
  }
  const CameraIntrinsics& k = scene.intrinsics();
  std::ofstream camera = openText(root / "camera.txt");
  camera.precision(10);
  camera << k.fx << ' ' << k.fy << ' ' << k.cx << ' ' << k.cy;
  for (double d : k.distortion) camera << ' ' << d;
  camera << '\n';
  std::ofstream rgb = openText(root / "rgb.txt"), depth = openText(root / "depth.txt");
  std::ofstream truth = openText(root / "groundtruth.txt");
  truth.precision(12);
  rgb << "# colour images of a rendered scene\n# timestamp filename\n";
  depth << "# depth images of a rendered scene, " << kDepthUnitsPerMetre << " to the metre\n# timestamp filename\n";
  truth << "# exact camera poses of a rendered scene\n# timestamp tx ty tz qx qy qz qw\n";
  if (scene.options().imu.rate > 0) writeImuFile(scene.imuSamples(frames), root / "imu.csv");
  for (int i = 0; i < frames; ++i) {
    const RenderedFrame frame = scene.render(i);
    const std::string stamp = std::to_string(frame.stamp);
    cv::Mat depth_units = frame.depth.clone();
    // Beyond 13.1 m the 16 bits end: unknown, as in TUM's files.
    depth_units.setTo(0, depth_units > 65535 / kDepthUnitsPerMetre);
    depth_units.convertTo(depth_units, CV_16U, kDepthUnitsPerMetre);
    writeImageFile(root / "rgb" / (stamp + ".png"), frame.image);
    writeImageFile(root / "depth" / (stamp + ".png"), depth_units);
    rgb << stamp << " rgb/" << stamp << ".png\n";
    depth << stamp << " depth/" << stamp << ".png\n";
    const Eigen::Quaterniond q(frame.camera_pose.linear());
    const Eigen::Vector3d t = frame.camera_pose.translation();
    truth << stamp;
    for (const double value : {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()}) truth << ' ' << value;
    truth << '\n';
    written();
  }
}

}  // namespace gms_ransac
