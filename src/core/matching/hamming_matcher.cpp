#include "gms_ransac/hamming_matcher.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "matching/hamming_kernels.h"
#include "validation.h"
#include "worker_pool.h"

namespace gms_ransac {

namespace {

/// Below this many pairs waking another thread takes longer than it saves (measured: 20 us, 0.2 ns a pair).
constexpr int64_t kPairsWorthAThread = 250000;

/// Room for so many bytes; null for none. It only grows.
uint8_t* reserve(size_t bytes, std::vector<CacheLine>& lines) {
  lines.resize(std::max(lines.size(), (bytes + sizeof(CacheLine) - 1) / sizeof(CacheLine)));
  return lines.empty() ? nullptr : lines.front().bytes;
}

}  // namespace

struct HammingMatcher::Workspace {
  /// Storage of one thread.
  struct Share {
    HammingSearch search;
    std::vector<NearestQueryGroup> reverse;
    std::vector<CacheLine> scratch;
  };

  const HammingKernel* kernel = nullptr;
  DescriptorSet repacked;
  std::vector<NearestTwo> nearest;
  std::vector<Share> shares;  ///< at most so many, one for each thread
  std::shared_ptr<WorkerPool> pool;

  /// Fills `nearest`, and `shares[0].reverse` if `mutual`.
  void search(const DescriptorSet& reference, const DescriptorSet& current, const uint8_t* packed, bool mutual) {
    const int queries = reference.size(), group = kernel->query_group;
    nearest.resize(queries);
    const int64_t worth = static_cast<int64_t>(queries) * current.size() / kPairsWorthAThread;
    const int count = static_cast<int>(std::clamp<int64_t>(worth, 1, static_cast<int64_t>(shares.size())));
    const int groups = (queries + group - 1) / group;
    const auto firstOf = [&](int share) { return std::min(queries, groups * share / count * group); };

    for (int i = 0; i < count; ++i) {
      HammingSearch& search = shares[i].search;
      search.queries = reference.row(0);
      search.first_query = firstOf(i);
      search.last_query = firstOf(i + 1);
      search.train = current.row(0);
      search.packed_train = packed;
      search.train_count = current.size();
      search.nearest = nearest.data();
      search.reverse = nullptr;
      if (mutual) {
        shares[i].reverse.assign(current.size(), NearestQueryGroup());
        search.reverse = shares[i].reverse.data();
        search.scratch = reserve(kernel->scratchBytes(current.size()), shares[i].scratch);
      }
    }

    pool->forEach(count, count, [this](int i, int /*seat*/) { kernel->search(shares[i].search); });
    // The shares hold consecutive queries, so on equal distances the earlier share has the lower query.
    for (int i = 1; mutual && i < count; ++i) {
      for (size_t j = 0; j < shares[0].reverse.size(); ++j) {
        if (shares[i].reverse[j].distance < shares[0].reverse[j].distance) shares[0].reverse[j] = shares[i].reverse[j];
      }
    }
  }

  /// True when no query before `i` is as near to train descriptor `j` as `i`, and none at all is nearer.
  bool isNearestQuery(const DescriptorSet& reference, int i, const DescriptorSet& current, int j) const {
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
};

void HammingMatcherOptions::validate() const {
  requireInRange("matcher_threads", threads, 1, kMostThreads);
  if (!simdLevelSupported(simd)) {
    throw std::invalid_argument("simd is " + toString(simd) + ", which this processor does not have");
  }
}

HammingMatcher::HammingMatcher(const HammingMatcherOptions& options)
    : options_(options), workspace_(std::make_unique<Workspace>()) {
  options_.validate();
  workspace_->kernel = &hammingKernel(options_.simd);
  workspace_->shares.resize(options_.threads);
  workspace_->pool = WorkerPool::shared(options_.threads - 1);
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

static_assert(kDescriptorBytes == kHammingBytes, "the kernels compare whole descriptors");

void DescriptorSet::resize(int n) {
  size_ = n;
  is_packed_ = false;
  const size_t bytes = static_cast<size_t>(n) * kDescriptorBytes;
  if (rows_.size() < bytes) rows_.resize(bytes);
}

cv::Mat DescriptorSet::asMat() const {
  return cv::Mat(size_, kDescriptorBytes, CV_8U, const_cast<uint8_t*>(rows_.data()));
}

void DescriptorSet::assign(const cv::Mat& rows) {
  if (!rows.empty() && (rows.type() != CV_8UC1 || rows.cols != kDescriptorBytes)) {
    throw std::invalid_argument("descriptors must be an N x 32 matrix of bytes");
  }
  resize(rows.rows);
  for (int i = 0; i < size_; ++i) std::memcpy(row(i), rows.ptr(i), kDescriptorBytes);
  pack();
}

void DescriptorSet::pack(SimdLevel level) {
  const HammingKernel& kernel = hammingKernel(level);
  kernel.pack(rows_.data(), size_, reserve(kernel.packedBytes(size_), packed_));
  is_packed_ = true;
  packed_level_ = level;
}

}  // namespace gms_ransac
