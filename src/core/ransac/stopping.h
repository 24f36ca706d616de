// When enough hypotheses have been drawn, and how much support is more than chance.
#pragma once

#include <vector>

namespace gms_ransac {

/// k = log(1 - p) / log(1 - w^n), rounded up (Fischler & Bolles 1981): draws until, with `success_probability`, one
/// sample of n was free of outliers. At least 1, at most `cap`. `exponent`: sample size, plus d for the T(d,d) test.
int requiredIterations(double success_probability, double inlier_ratio, int exponent, int cap);

/// Support that a wrong model gathers by chance with a probability below 5 % (Chum & Matas 2005, eq. 8 and 9): besides
/// its own sample of m, each other match fits with probability 0.05.
class ChanceSupport {
 public:
  /// Forgets the results if the sample size is another one.
  void setSampleSize(int sample_size);
  /// Smallest non-random number of inliers among n matches; n + 1 (never reached) when n is below the sample size.
  /// Answers are kept.
  int minimum(int n);

 private:
  int sample_size_ = 0;
  std::vector<int> minimum_;  ///< by the number of other matches; 0: not asked for yet
};

}  // namespace gms_ransac
