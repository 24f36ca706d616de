#include "datasets/dataset_text.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "features/encoded_image.h"
#include "features/wide_image.h"

namespace gms_ransac {

namespace {

/// The whole field as a finite number, or nothing.
std::optional<double> toNumber(const std::string& field) {
  try {
    size_t used = 0;
    const double value = std::stod(field, &used);
    if (used == field.size() && std::isfinite(value)) return value;
  } catch (const std::exception&) {
    // Not a number, or one that no double holds: the caller says so.
  }
  return std::nullopt;
}

}  // namespace

std::vector<TextLine> readLines(const std::string& file) {
  // Checked before opening: opening a pipe blocks until another process writes to it.
  std::ifstream stream;
  if (isFile(file)) stream.open(file);
  if (!stream.is_open()) throw DatasetError(file + ": cannot be opened");
  std::vector<TextLine> lines;
  TextLine line;
  while (std::getline(stream, line.text)) {
    ++line.number;
    line.fields.clear();
    std::istringstream words(line.text);
    for (std::string word; words >> word;) line.fields.push_back(word);
    if (!line.fields.empty() && line.fields[0][0] != '#') lines.push_back(line);
  }
  return lines;
}

void failAt(const std::string& file, const TextLine& line, const std::string& complaint) {
  throw DatasetError(file + ":" + std::to_string(line.number) + ": " + complaint);
}

double numberAt(const std::string& file, const TextLine& line, const std::string& field, const std::string& what) {
  const std::optional<double> value = toNumber(field);
  if (!value) failAt(file, line, "expected " + what + ", but '" + field + "' is not a finite number");
  return *value;
}

std::vector<double> numbersAt(const std::string& file, const TextLine& line, size_t first, size_t count,
                              const std::string& what) {
  if (line.fields.size() != first + count) {
    failAt(file, line, "expected " + what + ", found " + std::to_string(line.fields.size()) + " fields");
  }
  std::vector<double> values;
  for (size_t i = first; i < line.fields.size(); ++i) values.push_back(numberAt(file, line, line.fields[i], what));
  return values;
}

CameraIntrinsics parseIntrinsics(const std::string& text, const std::string& source) {
  std::string blank_separated = text;
  std::replace(blank_separated.begin(), blank_separated.end(), ',', ' ');
  std::istringstream words(blank_separated);
  std::vector<double> values;
  // Models with a name before the numbers.
  const std::map<std::string, std::string> named = {
      {"equidistant", "k1 k2 k3 k4"}, {"omnidirectional", "xi k1 k2 p1 p2"}, {"double_sphere", "xi alpha"}};
  std::string model;
  for (std::string word; words >> word;) {
    if (values.empty() && model.empty() && named.count(word) > 0) {
      model = word;
      continue;
    }
    const std::optional<double> value = toNumber(word);
    if (!value) throw DatasetError(source + ": '" + word + "' is not a finite number");
    values.push_back(*value);
  }
  if (!model.empty()) {
    const std::string& coefficients = named.at(model);
    const auto count = 5 + static_cast<size_t>(std::count(coefficients.begin(), coefficients.end(), ' '));
    if (values.size() != count) {
      throw DatasetError(source + ": expected " + model + " fx fy cx cy " + coefficients + ", found " +
                         std::to_string(values.size()) + " numbers");
    }
  } else if (values.size() != 4 && values.size() != 8 && values.size() != 9) {
    throw DatasetError(source + ": expected fx fy cx cy [k1 k2 p1 p2 [k3]], found " + std::to_string(values.size()) +
                       " numbers");
  }
  CameraIntrinsics intrinsics = {values[0], values[1], values[2], values[3], "", {}};
  if (!intrinsics.calibrated()) throw DatasetError(source + ": the focal lengths fx and fy must be positive");
  if (values.size() > 4) {
    intrinsics.distortion_model = model.empty() ? "plumb_bob" : model;
    intrinsics.distortion.assign(values.begin() + 4, values.end());
  }
  return intrinsics;
}

std::optional<CameraIntrinsics> readCameraFile(const std::string& folder) {
  const std::string file = joinPath(folder, "camera.txt");
  if (!isFile(file)) return std::nullopt;
  const std::vector<TextLine> lines = readLines(file);
  if (lines.empty()) throw DatasetError(file + ":1: expected fx fy cx cy [k1 k2 p1 p2 [k3]], but the file is empty");
  if (lines.size() > 1) failAt(file, lines[1], "expected one line with fx fy cx cy [k1 k2 p1 p2 [k3]]");
  return parseIntrinsics(lines[0].text, file + ":" + std::to_string(lines[0].number));
}

bool isFile(const std::string& path) {
  std::error_code none;
  return std::filesystem::is_regular_file(path, none);
}

bool isFolder(const std::string& path) {
  std::error_code none;
  return std::filesystem::is_directory(path, none);
}

std::string joinPath(const std::string& folder, const std::string& relative) {
  return (std::filesystem::path(folder) / relative).string();
}

cv::Mat eightBits(const cv::Mat& picture, bool colour) {
  cv::Mat image = picture;
  const bool wide = image.depth() == CV_16U;
  if (image.channels() == 3 && (wide || !colour)) cv::cvtColor(image, image, cv::COLOR_BGR2GRAY);
  if (wide) image = wideToGrey(image);
  if (image.channels() == 1 && colour) cv::cvtColor(image, image, cv::COLOR_GRAY2BGR);
  return image;
}

cv::Mat readPicture(const std::string& path, bool colour) {
  if (!isFile(path)) throw DatasetError(path + ": no such image");
  // Not grey by the decoder: its grey differs by a level here and there, and inliers with it.
  const cv::Mat image = readImageFile(path);
  if (image.empty()) throw DatasetError(path + ": cannot be read as an image");
  if (image.depth() != CV_8U && image.depth() != CV_16U)
    throw DatasetError(path + ": has pixels that are neither of 8 nor of 16 bits");
  return eightBits(image, colour);
}

ImageReader imagesOf(const std::vector<DatasetFrame>& frames, const std::string& folder) {
  std::vector<std::string> paths;
  paths.reserve(frames.size());
  for (const DatasetFrame& frame : frames) paths.push_back(joinPath(folder, frame.name));
  return [paths = std::move(paths)](int frame, bool colour) {
    return readPicture(paths.at(static_cast<size_t>(frame)), colour);
  };
}

}  // namespace gms_ransac
