#include "two_view/solvers/minimal_solvers.h"

#include <algorithm>
#include <cmath>

namespace gms_ransac {

namespace {

constexpr int kMaxDegree = 10;
constexpr double kNoRemainder = 1e-14;  // of a division, over the size of its terms: rounding
constexpr int kMaxDepth = 50;           // bisections after which roots count as equal

double evaluate(const double* c, int degree, double x) {
  double value = c[degree];
  for (int i = degree - 1; i >= 0; --i) value = value * x + c[i];
  return value;
}

/// Sturm's sequence as quotients, f[i-1] = (a[i] x + b[i]) f[i] - f[i+1], evaluated in O(degree).
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
      // Multiple roots end the sequence early, and a missing power makes it skip degrees: neither is of this form.
      if (!(size > 0) || std::abs(lower[n - 1]) < 1e-13) return;
      const double a = upper[n] / lower[n - 1];
      const double b = n >= 2 ? (upper[n - 1] - a * lower[n - 2]) / lower[n - 1] : (upper[0]) / lower[0];
      a_[count_] = a;
      b_[count_] = b;
      ++count_;
      if (n == 1) {
        last_ = lower[0];
        complete_ = true;
        return;
      }
      double remainder[kMaxDegree + 1];
      remainder[0] = b * lower[0] - upper[0];
      for (int i = 1; i <= n - 2; ++i) remainder[i] = a * lower[i - 1] + b * lower[i] - upper[i];
      const double remainder_size = largest(remainder, n - 2);
      if (remainder_size < kNoRemainder * (1 + std::abs(a) + std::abs(b))) return;
      // Scaling the remainder rescales the recurrence: keep the factor with the step that uses it.
      factor_[count_ - 1] = remainder_size;
      std::copy(lower, lower + n, upper);
      std::copy(remainder, remainder + n - 1, lower);
    }
  }

  bool complete() const { return complete_; }
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
  bool complete_ = false;
};

/// The root in [low, high]: Newton steps, bisection where they leave the bracket.
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

/// Value of the polynomial at x, or 0 where it cannot be told from 0.
double valueUpToRounding(const double* c, int degree, double x) {
  constexpr double kRounding = 1e-12;
  double size = 0;
  for (int i = degree; i >= 0; --i) size = size * std::abs(x) + std::abs(c[i]);
  const double value = evaluate(c, degree, x);
  return std::abs(value) < kRounding * size ? 0 : value;
}

/// Roots of any polynomial: between the roots of its derivative, from the linear one up. Slower than Sturm's sequence.
int rootsBetweenExtrema(const double* c, int degree, double bound, double (&roots)[10]) {
  double derivative[kMaxDegree + 1][kMaxDegree + 1];  // by degree
  std::copy(c, c + degree + 1, derivative[degree]);
  for (int n = degree; n > 1; --n) {
    for (int i = 1; i <= n; ++i) derivative[n - 1][i - 1] = i * derivative[n][i];
  }
  double ends[kMaxDegree + 2];
  int count = 0;
  for (int n = 1; n <= degree; ++n) {
    int end_count = 0;
    ends[end_count++] = -bound;
    for (int i = 0; i < count; ++i) ends[end_count++] = roots[i];
    ends[end_count++] = bound;
    count = 0;
    double before = valueUpToRounding(derivative[n], n, ends[0]);
    for (int i = 1; i < end_count; ++i) {
      const double value = valueUpToRounding(derivative[n], n, ends[i]);
      if (before * value < 0) roots[count++] = refineRoot(derivative[n], n, ends[i - 1], ends[i]);
      if (value == 0) roots[count++] = ends[i];  // an extremum that touches zero: a multiple root
      before = value;
    }
  }
  return count;
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

  double bound = 0;
  for (int i = 0; i < degree; ++i) bound = std::max(bound, std::pow(std::abs(p[i]), 1.0 / (degree - i)));
  bound = 2 * bound + 1e-3;

  const SturmSequence sturm(p, degree);
  if (!sturm.complete()) return rootsBetweenExtrema(p, degree, bound, roots);
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

}  // namespace gms_ransac
