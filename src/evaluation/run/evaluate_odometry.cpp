// `evaluate odometry`: whole sequences through the stream of the node. One record for each image; the reporter measures
// the drift.
#include <algorithm>
#include <map>
#include <memory>
#include <stdexcept>

#include "run/evaluate_commands.h"
#include "run/series.h"
#include "stream/stream_odometry.h"

namespace gms_ransac {

namespace po = boost::program_options;
using nlohmann::json;

namespace {

constexpr char kStereo[] = "stereo";

bool someHave(std::string DatasetFrame::*file, const Dataset& dataset) {
  const std::vector<DatasetFrame>& frames = dataset.frames();
  return std::any_of(frames.begin(), frames.end(), [&](const DatasetFrame& frame) { return !(frame.*file).empty(); });
}

/// The best that the set allows.
std::string usualScale(const Dataset& dataset, double camera_height) {
  if (someHave(&DatasetFrame::right, dataset)) return kStereo;
  if (someHave(&DatasetFrame::depth, dataset)) return "depth";
  return camera_height > 0 ? "ground" : "propagate";
}

OdometryOptions optionsFor(const Dataset& dataset, const std::string& scale, double camera_height,
                           const MatchFilterOptions& core) {
  if (!dataset.intrinsics()) throw std::invalid_argument(dataset.path() + ": no intrinsics, so no odometry");
  OdometryOptions options;
  options.core = core;
  options.camera = *dataset.intrinsics();
  options.camera_height = camera_height;
  const std::map<std::string, ScaleMode> scales = {{kStereo, options.scale},
                                                   {"depth", ScaleMode::kDepth},
                                                   {"ground", ScaleMode::kGround},
                                                   {"propagate", ScaleMode::kPropagate}};
  const auto found = scales.find(scale);
  if (found == scales.end()) {
    throw std::invalid_argument("--scale is '" + scale + "'; it must be stereo, depth, ground or propagate");
  }
  options.scale = found->second;
  if (options.scale == ScaleMode::kGround && camera_height <= 0) {
    throw std::invalid_argument("--scale ground needs --camera-height");
  }
  if (scale == "depth" && !someHave(&DatasetFrame::depth, dataset)) {
    throw std::invalid_argument(dataset.path() +
                                ": no depth images are read, as --scale depth needs; give a TUM folder");
  }
  if (scale != kStereo) return options;
  if (!dataset.rightCamera()) {
    throw std::invalid_argument(dataset.path() + ": has no image_1/ with its P1 in calib.txt, as --scale stereo needs");
  }
  options.right = dataset.rightCamera()->intrinsics;
  options.baseline = dataset.rightCamera()->baseline;
  return options;
}

/// Throws unless the set has a pose of an image, or `out` is to hold the poses of the stream alone.
void requireTruth(const Dataset& dataset, const std::string& out) {
  const auto known = [](const DatasetFrame& frame) { return frame.pose.has_value(); };
  if (!out.empty() || std::any_of(dataset.frames().begin(), dataset.frames().end(), known)) return;
  throw std::invalid_argument(dataset.path() +
                              ": has no truth to measure the drift against (poses.txt, groundtruth.txt, or tf from "
                              "world, map or odom to the camera); --out FILE records the poses alone");
}

/// The upper three rows of a pose.
std::vector<double> numbersOf(const Eigen::Isometry3d& pose) {
  const Eigen::Matrix<double, 3, 4, Eigen::RowMajor> rows = pose.matrix().topRows<3>();
  return {rows.data(), rows.data() + rows.size()};
}

json recordOf(size_t number, const Dataset& dataset, const DatasetFrame& frame, const std::string& scale,
              const OdometryAnswer& answer) {
  json record = {{"number", number},
                 {"set", dataset.name()},
                 {"scale", scale},
                 {"stamp", frame.stamp},
                 {"text", answer.text},
                 {"known", answer.known},
                 {"pose", numbersOf(answer.pose)},
                 {"truth", nullptr},
                 {"pair", nullptr},
                 {"ms", 1e3 * answer.seconds}};
  if (frame.pose) record["truth"] = numbersOf(*frame.pose);
  if (answer.reference_stamp) {
    Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
    motion.linear() = answer.pair.R;
    motion.translation() = answer.pair.t;
    const Covariance6d& c = answer.pair.covariance;
    record["pair"] = {{"reference_stamp", *answer.reference_stamp},
                      {"metric", answer.metric},
                      {"motion", numbersOf(motion)},
                      {"covariance", std::vector<double>(c.data(), c.data() + c.size())}};
  }
  return record;
}

}  // namespace

int evaluateOdometry(const Arguments& arguments) {
  CommandLine line({"odometry"});
  std::vector<std::string> peers;
  std::string scale, out;
  double camera_height = 0;
  auto add = line.options.add_options();
  add("scale", po::value(&scale),
      "stereo, depth, ground or propagate; default: the first of them that the set allows, ground if --camera-height "
      "is given");
  add("camera-height", withDefault(camera_height), "metres above the ground, for --scale ground");
  add("peer", po::value(&peers)->composing(),
      "poses of another system for the table and the plot, once for each set in their order: 12 numbers a line and "
      "image (KITTI), or stamp tx ty tz qx qy qz qw (TUM)");
  add("out,o", po::value(&out), "file for the records, one JSON object a line");
  line.addForReport("plot", "file for a plot (.png, .pdf) of the paths, and of the error over the length");
  const char* usage =
      "evaluate odometry SET... [options]\n\nSET: a KITTI odometry or TUM folder, or a .bag. Chains the answers of the "
      "node over each\nsequence and prints the drift: KITTI's errors, errors over a second, ATE.";
  if (!line.parse(arguments, usage)) return 0;
  if (line.folders.empty()) throw std::invalid_argument("no set given; see evaluate odometry --help");
  const MatchFilterOptions core = line.pipelines().front();
  const std::vector<MeasuredSet> sets = line.sets();
  if (!peers.empty() && peers.size() != sets.size()) {
    throw std::invalid_argument("--peer is given " + std::to_string(peers.size()) + " times for " +
                                std::to_string(sets.size()) + " sets; give it once for each");
  }
  for (const std::string& peer : peers) line.report.insert(line.report.end(), {"--peer", peer});
  std::vector<Series> all;
  for (size_t number = 0; number < sets.size(); ++number) {
    const Dataset& dataset = sets[number].dataset;
    if (!dataset.stamp(0)) throw std::invalid_argument(dataset.path() + ": a list of pairs is no sequence");
    const std::string chosen = scale.empty() ? usualScale(dataset, camera_height) : scale;
    const OdometryOptions of_set = optionsFor(dataset, chosen, camera_height, core);
    requireTruth(dataset, out);
    all.push_back({dataset.name(), dataset.frames().size(), [=, &dataset] {
                     const auto odometry = std::make_shared<StreamOdometry>(of_set);
                     return [=, &dataset](size_t image) {
                       const DatasetFrame& frame = dataset.frames()[image];
                       const int index = static_cast<int>(image);
                       OdometryImages images = {frame.stamp, dataset.image(index), {}, {}};
                       if (chosen == kStereo) images.right = dataset.right(index);
                       if (chosen == "depth") images.depth = dataset.depth(index);
                       return Records{recordOf(number, dataset, frame, chosen, odometry->add(images))};
                     };
                   }});
  }
  return stream(all, "image", line.report, out);
}

}  // namespace gms_ransac
