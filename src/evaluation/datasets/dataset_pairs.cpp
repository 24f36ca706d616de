// Image pairs: pairs.txt with two paths a line (reference, current) and, optionally, truth as KEY=VALUE: H=FILE (3 x 3,
// reference pixels to current pixels), F=FILE (3 x 3 fundamental matrix) or DISP=FILE SCALE=NUMBER (disparity image of
// the reference). A file without a key is taken for a homography.
#include <map>

#include "datasets/dataset_text.h"

namespace gms_ransac {

namespace {

/// Three lines of three numbers.
Eigen::Matrix3d readMatrix(const std::string& file) {
  const std::vector<TextLine> lines = readLines(file);
  Eigen::Matrix3d matrix;
  for (int row = 0; row < static_cast<int>(lines.size()); ++row) {
    const TextLine& line = lines[static_cast<size_t>(row)];
    if (row == 3) failAt(file, line, "expected a 3 x 3 matrix, found a fourth row");
    const std::vector<double> values = numbersAt(file, line, 0, 3, "three numbers of a 3 x 3 matrix");
    matrix.row(row) = Eigen::RowVector3d::Map(values.data());
  }
  if (lines.size() < 3) {
    throw DatasetError(file + ":" + std::to_string(lines.empty() ? 1 : lines.back().number) +
                       ": expected a 3 x 3 matrix, but the file ends after " + std::to_string(lines.size()) + " rows");
  }
  return matrix;
}

/// Adds one KEY=VALUE field of a line to the pair.
void readTruth(const std::string& folder, const std::string& list, const TextLine& line, const std::string& field,
               DatasetPair& pair) {
  const auto equals = field.find('=');
  const std::string key = equals == std::string::npos ? "H" : field.substr(0, equals);
  const std::string value = equals == std::string::npos ? field : field.substr(equals + 1);
  if (key == "H") {
    pair.homography = readMatrix(joinPath(folder, value));
  } else if (key == "F") {
    pair.fundamental = readMatrix(joinPath(folder, value));
  } else if (key == "DISP") {
    if (!pair.disparity) pair.disparity = DisparityFile();
    pair.disparity->path = value;
  } else if (key == "SCALE") {
    const double scale = numberAt(list, line, value, "SCALE= and grey values per pixel of disparity");
    if (!(scale > 0)) failAt(list, line, "SCALE must be positive");
    if (!pair.disparity) pair.disparity = DisparityFile();
    pair.disparity->scale = scale;
  } else {
    failAt(list, line, "unknown key '" + key + "'; known are H, F, DISP and SCALE");
  }
}

}  // namespace

void Dataset::readImagePairs() {
  const std::string list = joinPath(path_, "pairs.txt");
  std::map<std::string, int> index;  // an image that several pairs share is one frame
  const auto frameOf = [&](const std::string& name) {
    const auto [place, is_new] = index.emplace(name, static_cast<int>(frames_.size()));
    if (is_new) frames_.push_back({name});
    return place->second;
  };
  for (const TextLine& line : readLines(list)) {
    if (line.fields.size() < 2) failAt(list, line, "expected two image paths and, optionally, H=, F= or DISP= truth");
    DatasetPair pair;
    pair.reference = frameOf(line.fields[0]);
    pair.current = frameOf(line.fields[1]);
    for (size_t i = 2; i < line.fields.size(); ++i) readTruth(path_, list, line, line.fields[i], pair);
    if (pair.disparity && pair.disparity->path.empty()) failAt(list, line, "SCALE= without DISP=");
    listed_pairs_.push_back(pair);
  }
  if (listed_pairs_.empty()) throw DatasetError(list + ": lists no pair");
}

}  // namespace gms_ransac
