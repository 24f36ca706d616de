// The readers behind Dataset::open, one per layout.
#pragma once

#include <string>

#include "datasets/dataset.h"

namespace gms_ransac {

Dataset openTum(const std::string& folder, const DatasetOptions& options);
Dataset openKitti(const std::string& folder, const DatasetOptions& options);
Dataset openImagePairs(const std::string& folder, const DatasetOptions& options);
Dataset openBag(const std::string& file, const DatasetOptions& options);

}  // namespace gms_ransac
