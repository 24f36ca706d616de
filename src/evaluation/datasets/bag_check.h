// What is looked at before rosbag opens a bag: it makes room for whatever lengths and reads from whatever places the
// file names.
#pragma once

#include <string>

namespace gms_ransac {

/// Walks over the records of a bag of format 2.0 (wiki.ros.org/Bags/Format/2.0). Throws DatasetError, with the file and
/// the byte, where a record is longer than what is left of the file, a chunk would unpack to more than a gigabyte, or
/// an index names a place where there is no record. The records inside compressed chunks are not looked at. Other
/// formats pass: their readers say what they miss.
void checkBag(const std::string& file);

}  // namespace gms_ransac
