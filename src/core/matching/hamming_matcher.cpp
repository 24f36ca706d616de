// The room matching finds what belongs together in two images: descriptors, rows, patches. A kernel may be added for
// another processor; distances stay exact.
//
#include "gms_ransac/hamming_matcher.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include <opencv2/core.hpp>

#include "matching/hamming_kernels.h"
#include "support/validation.h"
#include "support/worker_pool.h"

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
  const HammingKernel& kernel;
  std::shared_ptr<WorkerPool> pool;
  DescriptorSet repacked;
  std::vector<NearestTwo> nearest, reverse;  ///< current descriptors of the reference ones, and with `mutual` these

  explicit Workspace(const HammingMatcherOptions& options)
      : kernel(hammingKernel(options.simd)), pool(WorkerPool::shared(options.threads - 1)) {}

  void search(const DescriptorSet& queries, const DescriptorSet& train, const HammingMatcherOptions& options,
              std::vector<NearestTwo>& found) {
    const bool packed = train.packedFor(options.simd);
    if (!packed) {
      repacked = train;
      repacked.pack(options.simd);
    }
    const uint8_t* packed_train = packed ? train.packed() : repacked.packed();
    const int64_t n = queries.size(), worth = n * train.size() / kPairsWorthAThread;
    const int shares = static_cast<int>(std::clamp<int64_t>(worth, 1, options.threads));
    found.resize(queries.size());
    pool->forEach(shares, shares, [&](int share, int /*thread*/) {
      const int first = static_cast<int>(n * share / shares), last = static_cast<int>(n * (share + 1) / shares);
      kernel.search({queries.row(first), last - first, train.row(0), packed_train, train.size(), found.data() + first});
    });
  }
};

void HammingMatcherOptions::validate() const {
  requireInRange("matcher_threads", threads, 1, kMostThreads);
  if (!simdLevelSupported(simd)) {
    throw std::invalid_argument("simd is " + toString(simd) + ", which this processor does not have");
  }
}

HammingMatcher::HammingMatcher(const HammingMatcherOptions& options) : options_(options) {
  options_.validate();
  workspace_ = std::make_unique<Workspace>(options_);
}

HammingMatcher::~HammingMatcher() = default;
HammingMatcher::HammingMatcher(HammingMatcher&&) noexcept = default;
HammingMatcher& HammingMatcher::operator=(HammingMatcher&&) noexcept = default;

void HammingMatcher::match(const DescriptorSet& reference, const DescriptorSet& current, std::vector<Match>& matches) {
  matches.clear();
  for (const DescriptorSet* set : {&reference, &current}) {
    if (set->is256Bit()) continue;
    throw std::invalid_argument("HammingMatcher compares descriptors of 32 bytes, and these have " + set->kind() +
                                "; MatchFilter compares any");
  }
  if (reference.size() == 0 || current.size() == 0) return;

  const std::vector<NearestTwo>&nearest = workspace_->nearest, &reverse = workspace_->reverse;
  workspace_->search(reference, current, options_, workspace_->nearest);
  if (options_.mutual) workspace_->search(current, reference, options_, workspace_->reverse);
  matches.reserve(reference.size());
  for (int i = 0; i < reference.size(); ++i) {
    const NearestTwo& two = nearest[i];
    if (options_.mutual && reverse[two.index].index != i) continue;
    matches.push_back({i, two.index, two.distance, two.second_distance});
  }
}

static_assert(kDescriptorBytes == kHammingBytes, "the kernels compare whole descriptors");

void DescriptorSet::resize(int n) {
  size_ = n;
  other_.release();
  is_packed_ = false;
  const size_t bytes = static_cast<size_t>(n) * kDescriptorBytes;
  if (rows_.size() < bytes) rows_.resize(bytes);
}

cv::Mat DescriptorSet::asMat() const {
  if (!is256Bit()) return other_;
  return cv::Mat(size_, kDescriptorBytes, CV_8U, const_cast<uint8_t*>(rows_.data()));
}

void DescriptorSet::assign(const cv::Mat& rows) {
  if (!rows.empty() && rows.type() != CV_8UC1 && rows.type() != CV_32FC1) {
    throw std::invalid_argument("descriptors must be a matrix of bytes (CV_8U) or floats (CV_32F), a row for each");
  }
  if (!rows.empty() && (rows.type() != CV_8UC1 || rows.cols != kDescriptorBytes)) {
    cv::Point where;
    if (!cv::checkRange(rows, true, &where)) {
      throw std::invalid_argument("descriptor " + std::to_string(where.y) + " has a number that is not finite");
    }
    resize(rows.rows);
    other_ = rows.clone();  // copies of this set share it
    return;
  }
  resize(rows.rows);
  for (int i = 0; i < size_; ++i) std::memcpy(row(i), rows.ptr(i), kDescriptorBytes);
  pack();
}

bool DescriptorSet::comparableWith(const DescriptorSet& other) const {
  if (size() == 0 || other.size() == 0) return true;
  const cv::Mat mine = asMat(), theirs = other.asMat();
  return mine.type() == theirs.type() && mine.cols == theirs.cols;
}

std::string DescriptorSet::kind() const {
  const cv::Mat rows = asMat();
  return std::to_string(rows.cols) + (rows.type() == CV_32FC1 ? " floats" : " bytes");
}

void DescriptorSet::pack(SimdLevel level) {
  const HammingKernel& kernel = hammingKernel(level);
  kernel.pack(rows_.data(), size_, reserve(kernel.packedBytes(size_), packed_));
  is_packed_ = true;
  packed_level_ = level;
}

}  // namespace gms_ransac
