// The orientation that a camera notes in its JPEG pictures: programs that show one rotate it by that.
#pragma once

#include <string>

namespace gms_ransac {

/// Inserts the orientation (1 to 8) into a JPEG picture.
inline void setExifOrientation(int orientation, std::string& jpeg) {
  std::string segment(
      "\xff\xe1\0\x22"                 // its length
      "Exif\0\0MM\0\x2a\0\0\0\x08"     // big-endian
      "\0\1\1\x12\0\3\0\0\0\1\0_\0\0"  // one entry: the orientation
      "\0\0\0\0",                      // no more
      36);
  segment[29] = static_cast<char>(orientation);
  jpeg.insert(2, segment);
}

}  // namespace gms_ransac
