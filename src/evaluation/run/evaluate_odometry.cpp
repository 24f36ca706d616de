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
  throw std::invalid_argument(
      dataset.path() +
      ": has no truth to measure the drift against (poses.txt, groundtruth.txt, or tf from "
      "world, map or odom to the camera); --witness FILE gives one, --out FILE records the poses alone");
}

/// The upper three rows of a pose.
std::vector<double> numbersOf(const Eigen::Isometry3d& pose) {
  const Eigen::Matrix<double, 3, 4, Eigen::RowMajor> rows = pose.matrix().topRows<3>();
  return {rows.data(), rows.data() + rows.size()};
}

template <typename Derived>
std::vector<double> numbersOf(const Eigen::MatrixBase<Derived>& matrix) {
  const Eigen::MatrixXd values = matrix;
  return {values.data(), values.data() + values.size()};
}

/// Noise of the true motion since an earlier image of the set, without that of the alignment of its axes; null without
/// truth.
json noiseSince(double stamp, const MeasuredSet& set, const DatasetFrame& frame) {
  const std::vector<DatasetFrame>& frames = set.dataset.frames();
  const auto isEarlier = [](const DatasetFrame& a, double b) { return a.stamp < b; };
  // Stamps of the node are rounded to nanoseconds.
  const auto since = std::lower_bound(frames.begin(), frames.end(), stamp - 1e-6, isEarlier);
  if (since == frames.end() || !since->pose || !frame.pose) return nullptr;
  DatasetPair pair;
  pair.reference = static_cast<int>(since - frames.begin());
  pair.current = static_cast<int>(&frame - frames.data());
  TruthNoise noise = set.noise;
  noise.alignment = 0;
  const PairNoise of_pair(noise, clockStep(set.dataset, pair, noise.clock),
                          Eigen::Isometry3d(since->pose->matrix().inverse() * frame.pose->matrix()));
  return {{"rotation", numbersOf(of_pair.rotation)}, {"translation", numbersOf(of_pair.translation)}};
}

json recordOf(size_t number, const MeasuredSet& set, const DatasetFrame& frame, const std::string& scale,
              const OdometryAnswer& answer) {
  json record = {{"number", number},
                 {"set", set.dataset.name()},
                 {"scale", scale},
                 {"stamp", frame.stamp},
                 {"text", answer.text},
                 {"known", answer.known},
                 {"pose", numbersOf(answer.pose)},
                 {"covariance", numbersOf(answer.covariance)},
                 {"truth", nullptr},
                 {"alignment", set.noise.alignment},
                 {"pair", nullptr},
                 {"twist", nullptr},
                 {"parts", json::array()},
                 {"ms", 1e3 * answer.seconds}};
  if (frame.pose) record["truth"] = numbersOf(*frame.pose);
  if (answer.reference_stamp) {
    Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
    motion.linear() = answer.pair.R;
    motion.translation() = answer.pair.t;
    record["pair"] = {{"reference_stamp", *answer.reference_stamp},
                      {"metric", answer.metric},
                      {"motion", numbersOf(motion)},
                      {"covariance", numbersOf(answer.pair.covariance)},
                      {"noise", noiseSince(*answer.reference_stamp, set, frame)}};
  }
  if (answer.twist) {
    record["twist"] = {{"velocity", numbersOf(answer.twist->velocity)},
                       {"covariance", numbersOf(answer.twist->covariance)}};
  }
  for (const OdometryPart& part : answer.parts) {
    record["parts"].push_back({{"from", part.from_stamp},
                               {"length", part.length},
                               {"unit", part.metres ? "m" : "s"},
                               {"motion", numbersOf(part.motion)},
                               {"covariance", numbersOf(part.covariance)},
                               {"noise", noiseSince(part.from_stamp, set, frame)}});
  }
  return record;
}

/// Adds an option that is given for no set, or for each, to the arguments of the reporter.
void giveOnceForEach(const std::string& option, const std::vector<std::string>& given, size_t sets,
                     std::vector<std::string>& report) {
  if (!given.empty() && given.size() != sets) {
    throw std::invalid_argument(option + " is given " + std::to_string(given.size()) + " times for " +
                                std::to_string(sets) + " sets; give it once for each");
  }
  for (const std::string& value : given) report.insert(report.end(), {option, value});
}

}  // namespace

int evaluateOdometry(const Arguments& arguments) {
  CommandLine line({"odometry"});
  std::vector<std::string> peers, witnesses;
  std::string scale, out;
  double camera_height = 0, systematic_sigma = 0;
  int leave_out = 0;
  auto add = line.options.add_options();
  add("scale", po::value(&scale),
      "stereo, depth, ground or propagate; default: the first of them that the set allows, ground if --camera-height "
      "is given");
  add("camera-height", withDefault(camera_height), "metres above the ground, for --scale ground");
  add("peer", po::value(&peers)->composing(),
      "poses of another system for the table and the plot, once for each set in their order: 12 numbers a line and "
      "image (KITTI), or stamp tx ty tz qx qy qz qw (TUM)");
  add("witness", po::value(&witnesses)->composing(),
      "poses of a second truth, as those of --peer, of the same camera or fixed to it (--align)");
  line.addForReport("witness-noise",
                    "standard deviations of a pose of the witness, METRES,DEGREES; default 0.015,0.017: "
                    "registered LiDAR scans");
  add("leave-out", withDefault(leave_out),
      "images at the start of each set that are not measured (KITTI's truth has interpolated rotations there)");
  line.addFlagForReport("align",
                        "print all a second time, with the constant rotation between the axes of truth and "
                        "camera fitted out");
  add("systematic-sigma", po::value(&systematic_sigma), "as ~systematic_sigma of the node");
  add("out,o", po::value(&out), "file for the records, one JSON object a line");
  line.addForReport("plot",
                    "file for a plot (.png, .pdf) of the paths, and of the error over the length; needs "
                    "python3-matplotlib");
  const char* usage =
      "evaluate odometry SET... [options]\n\nSET: a KITTI odometry or TUM folder, or a .bag. Chains the answers of the "
      "node over each\nsequence and prints the drift (KITTI's errors, errors over a second, ATE) and the NEES of its "
      "covariances.";
  if (!line.parse(arguments, usage)) return 0;
  if (line.folders.empty()) throw std::invalid_argument("no set given; see evaluate odometry --help");
  const MatchFilterOptions core = line.pipelines().front();
  const std::vector<MeasuredSet> sets = line.sets();
  giveOnceForEach("--peer", peers, sets.size(), line.report);
  giveOnceForEach("--witness", witnesses, sets.size(), line.report);
  if (leave_out < 0)
    throw std::invalid_argument("--leave-out is " + std::to_string(leave_out) + "; it must not be negative");
  line.report.insert(line.report.end(), {"--leave-out", std::to_string(leave_out)});
  std::vector<Series> all;
  for (size_t number = 0; number < sets.size(); ++number) {
    const MeasuredSet& set = sets[number];
    const Dataset& dataset = set.dataset;
    if (!dataset.stamp(0)) throw std::invalid_argument(dataset.path() + ": a list of pairs is no sequence");
    const std::string chosen = scale.empty() ? usualScale(dataset, camera_height) : scale;
    OdometryOptions of_set = optionsFor(dataset, chosen, camera_height, core);
    if (line.given("systematic-sigma")) of_set.systematic_sigma = systematic_sigma;
    if (witnesses.empty()) requireTruth(dataset, out);
    all.push_back({dataset.name(), dataset.frames().size(), [=, &set, &dataset] {
                     const auto odometry = std::make_shared<StreamOdometry>(of_set);
                     return [=, &set, &dataset](size_t image) {
                       const DatasetFrame& frame = dataset.frames()[image];
                       const int index = static_cast<int>(image);
                       OdometryImages images = {frame.stamp, dataset.image(index), {}, {}, frame.depth_stamp};
                       if (chosen == kStereo) images.right = dataset.right(index);
                       if (chosen == "depth") images.depth = dataset.depth(index);
                       return Records{recordOf(number, set, frame, chosen, odometry->add(images))};
                     };
                   }});
  }
  return stream(all, "image", line.report, out);
}

}  // namespace gms_ransac
