#include "gms_ransac/hamming_matcher.h"

#include <algorithm>
#include <stdexcept>

#include "matching/hamming_kernels.h"
#include "validation.h"
#include "worker.h"

namespace gms_ransac {

namespace {

/// Starts at a cache line, as the kernels ask. Only grows.
class AlignedBytes {
 public:
  uint8_t* reserve(size_t bytes) {
    const size_t lines = (bytes + sizeof(Line) - 1) / sizeof(Line);
    if (lines_.size() < lines) lines_.resize(lines);
    return lines_.empty() ? nullptr : lines_.front().bytes;
  }

 private:
  struct alignas(64) Line {
    uint8_t bytes[64];
  };
  std::vector<Line> lines_;
};

/// What one thread writes besides its share of the nearest neighbours.
struct Share {
  HammingSearch search;
  std::vector<NearestQueryGroup> reverse;
  AlignedBytes scratch;
};

/// Below this many pairs waking the second thread takes longer than it saves (measured: 20 us, 0.2 ns a pair).
constexpr int64_t kPairsWorthAThread = 250000;

/// The shares hold consecutive queries, so on equal distances the earlier share has the lower query.
void mergeReverse(const std::vector<NearestQueryGroup>& later, std::vector<NearestQueryGroup>& earlier) {
  for (size_t j = 0; j < earlier.size(); ++j) {
    if (later[j].distance < earlier[j].distance) earlier[j] = later[j];
  }
}

}  // namespace

struct HammingMatcher::Workspace {
  const HammingKernel* kernel = nullptr;
  DescriptorSet repacked;
  std::vector<NearestTwo> nearest;
  Share shares[2];
  std::unique_ptr<Worker> worker;

  /// Fills `nearest`, and `shares[0].reverse` if `mutual`.
  void search(const DescriptorSet& reference, const DescriptorSet& current, const uint8_t* packed, bool mutual);
  /// True when no query before `i` is as near to train descriptor `j` as `i`, and none at all is nearer.
  bool isNearestQuery(const DescriptorSet& reference, int i, const DescriptorSet& current, int j) const;
};

void HammingMatcher::Workspace::search(const DescriptorSet& reference, const DescriptorSet& current,
                                       const uint8_t* packed, bool mutual) {
  const int queries = reference.size();
  nearest.resize(queries);
  const bool split = worker && static_cast<int64_t>(queries) * current.size() >= kPairsWorthAThread;
  const int group = kernel->query_group;
  const int middle = split ? (queries / 2 + group - 1) / group * group : queries;

  for (Share& share : shares) {
    HammingSearch& search = share.search;
    const bool first = &share == &shares[0];
    search.queries = reference.row(0);
    search.first_query = first ? 0 : middle;
    search.last_query = first ? middle : queries;
    search.train = current.row(0);
    search.packed_train = packed;
    search.train_count = current.size();
    search.nearest = nearest.data();
    search.reverse = nullptr;
    if (mutual && search.first_query < search.last_query) {
      share.reverse.assign(current.size(), NearestQueryGroup());
      search.reverse = share.reverse.data();
      search.scratch = share.scratch.reserve(kernel->scratchBytes(current.size()));
    }
  }

  auto second_half = [this] { kernel->search(shares[1].search); };
  if (split) worker->start(second_half);
  kernel->search(shares[0].search);
  if (split) {
    worker->wait();
    if (mutual) mergeReverse(shares[1].reverse, shares[0].reverse);
  }
}

bool HammingMatcher::Workspace::isNearestQuery(const DescriptorSet& reference, int i, const DescriptorSet& current,
                                               int j) const {
  const int distance = nearest[i].distance;
  const NearestQueryGroup& reverse = shares[0].reverse[j];
  int first = 0, last = reference.size();
  if (reverse.distance < kExactDistanceLimit) {
    if (reverse.distance < distance) return false;
    first = reverse.first_query;
    last = std::min(last, first + kernel->query_group);
    if (i >= last) return false;
  }
  for (int k = first; k < last; ++k) {
    if (k == i) continue;
    const int other = kernel->distance(reference.row(k), current.row(j));
    if (other < distance || (other == distance && k < i)) return false;
  }
  return true;
}

void HammingMatcherOptions::validate() const {
  requireInRange("matcher_threads", threads, 1, 2);
  if (!simdLevelSupported(simd)) {
    throw std::invalid_argument("simd is " + toString(simd) + ", which this processor does not have");
  }
}

HammingMatcher::HammingMatcher(const HammingMatcherOptions& options)
    : options_(options), workspace_(std::make_unique<Workspace>()) {
  options_.validate();
  workspace_->kernel = &hammingKernel(options_.simd);
  if (options_.threads > 1) workspace_->worker = std::make_unique<Worker>();
}

HammingMatcher::~HammingMatcher() = default;
HammingMatcher::HammingMatcher(HammingMatcher&&) noexcept = default;
HammingMatcher& HammingMatcher::operator=(HammingMatcher&&) noexcept = default;

void HammingMatcher::match(const DescriptorSet& reference, const DescriptorSet& current, std::vector<Match>& matches) {
  matches.clear();
  if (reference.size() == 0 || current.size() == 0) return;

  const uint8_t* packed = current.packed();
  if (!current.packedFor(options_.simd)) {
    workspace_->repacked = current;
    workspace_->repacked.pack(options_.simd);
    packed = workspace_->repacked.packed();
  }
  workspace_->search(reference, current, packed, options_.mutual);

  matches.reserve(reference.size());
  for (int i = 0; i < reference.size(); ++i) {
    const NearestTwo& nearest = workspace_->nearest[i];
    if (options_.mutual && !workspace_->isNearestQuery(reference, i, current, nearest.index)) continue;
    matches.push_back({i, nearest.index, nearest.distance, nearest.second_distance});
  }
}

}  // namespace gms_ransac
