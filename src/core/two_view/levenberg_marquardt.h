// Levenberg-Marquardt over the SIMD kernels: sums in float, small linear algebra in double.
#pragma once

#include <cmath>

#include "two_view/two_view_model.h"

namespace gms_ransac {

/// Solves A x = b, A positive definite given as its upper triangle, diagonal times 1 + damping. False: not definite.
template <int P, class Number>
bool solveDamped(const Number (&upper)[P * (P + 1) / 2], const Number (&b)[P], double damping, double (&x)[P]) {
  double L[P][P];
  int k = 0;
  for (int i = 0; i < P; ++i) {
    for (int j = i; j < P; ++j) L[j][i] = upper[k++];
    L[i][i] = L[i][i] * (1 + damping);
  }
  for (int i = 0; i < P; ++i) {
    const double limit = 1e-12 * L[i][i];
    for (int j = 0; j < i; ++j) {
      for (int m = 0; m < j; ++m) L[i][j] -= L[i][m] * L[j][m];
      L[i][j] /= L[j][j];
      L[i][i] -= L[i][j] * L[i][j];
    }
    if (!(L[i][i] > limit) || !(L[i][i] > 0)) return false;
    L[i][i] = std::sqrt(L[i][i]);
  }
  for (int i = 0; i < P; ++i) {
    x[i] = b[i];
    for (int j = 0; j < i; ++j) x[i] -= L[i][j] * x[j];
    x[i] /= L[i][i];
  }
  for (int i = P - 1; i >= 0; --i) {
    for (int j = i + 1; j < P; ++j) x[i] -= L[j][i] * x[j];
    x[i] /= L[i][i];
  }
  return true;
}

/// Decrease of the linearised cost by a step s = -(A + damping)^-1 g, at least -g^T s.
template <int P>
double promisedDecrease(const float (&gradient)[P], const double (&step)[P]) {
  double decrease = 0;
  for (int i = 0; i < P; ++i) decrease -= static_cast<double>(gradient[i]) * step[i];
  return decrease;
}

/// Lowers the robust cost in at most `iterations` steps, or until one lowers it by less than `enough` of it.
/// linearize(state, equations), cost(state) and moved(state, step) define it. Returns the passes over the matches.
template <int P, class State, class Linearize, class Cost, class Moved>
int minimizeRobustCost(int iterations, float enough, State& state, const Linearize& linearize, const Cost& cost,
                       const Moved& moved) {
  constexpr double kFirstDamping = 1e-3;
  constexpr double kLargestDamping = 1e3;
  constexpr double kHopeless = 0.1;  ///< share of `enough` that a rejected step must have promised for shorter ones
  NormalEquations<P> equations;
  linearize(state, equations);
  int passes = 1;
  double damping = kFirstDamping;
  while (passes <= iterations && damping < kLargestDamping) {
    const bool last = passes == iterations;
    ++passes;
    double step[P];
    if (!solveDamped<P>(equations.matrix, equations.gradient, damping, step)) {
      damping *= 10;
      continue;
    }
    for (double& s : step) s = -s;
    const State candidate = moved(state, step);
    if (last) {  // nothing steps on from there
      if (cost(candidate) < equations.cost) state = candidate;
      break;
    }
    NormalEquations<P> candidate_equations;
    linearize(candidate, candidate_equations);
    if (candidate_equations.cost < equations.cost) {
      const bool converged = equations.cost - candidate_equations.cost < enough * equations.cost;
      state = candidate;
      equations = candidate_equations;
      damping = damping > 1e-6 ? 0.1 * damping : damping;
      if (converged) break;
    } else if (promisedDecrease<P>(equations.gradient, step) <
               kHopeless * static_cast<double>(enough * equations.cost)) {
      break;  // at the optimum, where sums in float no longer tell steps apart
    } else {
      damping *= 10;
    }
  }
  return passes;
}

}  // namespace gms_ransac
