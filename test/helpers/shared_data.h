// Real images for tests: in $GMS_RANSAC_DATA, else in ../shared/data next to the source.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace gms_ransac {

inline std::filesystem::path dataFolder() {
  const char* given = std::getenv("GMS_RANSAC_DATA");
  return given ? std::filesystem::path(given) : std::filesystem::path(GMS_RANSAC_SOURCE_DIR) / "../shared/data";
}

/// The folders of all sets, sorted.
inline std::vector<std::string> dataSets() {
  std::vector<std::string> paths;
  std::error_code missing;
  for (const auto& entry : std::filesystem::directory_iterator(dataFolder(), missing)) {
    if (entry.is_directory()) paths.push_back(entry.path().string());
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

}  // namespace gms_ransac

/// Opens a set or skips the test; needs datasets/dataset.h.
#define OPEN_OR_SKIP(dataset, name)                                                    \
  std::optional<gms_ransac::Dataset> dataset;                                          \
  try {                                                                                \
    dataset = gms_ransac::Dataset::open((gms_ransac::dataFolder() / (name)).string()); \
  } catch (const gms_ransac::DatasetError& error) {                                    \
    GTEST_SKIP() << error.what();                                                      \
  }
