// Numbers of a sensor that drift slowly, such as its time offset, learnt from residuals. StreamConstant is for evidence
// that is linear, without time.
#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace gms_ransac {

/// A Kalman filter on N numbers that drift slowly. A pair has bounded influence, and where the numbers change, the
/// filter begins anew.
template <int N>
class DriftingConstants {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;
  using Matrix = Eigen::Matrix<double, N, N>;

  struct Estimate {
    Vector mean = Vector::Zero();
    Matrix covariance = Matrix::Zero();
    Vector deviation() const { return covariance.diagonal().cwiseSqrt(); }
  };
  /// A pair's residuals r = r0 - J (x - mean), with covariance S.
  struct Evidence {
    Vector score = Vector::Zero();        ///< J^T S^-1 r0
    Matrix information = Matrix::Zero();  ///< J^T S^-1 J
    double squares = 0;                   ///< r0^T S^-1 r0
    int residuals = 0;
  };

  /// `prior`: standard deviations about zero; at four of them the filter begins anew. `drift`: deviations of the drift
  /// over a second.
  DriftingConstants(const Vector& prior, const Vector& drift) : prior_(prior), drift_(drift) {}

  /// Adds a pair `seconds` after the one before. Ignores it if a number is not finite.
  void add(const Evidence& pair, double seconds) {
    if (!pair.score.allFinite() || !pair.information.allFinite() || !std::isfinite(pair.squares)) return;
    const Vector linearized_at = learnt_.mean;
    for (Filter* filter : {&learnt_, &anew_}) update(*filter, pair, linearized_at, seconds);
    if (anew_.evidence - learnt_.evidence > kSurely) {
      learnt_ = anew_;
      ++restarts_;
    }
    if (++since_anew_ < kAnew) return;
    since_anew_ = 0;
    anew_ = begin();
    learnt_.evidence = 0;
  }

  const Estimate& learnt() const { return learnt_; }
  /// Mean square of the residuals in their deviations, at least 1; 1 also where no numbers explain the pairs.
  double dispersion() const { return explains() ? learnt_.dispersion : 1; }
  int restarts() const { return restarts_; }

  /// The estimate where it is better known than by `usual`, deviations about zero, or a quarter of itself. In other
  /// directions, and in all where no numbers explain the pairs, it is zero with these deviations.
  Estimate known(const Vector& usual) const {
    const Matrix scaled = usual.cwiseInverse().asDiagonal() * learnt_.covariance * usual.cwiseInverse().asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Matrix> directions(learnt_.dispersion * scaled);
    const Matrix axes = usual.asDiagonal() * directions.eigenvectors();
    Vector along = directions.eigenvectors().transpose() * learnt_.mean.cwiseQuotient(usual);
    Vector variances = directions.eigenvalues();
    for (int k = 0; k < N; ++k) {
      if (explains() && variances[k] < std::max(1.0, along[k] * along[k] / 16)) continue;
      along[k] = 0;
      variances[k] = 1;
    }
    return {axes * along, axes * variances.asDiagonal() * axes.transpose()};
  }

 private:
  struct Filter : Estimate {
    double evidence = 0;    ///< logarithm of the likelihood of the pairs, up to a constant of the pairs
    double dispersion = 1;  ///< mean square of the residuals in their deviations, at least 1
  };

  static constexpr int kAnew = 100;          ///< pairs after which a filter begins that knows nothing
  static constexpr double kSurely = 7;       ///< it takes over where the pairs are a thousand times likelier under it
  static constexpr double kMostSquares = 4;  ///< influence of a residual: two deviations
  static constexpr double kMemory = 0.98;    ///< of the dispersion, from pair to pair
  static constexpr double kExplained = 9;    ///< dispersion where numbers explain the pairs: three deviations
  static constexpr double kMostPriors = 4;

  bool explains() const { return learnt_.dispersion < kExplained; }
  Filter begin() const {
    Filter filter;
    filter.covariance = prior_.cwiseAbs2().asDiagonal();
    return filter;
  }
  void update(Filter& filter, const Evidence& pair, const Vector& linearized_at, double seconds) const {
    filter.covariance.diagonal() += std::max(0.0, seconds) * drift_.cwiseAbs2();
    const Vector step = linearized_at - filter.mean, score = pair.score + pair.information * step;
    const auto posterior = [&](double weight) {
      return Eigen::PartialPivLU<Matrix>(Matrix::Identity() + weight * filter.covariance * pair.information);
    };
    auto solver = posterior(1);
    const double squares =
        std::max(0.0, pair.squares + step.dot(pair.score + score) - score.dot(solver.solve(filter.covariance * score)));
    const double most = kMostSquares * filter.dispersion * pair.residuals;
    filter.evidence -= 0.5 * (std::min(squares, most) / filter.dispersion +
                              pair.residuals * std::log(filter.dispersion) + std::log(std::abs(solver.determinant())));
    const double weight = std::min(1.0, most / squares);
    if (weight < 1) solver = posterior(weight);
    filter.covariance = solver.solve(Matrix(filter.covariance));
    filter.covariance = 0.5 * Matrix(filter.covariance + filter.covariance.transpose());
    filter.mean += weight * filter.covariance * score;
    filter.dispersion =
        std::max(1.0, kMemory * filter.dispersion + (1 - kMemory) * std::min(squares, most) / pair.residuals);
    if (filter.mean.cwiseQuotient(prior_).cwiseAbs().maxCoeff() < kMostPriors) return;
    const double unexplained = std::max(filter.dispersion, 2 * kExplained);
    filter = begin();
    filter.dispersion = unexplained;
  }

  Vector prior_, drift_;
  Filter learnt_ = begin(), anew_ = learnt_;
  int since_anew_ = 0, restarts_ = 0;
};

}  // namespace gms_ransac
