// Parts of the sentences in logs and statuses.
#pragma once

#include <sstream>
#include <string>

#include <opencv2/core/types.hpp>

namespace gms_ransac {

/// The first characters of `text`; what is not printable is a question mark.
inline std::string excerpt(const std::string& text) {
  constexpr size_t kLongest = 40;  // the longest encoding and model there are have half of it
  std::string quoted = text.substr(0, kLongest);
  for (char& c : quoted) {
    if (c < ' ' || c > '~') c = '?';
  }
  return text.size() > kLongest ? quoted + "..." : quoted;
}

/// "0.123 s"
inline std::string secondsText(double seconds) {
  std::ostringstream text;
  text.precision(3);
  text << seconds << " s";
  return text.str();
}

/// "640x480"
inline std::string sizeText(const cv::Size& size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

}  // namespace gms_ransac
