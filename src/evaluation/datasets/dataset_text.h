// The text files and images of the layouts that Dataset::open reads; every complaint names the file and the line.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "datasets/dataset.h"

namespace gms_ransac {

/// A line that is neither blank nor a comment.
struct TextLine {
  int number = 0;  ///< from 1
  std::string text;
  std::vector<std::string> fields;  ///< split at blanks
};

/// Lines of a text file without blank ones and those that start with '#'. Throws DatasetError if it cannot be opened.
std::vector<TextLine> readLines(const std::string& file);

/// "<file>:<line>: <complaint>"
[[noreturn]] void failAt(const std::string& file, const TextLine& line, const std::string& complaint);

/// A field of the line as a finite number; `what` describes the expected line in the complaint.
double numberAt(const std::string& file, const TextLine& line, const std::string& field, const std::string& what);

/// Fields [first, first + count), the last ones, as finite numbers.
std::vector<double> numbersAt(const std::string& file, const TextLine& line, size_t first, size_t count,
                              const std::string& what);

/// fx fy cx cy [k1 k2 p1 p2 [k3]], or the name of another model before its numbers (equidistant, omnidirectional,
/// double_sphere), separated by commas or blanks. `source` opens the complaint.
CameraIntrinsics parseIntrinsics(const std::string& text, const std::string& source);

/// Intrinsics of camera.txt in the folder; absent without that file.
std::optional<CameraIntrinsics> readCameraFile(const std::string& folder);

/// Returns true for a regular file. Pipes and devices have no end.
bool isFile(const std::string& path);
bool isFolder(const std::string& path);
std::string joinPath(const std::string& folder, const std::string& relative);

/// A picture of 8 or 16 bits as CV_8UC1, reduced to grey as the node does it, or as CV_8UC3 with `colour`.
cv::Mat eightBits(const cv::Mat& picture, bool colour);

/// Reads an image file like that. Throws DatasetError.
cv::Mat readPicture(const std::string& path, bool colour);

/// Reads the frames of a folder by their names.
ImageReader imagesOf(const std::vector<DatasetFrame>& frames, const std::string& folder);

}  // namespace gms_ransac
