#include "real_roots.h"

#include <algorithm>
#include <cmath>

namespace gms_ransac {

namespace {

constexpr int kMaxDegree = 10;
constexpr int kMaxDepth = 50;  // bisections after which roots count as equal

double evaluate(const double* c, int degree, double x) {
  double value = c[degree];
  for (int i = degree - 1; i >= 0; --i) value = value * x + c[i];
  return value;
}

/// Sturm's sequence p, p', ... kept as the quotients of its divisions, f[i-1] = (a[i] x + b[i]) f[i] - f[i+1], so that
/// all members are evaluated at a point in O(degree).
class SturmSequence {
 public:
  SturmSequence(const double* c, int degree) {
    double upper[kMaxDegree + 1], lower[kMaxDegree + 1];
    std::copy(c, c + degree + 1, upper);
    for (int i = 1; i <= degree; ++i) lower[i - 1] = i * c[i];
    for (int n = degree; n >= 1; --n) {
      // upper has degree n, lower n - 1. Members may be scaled by positive factors without changing a sign.
      normalize(upper, n);
      const double size = normalize(lower, n - 1);
      if (!(size > 0)) return;  // multiple roots: the sequence ends in a common factor, whose sign never matters
      if (std::abs(lower[n - 1]) < 1e-13) return;
      const double a = upper[n] / lower[n - 1];
      const double b = n >= 2 ? (upper[n - 1] - a * lower[n - 2]) / lower[n - 1] : (upper[0]) / lower[0];
      a_[count_] = a;
      b_[count_] = b;
      ++count_;
      if (n == 1) {
        last_ = lower[0];
        return;
      }
      double remainder[kMaxDegree + 1];
      remainder[0] = b * lower[0] - upper[0];
      for (int i = 1; i <= n - 2; ++i) remainder[i] = a * lower[i - 1] + b * lower[i] - upper[i];
      const double remainder_size = largest(remainder, n - 2);
      // Scaling the remainder rescales the recurrence: keep the factor with the step that uses it.
      factor_[count_ - 1] = remainder_size;
      std::copy(lower, lower + n, upper);
      std::copy(remainder, remainder + n - 1, lower);
    }
  }

  /// Sign changes along the sequence at x; the roots in (a, b] number changes(a) - changes(b).
  int changes(double x) const {
    double next = 0, current = last_;
    int count = 0;
    for (int i = count_ - 1; i >= 0; --i) {
      const double previous = (a_[i] * x + b_[i]) * current - factor_[i] * next;
      count += (previous < 0) != (current < 0);
      next = current;
      current = previous;
    }
    return count;
  }

 private:
  static double largest(const double* c, int degree) {
    double size = 0;
    for (int i = 0; i <= degree; ++i) size = std::max(size, std::abs(c[i]));
    return size;
  }
  static double normalize(double* c, int degree) {
    const double size = largest(c, degree);
    if (size > 0) {
      for (int i = 0; i <= degree; ++i) c[i] /= size;
    }
    return size;
  }

  double a_[kMaxDegree], b_[kMaxDegree], factor_[kMaxDegree] = {};
  double last_ = 1;  // the constant member the recurrence starts from
  int count_ = 0;
};

/// The root in [low, high], where the polynomial changes sign once: Newton steps, bisection where they leave the
/// bracket.
double refineRoot(const double* c, int degree, double low, double high) {
  double value_low = evaluate(c, degree, low);
  double x = 0.5 * (low + high);
  for (int iteration = 0; iteration < 60; ++iteration) {
    double value = c[degree], slope = 0;
    for (int i = degree - 1; i >= 0; --i) {
      slope = slope * x + value;
      value = value * x + c[i];
    }
    if (value == 0) return x;
    if ((value < 0) == (value_low < 0)) {
      low = x;
      value_low = value;
    } else {
      high = x;
    }
    double next = x - value / slope;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (std::abs(next - x) <= 1e-14 * std::abs(next)) return next;
    x = next;
  }
  return x;
}

}  // namespace

int solvePolynomial(const double* c, int degree, double (&roots)[10]) {
  double size = 0;
  for (int i = 0; i <= degree; ++i) size = std::max(size, std::abs(c[i]));
  if (!(size > 0) || !std::isfinite(size)) return 0;
  while (degree > 0 && std::abs(c[degree]) < 1e-14 * size) --degree;
  if (degree == 0) return 0;
  double p[kMaxDegree + 1];
  for (int i = 0; i <= degree; ++i) p[i] = c[i] / c[degree];

  // Fujiwara's bound on the absolute value of every root.
  double bound = 0;
  for (int i = 0; i < degree; ++i) bound = std::max(bound, std::pow(std::abs(p[i]), 1.0 / (degree - i)));
  bound = 2 * bound + 1e-3;

  const SturmSequence sturm(p, degree);
  struct Interval {
    double low, high;
    int changes_low, changes_high, depth;
  };
  Interval stack[kMaxDepth + 2];  // each step replaces one interval by its two halves
  int stack_size = 0, count = 0;
  stack[stack_size++] = {-bound, bound, sturm.changes(-bound), sturm.changes(bound), 0};
  while (stack_size > 0 && count < kMaxDegree) {
    const Interval interval = stack[--stack_size];
    const int inside = interval.changes_low - interval.changes_high;
    if (inside <= 0) continue;
    if (inside == 1 || interval.depth == kMaxDepth) {
      roots[count++] = refineRoot(p, degree, interval.low, interval.high);
      continue;
    }
    const double middle = 0.5 * (interval.low + interval.high);
    const int changes = sturm.changes(middle);
    stack[stack_size++] = {middle, interval.high, changes, interval.changes_high, interval.depth + 1};
    stack[stack_size++] = {interval.low, middle, interval.changes_low, changes, interval.depth + 1};
  }
  return count;
}

int solveCubic(const double (&c)[4], double (&roots)[3]) {
  double all[10];
  const int count = std::min(solvePolynomial(c, 3, all), 3);
  std::copy(all, all + count, roots);
  return count;
}

}  // namespace gms_ransac
