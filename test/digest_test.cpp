// Every method's results, bit by bit, against the digests recorded in digests.txt: the guard of every move inside the
// core, and the proof that all instruction sets agree (CMakeLists.txt runs it with --simd LEVEL for each).
//
// `digest_test --record` records a change of results that has a purpose. Its commit holds nothing else and states why
// and by how much.
//
// Other processors round differently, in libraries and in fused operations. `digest_test --outcomes` therefore compares
// statuses and numbers of inliers alone, on recorded images (rendered ones are rounded, too). Where another
// compiler or library is in use than the recorded one, statuses must be equal and numbers close (--similar). The last
// line names the level that was checked.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <regex>
#include <sstream>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include <gnu/libc-version.h>
#include <Eigen/Core>
#include <opencv2/core/version.hpp>

#include "datasets/dataset.h"
#include "gms_ransac/match_filter.h"
#include "gms_ransac/simd.h"
#include "methods/method.h"
#include "scale/translation_scale.h"
#include "scenes/scene.h"
#include "shared_data.h"
#include "stages.h"
#include "tracks/track_table.h"

namespace gms_ransac {
namespace {

namespace fs = std::filesystem;

constexpr int kSkipped = 77;  // exit status
constexpr int kFeatures = 1000;
constexpr int kPairsOfASet = 2;
constexpr int kStreamLength = 6;
constexpr int kWidestGap = 5;

const fs::path kRecords = fs::path(GMS_RANSAC_SOURCE_DIR) / "test/digests.txt";

/// 64-bit FNV-1a over the bytes of numbers.
class Digest {
 public:
  template <typename Number, typename = std::enable_if_t<std::is_arithmetic_v<Number> || std::is_enum_v<Number>>>
  Digest& add(Number value) {
    if constexpr (std::is_floating_point_v<Number>) value += 0;  // -0 is 0
    uint8_t bytes[sizeof(value)];
    std::memcpy(bytes, &value, sizeof(value));
    for (const uint8_t byte : bytes) hash_ = (hash_ ^ byte) * 0x100000001b3ull;
    return *this;
  }
  template <typename Number>
  Digest& add(const std::vector<Number>& values) {
    add(values.size());
    for (const Number value : values) add(value);
    return *this;
  }
  template <typename Derived>
  Digest& add(const Eigen::MatrixBase<Derived>& matrix) {
    for (int i = 0; i < matrix.size(); ++i) add(matrix(i / matrix.cols(), i % matrix.cols()));
    return *this;
  }
  std::string text() const {
    std::ostringstream out;
    out << std::hex << hash_;
    return out.str();
  }

 private:
  uint64_t hash_ = 0xcbf29ce484222325ull;
};

void addFeatures(const Features& features, Digest& digest) {
  for (const cv::KeyPoint& k : features.keypoints) {
    digest.add(k.pt.x).add(k.pt.y).add(k.size).add(k.angle).add(k.response).add(k.octave);
  }
  for (int i = 0; i < features.size(); ++i) {
    for (int k = 0; k < kDescriptorBytes; ++k) digest.add(features.descriptors.row(i)[k]);
  }
}

/// A column with an entry for each raw match, 0 for those that the filter rejects.
template <typename Number>
std::vector<Number> ofRaw(const MatchResult& result, const std::vector<Number>& column) {
  std::vector<Number> entries;
  result.forEachRaw([&](const Match&, MatchStage stage, size_t row) {
    entries.push_back(stage == MatchStage::kRaw ? 0 : column[row]);
  });
  return entries;
}

void addResult(const MatchResult& result, Digest& digest) {
  digest.add(result.status).add(result.size()).add(result.inliers);
  digest.add(ofRaw(result, result.confidence)).add(stagesOf(result));
  for (const Match& match : result.raw) digest.add(match.reference).add(match.current).add(match.distance);
  const RobustResult& robust = result.robust;
  digest.add(robust.model_found).add(robust.model_type).add(robust.model).add(robust.inlier);
  digest.add(robust.judgement.pose_found)
      .add(robust.judgement.translation_observable)
      .add(robust.judgement.doubt == DirectionDoubt::kOtherMotion);
  digest.add(robust.judgement.pose.R).add(robust.judgement.pose.t).add(robust.judgement.pose.covariance);
  digest.add(robust.judgement.median_parallax_px).add(robust.rms_error_px);
}

std::string describe(const MatchResult& result, const Digest& digest) {
  return digest.text() + " " + toString(result.status) + " " + std::to_string(result.inliers);
}

/// Versions on which the results depend in addition to the code: other libraries may give other numbers.
std::string toolchain() {
  std::ostringstream text;
  text << "gcc " << __GNUC__ << ", glibc " << gnu_get_libc_version() << ", Eigen " << EIGEN_WORLD_VERSION << "."
       << EIGEN_MAJOR_VERSION << "." << EIGEN_MINOR_VERSION << ", OpenCV " << CV_VERSION;
  return text.str();
}

/// The cells of each pair or stream of images, by method or stage: a cell for each model, or one.
using Digests = std::map<std::string, std::map<std::string, std::string>>;
constexpr ModelType kModels[] = {ModelType::kEssential, ModelType::kFundamental, ModelType::kHomography};
constexpr char kBetweenCells[] = "  ";

/// Images with what is known of them, from a folder or rendered.
struct Sequence {
  std::string name;
  std::vector<cv::Mat> images;
  Camera camera;
};

Sequence rendered(const std::string& scene) {
  SceneOptions options;
  options.scene = scene;
  options.seed = 7;
  const Scene world(options);
  Sequence sequence = {scene, {}, Camera(world.intrinsics(), options.size)};
  for (int i = 0; i < kStreamLength; ++i) sequence.images.push_back(world.render(i).image);
  return sequence;
}

Sequence recorded(const fs::path& path) {
  const Dataset dataset = Dataset::open(path.string());
  Sequence sequence;
  sequence.name = dataset.name();
  const int count = std::min<int>(kStreamLength, static_cast<int>(dataset.frames().size()));
  for (int i = 0; i < count; ++i) sequence.images.push_back(dataset.image(i));
  if (dataset.intrinsics()) sequence.camera = Camera(*dataset.intrinsics(), sequence.images.front().size());
  return sequence;
}

MatchFilterOptions optionsOf(const std::string& method, ModelType model) {
  MatchFilterOptions options;
  options.method = method;
  options.robust.model = model;
  options.extractor.features = kFeatures;
  return options;
}

/// Neighbours and the widest gap, every method and model, each pair on its own.
void addPairs(const Sequence& sequence, Digests& digests) {
  const int last = static_cast<int>(sequence.images.size()) - 1;
  const int gaps[kPairsOfASet] = {1, std::min(kWidestGap, last)};
  for (const int gap : gaps) {
    auto& of_pair = digests[sequence.name + " 0-" + std::to_string(gap)];
    Frame reference, current;
    MatchFilter extractor(optionsOf(methods().front().name, kModels[0]));
    extractor.extract(sequence.images[0], reference);
    extractor.extract(sequence.images[static_cast<size_t>(gap)], current);
    Digest of_features;
    addFeatures(current.features, of_features);
    of_pair["features"] = of_features.text() + " " + std::to_string(current.features.size());
    for (const MethodEntry& method : methods()) {
      std::string& cells = of_pair[method.name];
      for (const ModelType model : kModels) {
        MatchFilter filter(optionsOf(method.name, model));
        filter.setCamera(sequence.camera);
        MatchResult result;
        filter.filter(reference, current, result);
        Digest digest;
        addResult(result, digest);
        cells += (cells.empty() ? "" : kBetweenCells) + describe(result, digest);
      }
    }
  }
}

/// The default method on the matches of a guided search.
void addGuided(const Sequence& sequence, Digests& digests) {
  MatchFilterOptions options = optionsOf("lo_prosac", ModelType::kEssential);
  options.search = SearchMode::kGuided;
  options.extractor.features = 2 * kFeatures;  // fewer are searched in full
  MatchFilter filter(options);
  filter.setCamera(sequence.camera);
  Digest digest;
  MatchResult result;
  for (const cv::Mat& image : sequence.images) {
    result = filter.process(image);
    addResult(result, digest);
    for (const Match& match : result.raw) digest.add(match.second_distance);
  }
  digests[sequence.name + " stream"]["guided"] = describe(result, digest);
}

/// State that one image leaves for the next: the previous motion, tracks, the length of the translation.
void addStream(const Sequence& sequence, Digests& digests) {
  for (const std::string method : {"lo_prosac", "cp_ransac"}) {
    MatchFilter filter(optionsOf(method, ModelType::kEssential));
    filter.setCamera(sequence.camera);
    TrackTable tracks;
    Past past;
    ScalePropagator propagator;
    Triangulation triangulation;
    Frame reference, current;
    filter.extract(sequence.images.front(), reference);
    Digest digest;
    MatchResult result;
    for (size_t i = 1; i < sequence.images.size(); ++i) {
      filter.extract(sequence.images[i], current);
      filter.filter(reference, current, result, nullptr, &past);
      addResult(result, digest);
      tracks.link(result);
      digest.add(ofRaw(result, tracks.ids())).add(ofRaw(result, tracks.lengths()));
      tracks.advance();
      if (result.status == Status::kOk) {
        triangulateInliers(reference.features, result, sequence.camera, triangulation);
        digest.add(propagator.update(triangulation, result, sequence.camera).length);
        propagator.advance();
      }
      std::swap(reference, current);
    }
    digests[sequence.name + " stream"][method] = describe(result, digest);
  }
}

Digests digestsOf(const Sequence& sequence) {
  Digests digests;
  addPairs(sequence, digests);
  addStream(sequence, digests);
  addGuided(sequence, digests);
  return digests;
}

/// `drawn`: of rendered scenes, too.
Digests allDigests(bool drawn) {
  Digests digests;
  for (const std::string& path : dataSets()) digests.merge(digestsOf(recorded(path)));
  for (const std::string scene : {"room", "street"}) {
    if (drawn) digests.merge(digestsOf(rendered(scene)));
  }
  return digests;
}

/// The first line names the toolchain. Then comes a line for each pair or stream, and under it those of what was done
/// with it: "row: digest status inliers", the latter three for each model.
Digests readDigests(std::string& recorded_with) {
  std::ifstream file(kRecords);
  std::getline(file, recorded_with);
  Digests records;
  std::string what;
  for (std::string line; std::getline(file, line);) {
    const size_t colon = line.find(": ");
    if (colon == std::string::npos) {
      what = line;
    } else {
      records[what][line.substr(0, colon)] = line.substr(colon + 2);
    }
  }
  return records;
}

/// The words after the digest in each cell: a status and a number of inliers, or the number of features.
std::string outcomes(const std::string& cells) { return std::regex_replace(cells, std::regex("\\b[0-9a-f]{8,} "), ""); }

enum class Level { kBits, kOutcomes, kSimilar };

/// Share by which a number of inliers or features may differ, and how many in any case.
constexpr double kSimilarShare = 0.03;
constexpr int kSimilarCount = 5;

bool isNumber(const std::string& word) { return word.find_first_not_of("0123456789") == std::string::npos; }

/// Outcomes whose words are equal and whose numbers are close.
bool areSimilar(const std::string& a, const std::string& b) {
  std::istringstream words_a(a), words_b(b);
  std::string word_a, word_b;
  while (words_a >> word_a) {
    if (!(words_b >> word_b)) return false;
    if (word_a == word_b) continue;
    if (!isNumber(word_a) || !isNumber(word_b)) return false;
    const int m = std::stoi(word_a), n = std::stoi(word_b);
    if (std::abs(m - n) > std::max<double>(kSimilarCount, kSimilarShare * n)) return false;
  }
  return !(words_b >> word_b);
}

bool agree(const std::string& cells, const std::string& recorded, Level level) {
  if (level == Level::kBits || cells == recorded) return cells == recorded;
  const std::string ours = outcomes(cells), theirs = outcomes(recorded);
  return level == Level::kOutcomes ? ours == theirs : areSimilar(ours, theirs);
}

int compare(Level level) {
  std::string recorded_with;
  Digests records = readDigests(recorded_with);
  int compared = 0, different = 0, equal = 0, rows_without_record = 0;
  std::string without_record;
  for (const auto& [what, rows] : allDigests(level != Level::kOutcomes)) {
    if (records.count(what) == 0) {  // a user's own sets in GMS_RANSAC_DATA
      without_record += (without_record.empty() ? "" : ", ") + what;
      rows_without_record += static_cast<int>(rows.size());
      continue;
    }
    for (const auto& [row, cells] : rows) {
      const std::string& recorded = records[what][row];
      ++compared;
      equal += cells == recorded;
      if (agree(cells, recorded, level)) continue;
      ++different;
      std::cout << what << " " << row << ": " << cells << "\n  recorded: " << recorded << "\n";
    }
  }
  if (rows_without_record > 0) {
    std::cout << rows_without_record << " rows have no record and were not compared: " << without_record << "\n";
  }
  const char* checked[] = {"bit by bit", "status and number of inliers", "status, and number of inliers to 3 %"};
  std::cout << compared << " rows of results, level checked: " << checked[static_cast<int>(level)] << ". " << different
            << " differ; " << equal << " are equal bit by bit\n";
  if (compared == 0) return kSkipped;
  return different == 0 ? 0 : 1;
}

int record() {
  std::ofstream file(kRecords);
  file << toolchain() << "\n";
  for (const auto& [what, rows] : allDigests(true)) {
    file << what << "\n";
    for (const auto& [row, cells] : rows) file << row << ": " << cells << "\n";
  }
  file.close();
  std::cout << "digests written to " << kRecords << "\n";
  return file ? 0 : 1;
}

}  // namespace
}  // namespace gms_ransac

int main(int argc, char** argv) {
  using namespace gms_ransac;
  if (argc > 1 && std::string(argv[1]) == "--record") return record();
  if (argc > 1 && std::string(argv[1]) == "--outcomes") return compare(Level::kOutcomes);
  if (argc > 1 && std::string(argv[1]) == "--similar") return compare(Level::kSimilar);
  if (argc > 2 && std::string(argv[1]) == "--simd") {
    setenv("GMS_RANSAC_SIMD", argv[2], 1);
    try {
      detectSimdLevel();
    } catch (const std::invalid_argument& error) {
      std::cout << "skipped: " << error.what() << "\n";
      return kSkipped;
    }
  }
  std::string recorded_with;
  readDigests(recorded_with);
  if (recorded_with == toolchain()) return compare(Level::kBits);
  std::cout << "the digests were recorded with " << recorded_with << ", this is " << toolchain() << "\n";
  return compare(Level::kSimilar);
}
