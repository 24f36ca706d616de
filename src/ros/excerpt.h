// What a log line or a status may quote of a message: the text comes from whoever publishes, and has any length.
#pragma once

#include <string>

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

}  // namespace gms_ransac
