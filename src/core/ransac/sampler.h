// Samplers choose the matches of the next hypothesis and end the search. They know a match by its rank, 0 for the most
// confident.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "support/random.h"

namespace gms_ransac {

/// k = log(1 - p) / log(1 - w^n), rounded up (Fischler & Bolles 1981), within 1 and `cap`. `exponent`: sample size,
/// plus d for the T(d,d) test.
int requiredIterations(double success_probability, double inlier_ratio, int exponent, int cap);

/// Support that a wrong model gathers by chance with probability below 5 % (Chum & Matas 2005, eq. 8 and 9): besides
/// its sample each match fits with probability 0.05.
class ChanceSupport {
 public:
  /// Smallest non-random number of inliers among n matches; n + 1 below the sample size. Answers are kept.
  int minimum(int sample_size, int n);

 private:
  std::vector<int> minimum_;  ///< of others than the sample, by their number; 0: not asked for yet
};

/// The task a sampler is started on.
struct SamplingTask {
  int matches = 0;                 ///< at least the sample size
  int sample_size = 0;             ///< 4, 5 or 7
  double success_probability = 0;  ///< of having drawn a sample without outliers
  int max_iterations = 0;          ///< cap on samples
};

/// Each has a begin() that takes its task.
class Sampler {
 public:
  virtual ~Sampler() = default;
  /// Fills `sample` with distinct ranks; false when the search is over.
  virtual bool draw(Random& random, int* sample) = 0;
  /// A new best hypothesis: its inlier mask, by rank.
  virtual void newBest(const std::vector<uint8_t>& inlier) = 0;
};

/// Uniform draws from the first matches of the order until the bound from the inlier ratio of those same matches.
class UniformSampler : public Sampler {
 public:
  struct Options {
    double fraction = 1;  ///< share of the matches that is drawn from, rounded up; 1: textbook RANSAC
    int extra_tests = 0;  ///< d of the T(d,d) test, which a good model passes only with w^d: the bound has n + d
    std::optional<double> target_inlier_ratio;  ///< over when the inlier ratio gets there
  };
  UniformSampler() = default;
  explicit UniformSampler(const Options& options) : options_(options) {}
  /// `drawn`: samples of an earlier search, which count.
  void begin(const SamplingTask& task, int drawn = 0);
  bool draw(Random& random, int* sample) override;
  void newBest(const std::vector<uint8_t>& inlier) override;

 private:
  Options options_;
  SamplingTask task_;
  int prefix_ = 0, drawn_ = 0, bound_ = 0;
};

/// Progressive sample consensus (PROSAC, Chum & Matas, CVPR 2005). Draws from ever longer prefixes of the order, and
/// stops on the one that makes further draws pointless. The printed Algorithm 1 has the two branches of the draw
/// exchanged; here the n-th match is in the sample while the prefix grows.
class ProsacSampler : public Sampler {
 public:
  void begin(const SamplingTask& task);
  bool draw(Random& random, int* sample) override;
  void newBest(const std::vector<uint8_t>& inlier) override;

  int prefix() const { return prefix_; }  ///< n, the matches that are drawn from
  bool growing() const { return drawn_ <= growth_; }

 private:
  void grow();

  SamplingTask task_;
  ChanceSupport chance_;
  int prefix_ = 0;             ///< n
  double expected_draws_ = 0;  ///< T_n: of T_N uniform draws, those within the first n
  int growth_ = 0;             ///< T'_n: the draw after which n grows
  int stop_prefix_ = 0;        ///< n*: growth ends here
  int drawn_ = 0, bound_ = 0;
};

/// As PROSAC from the most confident matches first, and spread over the image: the first matches of an order lie close
/// together and neighbours fix a model badly. Members of a sample come from distinct cells of the spread grid, two of
/// them a fifth of it apart. Where the first eight samples do not suffice, what is right may be crowded in a few cells,
/// and every other sample is drawn by rank alone. Ends at the bound from the inlier ratio of the present prefix.
class StratifiedSampler : public Sampler {
 public:
  /// `order`: slots by rank; `cells`: of each slot; `first_share`: of the matches, which the first samples come from.
  void begin(const SamplingTask& task, const std::vector<int>& order, const std::vector<int32_t>& cells,
             double first_share = kFirstShare);
  bool draw(Random& random, int* sample) override;
  void newBest(const std::vector<uint8_t>& inlier) override;

  int prefix() const { return drawn_from_; }

 private:
  static constexpr double kFirstShare = 0.02;  ///< doc/measured/constants.md

  bool spread(const int* sample) const;
  void updateBound();

  std::vector<int32_t> cells_;  ///< by rank
  SamplingTask task_;
  double prefix_ = 0, growth_ = 1;
  int drawn_from_ = 0, bound_prefix_ = 0;
  int drawn_ = 0, required_ = 0;
  std::vector<uint8_t> inlier_;  ///< of the best hypothesis, by rank; empty: none yet
};

/// How many ranks a share of n matches covers: ceil(fraction * n), at least `least`, at most n.
int prefixLength(double fraction, int n, int least);

int countPrefix(const std::vector<uint8_t>& inlier, int prefix);

}  // namespace gms_ransac
