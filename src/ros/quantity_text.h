// Quantities as the sentences of logs and statuses give them.
#pragma once

#include <sstream>
#include <string>

#include <opencv2/core/types.hpp>

namespace gms_ransac {

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
