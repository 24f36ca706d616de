#include "run/experiment.h"

#include <algorithm>
#include <iostream>
#include <utility>

namespace gms_ransac {

void printRemarks(const Dataset& dataset, const MatchFilterOptions& options) {
  std::cerr << dataset.path() << ": " << dataset.calibrationText() << '\n';
  if (!dataset.stamp(0) && options.robust.rolling_shutter_readout != 0) {
    std::cerr << dataset.path() << ": a list of pairs has no stamps, so --rolling-shutter-readout is not applied\n";
  }
}

nlohmann::json pairRecord(const Dataset& dataset, const DatasetPair& pair, int gap) {
  nlohmann::json record = {{"set", dataset.name()},
                           {"reference", dataset.frames()[static_cast<size_t>(pair.reference)].name},
                           {"current", dataset.frames()[static_cast<size_t>(pair.current)].name},
                           {"gap", nullptr},
                           {"reference_stamp", nullptr},
                           {"stamp", nullptr}};
  if (const auto stamp = dataset.stamp(pair.current)) {
    record["gap"] = gap;
    record["reference_stamp"] = *dataset.stamp(pair.reference);
    record["stamp"] = *stamp;
  }
  return record;
}

Experiment::Experiment(const Dataset& dataset, const std::vector<MatchFilterOptions>& pipelines) : dataset_(dataset) {
  for (const MatchFilterOptions& options : pipelines) filters_.emplace_back(options);
}

const Frame& Experiment::frame(int index) {
  const auto [place, is_new] = frames_.try_emplace(index);
  if (is_new) filters_.front().extract(dataset_.image(index), place->second, cv::Mat(), dataset_.stamp(index));
  return place->second;
}

void Experiment::run(const DatasetPair& pair, const std::function<void(const Answer&)>& receive) {
  frames_.erase(frames_.begin(), frames_.lower_bound(std::min(pair.reference, pair.current)));
  const Frame& reference = frame(pair.reference);
  const Frame& current = frame(pair.current);
  const cv::Size size = reference.features.image_size;
  if (dataset_.intrinsics() && camera_.imageSize() != size) {
    camera_ = Camera(*dataset_.intrinsics(), size);
    for (MatchFilter& filter : filters_) filter.setCamera(camera_);
  }
  const PairTruth truth(dataset_, pair, camera_);
  // Pairs a gap of n apart are n streams, one in the other.
  const auto before = pasts_.find(pair.reference);
  std::vector<Past> pasts = before == pasts_.end() ? std::vector<Past>(filters_.size()) : before->second;
  for (size_t i = 0; i < filters_.size(); ++i) {
    filters_[i].filter(reference, current, result_, nullptr, &pasts[i]);
    pasts[i].advance();
    receive({i, filters_[i].options(), reference.features, current.features, camera_, result_, truth});
  }
  pasts_.erase(pasts_.begin(), pasts_.lower_bound(std::min(pair.reference, pair.current)));
  pasts_[pair.current] = std::move(pasts);
}

}  // namespace gms_ransac
