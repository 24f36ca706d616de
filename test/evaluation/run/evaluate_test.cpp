// The program `evaluate` as its users see it: exit status and sentence for bad input, records, scores, and tables that
// do not depend on how their work was cut into pieces.
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "run_program.h"
#include "scenes/scene.h"
#include "scratch_folder.h"
#include "shared_data.h"

namespace gms_ransac {
namespace {

namespace fs = std::filesystem;

std::string textOf(const std::string& file) {
  std::ifstream stream(file);
  std::stringstream text;
  text << stream.rdbuf();
  return text.str();
}

std::vector<nlohmann::json> readLines(const std::string& file) {
  std::vector<nlohmann::json> lines;
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) lines.push_back(nlohmann::json::parse(line));
  return lines;
}

class EvaluateTest : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_.path(name); }
  Outcome evaluate(const std::string& arguments) const { return run(PROGRAMS "/evaluate " + arguments); }
  void write(const std::string& name, const std::string& text) const { folder_.write(name, text); }

  /// Views of a textured plane: image k is image 0 moved by `step`^k; the list pairs neighbours with their homography.
  void writePlane(int images, const cv::Matx33d& step) const {
    cv::Mat noise(300, 400, CV_8UC1), texture;
    cv::RNG(1).fill(noise, cv::RNG::UNIFORM, 0, 256);
    cv::GaussianBlur(noise, noise, cv::Size(), 2.0);
    cv::normalize(noise, texture, 0, 255, cv::NORM_MINMAX);
    fs::create_directories(path("set"));
    std::ofstream list(path("set/pairs.txt")), H(path("set/H"));
    for (int row = 0; row < 3; ++row) H << step(row, 0) << ' ' << step(row, 1) << ' ' << step(row, 2) << '\n';
    cv::Matx33d motion = cv::Matx33d::eye();
    for (int k = 0; k < images; ++k) {
      cv::Mat view;
      cv::warpPerspective(texture, view, motion, texture.size());
      cv::imwrite(path("set/" + std::to_string(k) + ".png"), view);
      if (k > 0) list << k - 1 << ".png " << k << ".png H=H\n";
      motion = step * motion;
    }
  }

  const ScratchFolder folder_;
};

const cv::Matx33d kStep(0.995, -0.03, 9, 0.03, 0.995, -6, 0, 0, 1);

TEST_F(EvaluateTest, BadInputIsOneClearLineAndStatusTwo) {
  write("set/pairs.txt", "a.png b.png\n");
  write("set/a.png", "not a picture");
  fs::create_directories(path("empty"));
  write("broken/rgb.txt", "1 a.png\n2 b.png\n");
  write("broken/camera.txt", "500 500 x 240\n");
  write("room/rgb.txt", "1 a.png\n2 b.png\n");
  write("room/camera.txt", "500 500 320 240\n");
  const std::string run = "evaluate run " + path("set"), tables = "evaluate tables " + path("set");
  const std::map<std::string, std::string> complaints = {
      {"evaluate", "no command given"},
      {"evaluate fly", "unknown command 'fly'"},
      {"evaluate run", "neither a folder nor --scenes given"},
      {"evaluate run " + path("none"), "none: no such folder or bag"},
      {"evaluate run " + path("empty"), "holds neither rgb.txt (TUM), image_0/ (KITTI) nor pairs.txt"},
      {run, "a.png: cannot be read as an image"},
      {"evaluate run " + path("broken"), "camera.txt:1: 'x' is not a finite number"},
      {run + " --method nonsense", "unknown method 'nonsense'"},
      {run + " --method lo_prosac,nonsense", "unknown method 'nonsense'"},
      {"evaluate sweep --method cp_ransac,nonsense", "unknown method 'nonsense'"},
      {run + " --model sphere", "--model is 'sphere'; it must be one of 'essential'"},
      {run + " --gap 0", "--gaps holds '0'; it takes whole numbers from 1 on"},
      {run + " --repeat 0", "--repeat is 0; it must be at least 1"},
      {run + " --features 0", "--features is '0'; it must be a whole number between 1 and 100000"},
      {run + " --sort-key beauty", "--sort-key is 'beauty'"},
      {"evaluate sweep --gms-border nowhere", "--gms-border is 'nowhere'"},
      {run + " --unheard-of", "unheard-of"},
      {run + " --stri 2", "unrecognised option '--stri'"},
      {"dataset_to_bag " + path("set") + " " + path("set.bag") + " --camera right", "unrecognised option '--camera'"},
      {"benchmark --pair 1", "unrecognised option '--pair'"},
      {"evaluate tables", "no folder or bag given"},
      {tables + " --shard 3/2", "--shard is '3/2'"},
      {tables + " --presets 10,many", "--presets holds 'many'"},
      {tables + " --ratios 1/2,3/2", "--ratios holds '3/2'"},
      {tables + " --features 500", "--features is varied by the tables"},
      {"evaluate trust", "neither a folder nor --scenes given"},
      {"evaluate trust " + path("empty"), "holds neither rgb.txt (TUM), image_0/ (KITTI) nor pairs.txt"},
      {"evaluate trust --scenes unheard_of", "--scenes holds 'unheard_of'"},
      {"evaluate trust --scenes general --gaps 1,x", "--gaps holds 'x'"},
      {"evaluate trust --scenes general --truth-rotation-sigma -1", "--truth-rotation-sigma must not be negative"},
      {"evaluate odometry", "no set given"},
      {"evaluate odometry " + path("set"), "a list of pairs is no sequence"},
      {"evaluate odometry " + path("room") + " --scale fast", "--scale is 'fast'; it must be stereo, depth, ground"},
      {"evaluate odometry " + path("room") + " --scale stereo", "room: has no image_1/"},
      {"evaluate odometry " + path("room") + " --scale ground", "--scale ground needs --camera-height"},
      {"evaluate odometry " + path("room") + " --scale depth", "no depth images are read, as --scale depth needs"},
      {"evaluate odometry " + path("room") + " --peer a --peer b", "--peer is given 2 times for 1 sets"},
      {"evaluate odometry " + path("room"), "room: has no truth to measure the drift against"},
      {"evaluate odometry " + path("room") + " --witness a --witness b", "--witness is given 2 times for 1 sets"},
      {"evaluate odometry " + path("room") + " --leave-out -1", "--leave-out is -1; it must not be negative"},
      {"evaluate merge " + path("empty"), "holds no plan.json"},
      {"benchmark " + path("none"), "none: no such folder or bag"},
      {"benchmark --features many", "--features holds 'many'"},
      {"benchmark --features 0", "--features holds '0'"},
      {"benchmark --threads some", "--threads holds 'some'"},
      {"benchmark --model homography", "--model is homography"},
      {"benchmark --method unheard_of", "unknown method 'unheard_of'"},
      {"benchmark --pairs 0", "--pairs is 0; it must be at least 1"},
      {"benchmark --out /no/such/folder/file", "cannot write /no/such/folder/file"},
      {"benchmark --unknown", "unknown"}};
  for (const auto& [command, complaint] : complaints) {
    const Outcome outcome = gms_ransac::run(PROGRAMS "/" + command);
    EXPECT_EQ(outcome.status, 2) << command << "\n" << outcome.text;
    EXPECT_NE(outcome.text.find(complaint), std::string::npos) << command << "\n" << outcome.text;
  }
}

TEST_F(EvaluateTest, SaysThatRowsAreLeftAsTheyAreWhereThereAreNoStamps) {
  writePlane(2, kStep);
  for (const std::string& command :
       {"run " + path("set"), "trust " + path("set") + " --no-report --out " + path("trust"),
        "tables " + path("set") + " --presets 300 --repeat 1 --pairs 1 --no-plots --out " + path("tables")}) {
    const std::string sentence = "has no stamps, so --rolling-shutter-readout is not applied";
    const Outcome asked = evaluate(command + " --method lo_prosac --rolling-shutter-readout 0.02");
    const size_t at = asked.text.find(sentence);
    ASSERT_NE(at, std::string::npos) << command << "\n" << asked.text;
    EXPECT_EQ(asked.text.find(sentence, at + 1), std::string::npos) << "once";
  }
}

TEST_F(EvaluateTest, RunTellsCalibrationProgressAndColumnsAndDraws) {
  writePlane(3, kStep);
  write("set/camera.txt", "400 401 200 150\n");
  const Outcome outcome = evaluate("run " + path("set") + " --features 500 --plot " + path("plot.png"));
  ASSERT_EQ(outcome.status, 0) << outcome.text;
  for (const char* sentence : {"calibration of camera.txt: fx 400, fy 401, cx 200, cy 150, no distortion",
                               "evaluating pair 2/2, ", " a second, 0:00:0", "OK low failed pairs with status OK"}) {
    EXPECT_NE(outcome.text.find(sentence), std::string::npos) << outcome.text;
  }
  EXPECT_FALSE(cv::imread(path("plot.png")).empty());
}

TEST_F(EvaluateTest, AnInterruptedRunPrintsTheTableOfWhatIsThere) {
  writePlane(30, kStep);
  const std::string records = path("records.jsonl");
  const Outcome outcome =
      run("{ " PROGRAMS "/evaluate run " + path("set") + " --repeat 100 --out " + records +
          " & for i in $(seq 600); do [ -s " + records + " ] && break; sleep 0.1; done; kill -INT $!; wait $!; }");
  EXPECT_EQ(outcome.status, 130) << outcome.text;
  for (const char* text : {"left\n", "of 29 pairs\n", "\nlo_prosac "}) {
    EXPECT_NE(outcome.text.find(text), std::string::npos) << outcome.text;
  }
}

TEST_F(EvaluateTest, ListsEveryMethodAndExplainsItself) {
  const Outcome list = evaluate("--list");
  EXPECT_EQ(list.status, 0);
  for (const char* method : {"ransac", "gms_ransac", "cp_ransac", "lo_prosac"}) {
    EXPECT_NE(list.text.find(method), std::string::npos);
  }
  for (const char* command : {"", "run ", "tables ", "trust ", "odometry ", "merge "}) {
    const Outcome help = evaluate(std::string(command) + "--help");
    EXPECT_EQ(help.status, 0);
    EXPECT_NE(help.text.find("evaluate"), std::string::npos);
    const bool plots = help.text.find("--plot ") != std::string::npos;
    EXPECT_EQ(help.text.find("python3-matplotlib") != std::string::npos, plots) << help.text;
  }
}

TEST_F(EvaluateTest, RecordsFollowTheFormatAndTheTruth) {
  writePlane(4, kStep);
  const std::string command =
      "run " + path("set") +
      " --method gms_ransac,cp_ransac --model homography --features 800 --repeat 2 --seed 5 --out ";
  const Outcome outcome = evaluate(command + path("a.jsonl"));
  ASSERT_EQ(outcome.status, 0) << outcome.text;
  const auto records = readLines(path("a.jsonl"));
  ASSERT_EQ(records.size(), 3u * 2u * 2u) << "pairs, methods, repeats";
  for (const auto& record : records) {
    for (const char* key : {"method", "model", "reference", "current", "features", "keypoints_reference",
                            "keypoints_current", "matches_raw", "matches_gms", "inliers", "hypotheses", "status", "R",
                            "t", "metric_scale", "times_ms", "correspondences"}) {
      EXPECT_TRUE(record.contains(key)) << key;
    }
    EXPECT_TRUE(record["R"].is_null()) << "no intrinsics, no pose";
    EXPECT_EQ(record["status"], "UNCALIBRATED");
    EXPECT_EQ(record["correspondences"].size(), record["inliers"].get<size_t>());
    EXPECT_TRUE(record["covariance"].is_null());
    EXPECT_GT(record["sigma_px"].get<double>(), 0);
    ASSERT_GT(record["inliers"].get<int>(), 50);
    int correct = 0;
    for (const auto& row : record["correspondences"]) {
      ASSERT_EQ(row.size(), 6u);
      EXPECT_GE(row[5].get<double>(), 0);
      EXPECT_LE(row[5].get<double>(), 1);
      const cv::Vec3d p(row[0], row[1], 1), q = kStep * p;
      correct += std::hypot(q[0] / q[2] - row[2].get<double>(), q[1] / q[2] - row[3].get<double>()) < 3;
    }
    EXPECT_EQ(record["truth"]["transfer"]["kept_correct"], correct);
    EXPECT_GT(correct, 0.95 * record["inliers"].get<int>());
  }
  ASSERT_EQ(evaluate(command + path("b.jsonl")).status, 0);
  auto again = readLines(path("b.jsonl"));
  ASSERT_EQ(again.size(), records.size());
  for (size_t i = 0; i < records.size(); ++i) {
    again[i]["times_ms"] = records[i]["times_ms"];
    EXPECT_EQ(again[i], records[i]) << "same seed, same result";
  }
}

/// The rows of a CSV file: an object of texts for each.
nlohmann::json readCsv(const std::string& file) {
  return nlohmann::json::parse(
      run("/usr/bin/python3 -c 'import csv, json, sys; print(json.dumps(list(csv.DictReader(open(sys.argv[1])))))' " +
          file)
          .text);
}

/// Those of the columns that hold no time.
nlohmann::json withoutTimes(const std::string& file) {
  nlohmann::json rows = readCsv(file);
  for (nlohmann::json& row : rows) {
    for (auto cell = row.begin(); cell != row.end();) {
      cell = cell.key().find("ms") == std::string::npos ? std::next(cell) : row.erase(cell);
    }
  }
  return rows;
}

TEST_F(EvaluateTest, TablesDoNotDependOnShards) {
  writePlane(5, kStep);
  const std::string base =
      "tables " + path("set") +
      " --model homography --method gms_ransac,lo_prosac --presets 300,2000 --ratios 1/4,1/2 --pairs 3 --repeat 2"
      " --no-plots";
  ASSERT_EQ(evaluate(base + " --out " + path("whole")).status, 0);
  for (const char* shard : {"1/2", "2/2"}) {
    const Outcome part = evaluate(base + " --shard " + shard + " --out " + path(std::string("part") + shard[0]));
    ASSERT_EQ(part.status, 0) << part.text;
  }
  // The second part first: the plan's order decides, not the order of arrival.
  ASSERT_EQ(evaluate("merge " + path("part2") + " " + path("part1") + " --no-plots --out " + path("merged")).status, 0);

  ASSERT_EQ(evaluate(base + " --shard 1/2 --resume --out " + path("part1")).status, 0) << "nothing is left to do";

  for (const char* table :
       {"table1", "table2_3", "table4", "table4_differences", "fig8_9", "table5", "ratio_significance"}) {
    const nlohmann::json expected = withoutTimes(path(std::string("whole/") + table + ".csv"));
    EXPECT_GT(expected.size(), 0u) << table;
    EXPECT_EQ(withoutTimes(path(std::string("merged/") + table + ".csv")), expected) << table;
  }
  EXPECT_TRUE(fs::exists(path("merged/tables.md")));
}

TEST_F(EvaluateTest, TrustDoesNotDependOnJobsOrInterruptions) {
  const std::string base = "trust --scenes general,rotation_noise_0.3 --method ransac,cp_ransac --pairs 4 --out ";
  const Outcome whole = evaluate(base + path("whole"));
  ASSERT_EQ(whole.status, 0) << whole.text;
  const std::string pairs = textOf(path("whole/pairs.csv"));
  // Three scenes whose names begin so: a header, and a line for each pair and method.
  EXPECT_EQ(std::count(pairs.begin(), pairs.end(), '\n'), 1 + 3 * 4 * 2) << pairs;
  for (const char* file : {"trust.md", "trust.csv", "risk_coverage.csv", "reliability.csv"}) {
    EXPECT_TRUE(fs::exists(path(std::string("whole/") + file))) << whole.text;
  }
  const std::string table = textOf(path("whole/trust.md"));
  EXPECT_NE(table.find("| general | ransac | 4 | 4 | 49.0 % | 0 (0.0 %) | 4 | 4 |"), std::string::npos) << table;
  EXPECT_NE(table.find("| rotation_noise_0.3 | cp_ransac | 4 | 0 | –"), std::string::npos) << table;

  const std::string run = "run --scenes general,rotation_noise_0.3 --method ransac,cp_ransac --pairs 4 --out ";
  ASSERT_EQ(evaluate(run + path("run.jsonl")).status, 0);
  const std::string reporter = GMS_RANSAC_SOURCE_DIR "/scripts/evaluate_report.py";
  ASSERT_EQ(gms_ransac::run("/usr/bin/python3 " + reporter + " trust " + path("run.jsonl")).status, 0);
  EXPECT_EQ(textOf(path("run/pairs.csv")), pairs) << "a report of records, whoever wrote them";

  ASSERT_EQ(evaluate(base + path("jobs") + " --jobs 2 --no-report").status, 0);
  EXPECT_EQ(textOf(path("jobs/pairs.csv")), pairs);

  const std::string lines = textOf(path("whole/measurements.jsonl"));
  write("resumed/measurements.jsonl", lines.substr(0, lines.size() - 200));  // the last is cut off in the middle
  write("resumed/plan.json", textOf(path("whole/plan.json")));
  EXPECT_EQ(evaluate(base + path("resumed")).status, 2) << "measurements are not overwritten";
  EXPECT_EQ(evaluate(base + path("resumed") + " --resume --seed 9").status, 2) << "another plan";
  EXPECT_EQ(evaluate(base + path("resumed") + " --resume --first-group-fraction 0.4").status, 2);
  ASSERT_EQ(evaluate(base + path("resumed") + " --resume --no-report").status, 0);
  EXPECT_EQ(readLines(path("resumed/measurements.jsonl")).size(), 3u) << "nothing of the line that was cut off";
  EXPECT_EQ(textOf(path("resumed/pairs.csv")), pairs);
}

TEST_F(EvaluateTest, TrustLabelsTheMatchesOfListedPairs) {
  writePlane(4, kStep);
  const Outcome outcome =
      evaluate("trust " + folder_.path() + " --method cp_ransac --features 800 --out " + path("trust"));
  ASSERT_EQ(outcome.status, 0) << outcome.text;
  const std::string table = textOf(path("trust/trust.csv"));
  EXPECT_NE(table.find("real,set,cp_ransac,0,0,0"), std::string::npos) << "no pose, no pairs to judge\n" << table;
  const std::string bins = textOf(path("trust/reliability.csv"));
  EXPECT_GT(std::count(bins.begin(), bins.end(), '\n'), 2) << bins;
}

/// The rows of `evaluate sweep` by outlier ratio and method.
using SweepTable = std::map<double, std::map<std::string, nlohmann::json>>;

double number(const nlohmann::json& row, const char* column) { return std::stod(row.at(column).get<std::string>()); }

SweepTable readSweep(const std::string& file) {
  SweepTable table;
  for (const nlohmann::json& row : readCsv(file)) table[number(row, "outlier_ratio")][row["method"]] = row;
  return table;
}

TEST_F(EvaluateTest, ConfidenceOrderNeedsFewerHypothesesAtEqualSuccess) {
  const Outcome outcome =
      evaluate("sweep --method gms_ransac,cp_ransac,prosac --repeat 10 --no-plots --out " + path("sweep.csv"));
  ASSERT_EQ(outcome.status, 0) << outcome.text;
  const SweepTable table = readSweep(path("sweep.csv"));
  ASSERT_EQ(table.size(), 9u);
  for (const auto& [ratio, row] : table) {
    if (ratio < 0.15 || ratio > 0.55) continue;  // below there is nothing to gain, above uniform draws meet their cap
    SCOPED_TRACE(ratio);
    for (const auto& [method, of_method] : row) EXPECT_GE(number(of_method, "success_rate"), 0.9) << method;
    for (const char* method : {"cp_ransac", "prosac"}) {
      EXPECT_LT(number(row.at(method), "hypotheses"), number(row.at("gms_ransac"), "hypotheses"));
    }
  }
}

TEST_F(EvaluateTest, GoesOnWithoutDepthAndSaysSoOnce) {
  writePlane(3, kStep);
  fs::remove(path("set/pairs.txt"));
  write("set/rgb.txt", "1.0 0.png\n1.1 1.png\n1.2 2.png\n");
  write("set/depth.txt", "1.0 depth/0.png\n1.1 depth/1.png\n1.2 depth/2.png\n");
  const Outcome outcome = evaluate("run " + path("set") + " --gaps 1,2 --method gms_ransac,lo_prosac --features 500");
  EXPECT_EQ(outcome.status, 0) << outcome.text;
  const size_t said = outcome.text.find("depth.txt: 3 of the 3 images are not there; their frames have no depth\n");
  ASSERT_NE(said, std::string::npos) << outcome.text;
  EXPECT_EQ(outcome.text.find("images are not there", said + 40), std::string::npos) << outcome.text;
}

TEST_F(EvaluateTest, AFullDiskIsSaidOfTheFile) {
  fs::create_symlink("/dev/full", path("sweep.csv"));
  fs::create_symlink("/dev/full", path("plotted.png"));
  const std::string command = "sweep --method prosac --repeat 1 --max-iterations 10 --out ";
  for (const auto& [out, full] :
       {std::pair<const char*, const char*>{"sweep.csv --no-plots", "sweep.csv"}, {"plotted.csv", "plotted.png"}}) {
    const Outcome outcome = evaluate(command + path(out));
    EXPECT_EQ(outcome.status, 1) << outcome.text;
    EXPECT_NE(outcome.text.find("evaluate_report.py: " + path(full) + ": No space left on device\n"), std::string::npos)
        << outcome.text;
  }
}

TEST_F(EvaluateTest, LoProsacIsAsGoodAsAnExhaustiveSearch) {
  // 70 % outliers ask for 4,300 hypotheses.
  const Outcome outcome = evaluate(
      "sweep --method ransac,lo_prosac --repeat 4 --max-iterations 5000 --success-probability 0.9999 --no-plots "
      "--out " +
      path("sweep.csv"));
  ASSERT_EQ(outcome.status, 0) << outcome.text;
  for (auto& [ratio, row] : readSweep(path("sweep.csv"))) {
    if (ratio > 0.75) continue;  // 10 to 70 percent
    SCOPED_TRACE(ratio);
    const auto &ours = row.at("lo_prosac"), &exhaustive = row.at("ransac");
    EXPECT_GE(number(ours, "success_rate"), number(exhaustive, "success_rate"));
    EXPECT_GE(number(ours, "precision"), number(exhaustive, "precision") - 0.01);
    EXPECT_GE(number(ours, "recall"), number(exhaustive, "recall") - 0.01);
    EXPECT_LT(number(ours, "hypotheses"), number(exhaustive, "hypotheses"));
    EXPECT_LT(number(exhaustive, "hypotheses"), 5000) << "it was not cut short";
  }
}

/// A drive along the rendered street, 2 m a frame, in KITTI's layout with the images of two cameras.
void writeDrive(const ScratchFolder& folder, int images) {
  SceneOptions options;
  options.scene = "street";
  options.size = {480, 300};
  options.step = 2;
  options.rate = 10;
  std::ostringstream poses, calibration;
  for (const double offset : {0.0, 0.5}) {
    options.offset = offset;
    const Scene scene(options);
    const std::string camera = offset == 0 ? "0" : "1";
    const CameraIntrinsics& k = scene.intrinsics();
    calibration << "P" << camera << ": " << k.fx << " 0 " << k.cx << " " << -k.fx * offset << " 0 " << k.fy << " "
                << k.cy << " 0 0 0 1 0\n";
    fs::create_directories(folder.path("drive/image_" + camera));
    for (int i = 0; i < images; ++i) {
      cv::imwrite(folder.path("drive/image_" + camera + "/" + std::to_string(i) + ".png"), scene.render(i).image);
      if (offset == 0) poses << scene.pose(i).matrix().topRows<3>().format(Eigen::IOFormat(9, 1, " ", " ")) << '\n';
    }
  }
  folder.write("drive/calib.txt", calibration.str());
  folder.write("drive/poses.txt", poses.str());
}

TEST_F(EvaluateTest, OdometryOfTwoCamerasIsMetric) {
  constexpr int kImages = 7;
  writeDrive(folder_, kImages);
  fs::copy(path("drive/poses.txt"), path("peer.txt"));
  const Outcome outcome = evaluate("odometry " + path("drive") + " --peer " + path("peer.txt") + " --plot " +
                                   path("plot.png") + " --out " + path("records.jsonl"));
  ASSERT_EQ(outcome.status, 0) << outcome.text;
  EXPECT_NE(outcome.text.find("t, r 10 m"), std::string::npos) << outcome.text;
  EXPECT_EQ(outcome.text.find("INFO"), std::string::npos) << "the node's own lines: " << outcome.text;
  EXPECT_FALSE(cv::imread(path("plot.png")).empty());
  std::istringstream ours(outcome.text.substr(outcome.text.find("\ndrive  ")));
  std::string set, scale, against;
  double images = 0, lost = 0, t = 0, r = 0;
  ours >> set >> scale >> against >> images >> lost >> t >> r;
  EXPECT_EQ(scale, "stereo");
  EXPECT_EQ(images, kImages);
  EXPECT_EQ(lost, 0);
  EXPECT_LT(t, 2) << outcome.text;
  EXPECT_LT(r, 2) << outcome.text;
  EXPECT_NE(outcome.text.find("peer      truth             7     -      0.00 0.00"), std::string::npos) << outcome.text;
  EXPECT_NE(outcome.text.find("NEES of"), std::string::npos) << outcome.text;
  const auto records = readLines(path("records.jsonl"));
  ASSERT_EQ(records.size(), static_cast<size_t>(kImages));
  EXPECT_TRUE(records[0]["pair"].is_null());
  EXPECT_EQ(records[1]["pair"]["covariance"].size(), 36u);
  EXPECT_EQ(records[1]["pair"]["metric"], true);
  EXPECT_EQ(records[1]["twist"]["covariance"].size(), 36u);
  // The first part of a metre is the first pair, of two metres.
  EXPECT_EQ(records[1]["parts"][0]["length"], 1);
  EXPECT_EQ(records[1]["parts"][0]["unit"], "m");
  EXPECT_EQ(records[1]["parts"][0]["from"], records[0]["stamp"]);

  const Outcome witnessed =
      evaluate("odometry " + path("drive") + " --leave-out 2 --align --witness " + path("peer.txt"));
  EXPECT_EQ(witnessed.status, 0) << witnessed.text;
  for (const char* against : {"truth +5", "truth [0-9.]+ +5", "witness +5", "witness [0-9.]+ +5"}) {
    EXPECT_TRUE(std::regex_search(witnessed.text, std::regex(std::string("stereo +") + against))) << witnessed.text;
  }

  const Outcome ground = evaluate("odometry " + path("drive") + " --scale ground --camera-height 1.6");
  EXPECT_EQ(ground.status, 0) << ground.text;
  EXPECT_NE(ground.text.find(" ground "), std::string::npos) << ground.text;
  write("wrong.txt", "1 2 3\n");
  const Outcome refused = evaluate("odometry " + path("drive") + " --peer " + path("wrong.txt"));
  EXPECT_EQ(refused.status, 2) << refused.text;
  EXPECT_NE(refused.text.find("wrong.txt: not 12 numbers a line"), std::string::npos) << refused.text;
}

TEST_F(EvaluateTest, OdometryWithoutTruthSaysSo) {
  writeDrive(folder_, 4);
  fs::rename(path("drive/poses.txt"), path("witness.txt"));
  const Outcome refused = evaluate("odometry " + path("drive"));
  EXPECT_EQ(refused.status, 2) << refused.text;
  EXPECT_NE(refused.text.find("drive: has no truth to measure the drift against"), std::string::npos) << refused.text;
  const Outcome poses = evaluate("odometry " + path("drive") + " --out " + path("records.jsonl"));
  EXPECT_EQ(poses.status, 0) << poses.text;
  EXPECT_NE(poses.text.find("stereo    -                 4     0"), std::string::npos) << poses.text;
  EXPECT_NE(poses.text.find("drive: has no truth"), std::string::npos) << poses.text;
  const Outcome witnessed = evaluate("odometry " + path("drive") + " --witness " + path("witness.txt"));
  EXPECT_EQ(witnessed.status, 0) << witnessed.text;
  EXPECT_NE(witnessed.text.find("stereo    witness           4     0"), std::string::npos) << witnessed.text;
}

TEST_F(EvaluateTest, OdometryOfDepthImages) {
  ASSERT_EQ(run(PROGRAMS "/render_scene " + path("room") + " --frames 8 --grey").status, 0);
  const Outcome outcome = evaluate("odometry " + path("room") + " --out " + path("records.jsonl"));
  ASSERT_EQ(outcome.status, 0) << outcome.text;
  for (const auto& record : readLines(path("records.jsonl"))) {
    EXPECT_EQ(record["scale"], "depth");
    ASSERT_EQ(record["known"], true) << record;
  }
  const auto pose = readLines(path("records.jsonl")).back();
  double squared = 0;
  for (const int i : {3, 7, 11}) squared += std::pow(pose["pose"][i].get<double>(), 2);
  EXPECT_NEAR(std::sqrt(squared), 7 * 0.08, 0.06) << "metres along an arc";
}

TEST_F(EvaluateTest, FiguresAgreeWithAnIndependentScorer) {
  const std::string scorer = std::string(GMS_RANSAC_SOURCE_DIR) + "/../shared/tools/score.py";
  const std::string data = (dataFolder() / "kitti_06").string();
  if (!fs::exists(scorer) || !fs::exists(data)) GTEST_SKIP() << "needs the scorer and " << data;
  const Outcome ours = evaluate("run " + data + " --method cp_ransac --stride 5 --out " + path("records.jsonl"));
  ASSERT_EQ(ours.status, 0) << ours.text;
  for (const auto& record : readLines(path("records.jsonl"))) {
    if (record["R"].is_null()) continue;
    ASSERT_EQ(record["covariance"].size(), 36u);
    for (int i = 0; i < 6; ++i) EXPECT_GE(record["covariance"][7 * i].get<double>(), 0);
  }
  const Outcome theirs = run("/usr/bin/python3 " + scorer + " " + data + " " + path("records.jsonl"));
  ASSERT_EQ(theirs.status, 0) << theirs.text;
  // Both print a row that starts with the method: pairs, [OK, low, failed,] AUC5, AUC10, AUC20, RAUC2, median R, ...
  const auto figures = [](const std::string& text) {
    std::istringstream row(text.substr(text.find("\ncp_ransac") + 10));
    std::vector<double> values;
    for (double value; values.size() < 13 && row >> value;) values.push_back(value);
    return values;
  };
  const std::vector<double> a = figures(ours.text), b = figures(theirs.text);
  ASSERT_EQ(a.size(), 13u) << ours.text;
  ASSERT_GE(b.size(), 10u) << theirs.text;
  EXPECT_EQ(a[0], b[0]) << "pairs";
  for (int i = 1; i <= 4; ++i) EXPECT_NEAR(a[i + 3], b[i], 0.06) << "AUC5, AUC10, AUC20, RAUC2";
  EXPECT_NEAR(a[8], b[5], 0.002) << "median rotation error";
  EXPECT_NEAR(a[9], b[7], 0.02) << "precision";
  EXPECT_NEAR(a[11], b[8], 1) << "kept";
  EXPECT_NEAR(a[12], b[9], 1) << "correct";
}

}  // namespace
}  // namespace gms_ransac
