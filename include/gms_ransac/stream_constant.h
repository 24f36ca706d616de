// Constants of a stream that every pair measures anew: how long a shutter reads an image, the errors that the
// calibration of two cameras or of a depth camera has left.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace gms_ransac {

/// N numbers with a normal prior of mean 0, and the sum of the evidence of the pairs. Pairs that follow each other see
/// the same points, and err together: they are counted by groups, and the scatter of the groups is the scale of the
/// covariance.
template <int N>
class StreamConstant {
 public:
  using Vector = Eigen::Matrix<double, N, 1, Eigen::DontAlign>;
  using Matrix = Eigen::Matrix<double, N, N, Eigen::DontAlign>;

  /// `pairs`: of a group. `kept`: weight of what is known, from group to group; below 1 the constant may drift, and
  /// three groups in a row that contradict what is known begin anew.
  explicit StreamConstant(int pairs = 1, double kept = 1) : pairs_of_group_(pairs), kept_(kept) {}

  /// Evidence of a pair, of which the likeliest constant is information^-1 score. Ignored if not finite.
  void add(const Vector& score, const Matrix& information) {
    if (!score.allFinite() || !information.allFinite()) return;
    group_.score += score;
    group_.information += information;
    if (++group_.count == pairs_of_group_) count();
  }

  int groups() const { return groups_; }
  /// `prior`: information of the prior.
  Vector mean(const Matrix& prior) const { return solve(information(prior), known_.score / dispersion()); }
  /// Inverse of the covariance.
  Matrix information(const Matrix& prior) const { return prior + known_.information / dispersion(); }

 private:
  struct Evidence {
    Vector score = Vector::Zero();
    Matrix information = Matrix::Zero();
    double count = 0, squares = 0;  ///< of deviations of groups from the mean, in their own

    void add(double kept, const Evidence& more) {
      score = kept * score + more.score;
      information = kept * information + more.information;
      count = kept * count + more.count;
      squares = kept * squares + more.squares;
    }
  };
  static Vector solve(const Matrix& information, const Vector& score) {
    const Vector solution = information.ldlt().solve(score);
    return solution.allFinite() ? solution : Vector(Vector::Zero());
  }

  /// Mean square of those deviations; at least 1.
  double dispersion() const { return known_.count > 0 ? std::max(1., known_.squares / known_.count) : 1; }

  void count() {
    const Vector rest = group_.score - group_.information * solve(known_.information, known_.score);
    const double deviation = std::sqrt(std::max(0., rest.dot(solve(group_.information, rest)) / N));
    const double most = kMostDeviations * std::sqrt(dispersion());
    const double influence = std::min(1., most / std::max(deviation, 1e-9));
    const double square = std::min(deviation, most) * std::min(deviation, most);
    known_.add(kept_, {influence * group_.score, influence * group_.information, 1, square});
    if (influence == 1) contrary_ = Evidence();
    if (influence < 1) contrary_.add(1, {group_.score, group_.information, 1, 1});
    if (kept_ < 1 && contrary_.count == kTurned) known_ = std::exchange(contrary_, Evidence());
    ++groups_;
    group_ = Evidence();
  }

  static constexpr double kMostDeviations = 3;  ///< influence of a group, in its own deviations
  static constexpr int kTurned = 3;             ///< groups in a row beyond it

  Evidence known_, group_, contrary_;
  int groups_ = 0, pairs_of_group_;
  double kept_;
};

}  // namespace gms_ransac
