#include "run/experiment.h"

#include <algorithm>

namespace gms_ransac {

std::optional<std::string> unappliedOption(const Dataset& dataset, const MatchFilterOptions& options) {
  if (dataset.stamp(0) || options.robust.rolling_shutter_readout == 0) return std::nullopt;
  return dataset.path() + ": a list of pairs has no stamps, so --rolling-shutter-readout is not applied";
}

Experiment::Experiment(const Dataset& dataset, const std::vector<Contender>& contenders, int gap)
    : dataset_(dataset), contenders_(contenders), gap_(gap) {
  for (const Contender& contender : contenders_) filters_.push_back(std::make_unique<MatchFilter>(contender.options));
}

const Frame& Experiment::frame(int index) {
  const auto known = frames_.find(index);
  if (known != frames_.end()) return known->second;
  Frame& frame = frames_[index];
  filters_.front()->extract(dataset_.image(index), frame, cv::Mat(), dataset_.stamp(index));
  return frame;
}

void Experiment::forgetFramesBefore(const DatasetPair& pair) {
  const int first = std::min(pair.reference, pair.current);
  frames_.erase(frames_.begin(), frames_.lower_bound(first));
}

void Experiment::run(const DatasetPair& pair, const Receiver& receive) {
  forgetFramesBefore(pair);
  const Frame& reference = frame(pair.reference);
  const Frame& current = frame(pair.current);
  const cv::Size size = reference.features.image_size;
  if (dataset_.intrinsics() && camera_.imageSize() != size) {
    camera_ = Camera(*dataset_.intrinsics(), size);
    for (auto& filter : filters_) filter->setCamera(camera_);
  }
  const PairTruth truth(dataset_, pair, camera_);

  for (size_t i = 0; i < contenders_.size(); ++i) {
    const MatchFilterOptions& options = contenders_[i].options;
    filters_[i]->filter(reference, current, result_);
    RecordContext context;
    context.method = options.method;
    context.model = options.robust.model;
    context.reference = dataset_.frames()[static_cast<size_t>(pair.reference)].name;
    context.current = dataset_.frames()[static_cast<size_t>(pair.current)].name;
    context.features = options.extractor.features;
    context.gap = gap_;
    context.repeat = contenders_[i].repeat;
    context.seed = options.robust.seed;
    receive({context, reference.features, current.features, camera_, result_, truth});
  }
}

}  // namespace gms_ransac
