// The minimal solvers against known motions, and on samples that determine nothing.
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "two_view/pose_model.h"
#include "two_view/solvers/minimal_solvers.h"
#include "two_view_scene.h"

namespace gms_ransac {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kTrials = 2000;

/// Distance of two matrices up to scale and sign.
double distance(const Matrix3d& a, const Matrix3d& b) {
  const Matrix3d u = a / a.norm(), v = b / b.norm();
  return std::min((u - v).norm(), (u + v).norm());
}

double nearest(const Matrix3d* models, int count, const Matrix3d& truth) {
  double best = 2;
  for (int i = 0; i < count; ++i) best = std::min(best, distance(models[i], truth));
  return best;
}

TEST(RealRoots, FindsTheRootsOfProductsOfFactors) {
  std::mt19937_64 generator(3);
  std::uniform_real_distribution<double> uniform(-3, 3);
  for (int trial = 0; trial < 500; ++trial) {
    double c[11] = {1}, expected[10];
    const int degree = 1 + trial % 10;
    for (int k = 0; k < degree; ++k) {
      expected[k] = uniform(generator);
      for (int i = k + 1; i >= 0; --i) c[i] = (i > 0 ? c[i - 1] : 0) - expected[k] * c[i];
    }
    std::sort(expected, expected + degree);
    double gap = 1;
    for (int k = 1; k < degree; ++k) gap = std::min(gap, expected[k] - expected[k - 1]);
    if (gap < 0.05) continue;
    double roots[10];
    ASSERT_EQ(degree, solvePolynomial(c, degree, roots));
    for (int k = 0; k < degree; ++k) EXPECT_NEAR(expected[k], roots[k], 1e-7);
  }
}

TEST(RealRoots, FindsThoseOfPolynomialsWithMissingPowersAndRepeatedFactors) {
  const struct {
    std::vector<double> coefficients, roots;
  } cases[] = {{{-1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1}, {-1, 1}},  // x^10 - 1
               {{1, 0, -2, 0, 1}, {-1, 1}},                    // (x^2 - 1)^2
               {{1, 0, 2, 0, 1}, {}},                          // (x^2 + 1)^2
               {{0, 0, 0, 0, 0, 0, 0, 1}, {0}},                // x^7
               {{-8, 0, 0, 1}, {2}},                           // x^3 - 8
               {{0, -1, 0, 0, 0, 1}, {-1, 0, 1}},              // x^5 - x
               {{4, -4, -3, 2, 1}, {-2, 1}},                   // (x - 1)^2 (x + 2)^2
               {{-1, 3, -3, 1}, {1}},                          // (x - 1)^3
               {{0, 0, -4, 0, 1}, {-2, 0, 2}},                 // x^2 (x^2 - 4)
               {{1, 0, 0, 0, 1}, {}},                          // x^4 + 1
               {{-4, 12, -13, 6, -1}, {1, 2}},                 // -(x - 1)^2 (x - 2)^2
               {{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, {}},
               {{1, 0}, {}},
               {{1, 0, 1}, {}},
               {{-2, 1, 0, 0}, {2}},  // x - 2, of lower degree than it is given as
               {{1, std::nan(""), 1}, {}}};
  for (const auto& [coefficients, expected] : cases) {
    double roots[10];
    const int count = solvePolynomial(coefficients.data(), static_cast<int>(coefficients.size()) - 1, roots);
    std::vector<double> found(roots, roots + count);
    std::sort(found.begin(), found.end());
    ASSERT_EQ(found.size(), expected.size()) << testing::PrintToString(coefficients);
    for (size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], expected[i], 1e-6);
  }
}

/// N correspondences of views.
template <int N>
struct Sample {
  double x1[N][2], x2[N][2];

  explicit Sample(ExactViews& views, Vector3d (ExactViews::*point)() = &ExactViews::point) {
    for (int i = 0; i < N; ++i) views.project((views.*point)(), x1[i], x2[i]);
  }
};

/// Share of samples of points, of views that `alter` altered, from which the motion is recovered. `solutions`: of all.
template <typename Alter>
double recovered(int trials, Vector3d (ExactViews::*point)(), const Alter& alter, int* solutions = nullptr) {
  double accurate = 0;
  for (int trial = 0; trial < trials; ++trial) {
    ExactViews views(static_cast<uint64_t>(trial));
    alter(views);
    const Sample<5> sample(views, point);
    Matrix3d models[10];
    const int count = solveEssential5(sample.x1, sample.x2, models);
    accurate += nearest(models, count, crossMatrix(views.t) * views.R) < 1e-6;
    if (solutions == nullptr) continue;
    *solutions += count;
    for (int k = 0; k < count; ++k) {
      EXPECT_NEAR(std::sqrt(2.0), models[k].norm(), 1e-9);
      for (int i = 0; i < 5; ++i) {
        const Vector3d reference(sample.x1[i][0], sample.x1[i][1], 1), current(sample.x2[i][0], sample.x2[i][1], 1);
        EXPECT_LT(std::abs(current.dot(models[k] * reference)), 1e-8);
      }
    }
  }
  return accurate / trials;
}

TEST(Essential5, RecoversTheMotionAlsoWithoutRotationAndFromAPlane) {
  const auto as_it_is = [](ExactViews&) {};
  int solutions = 0;  // which meet the sample, all of them
  EXPECT_GT(recovered(kTrials, &ExactViews::point, as_it_is, &solutions), 0.98);
  EXPECT_GT(solutions, 2.5 * kTrials);
  EXPECT_GT(recovered(500, &ExactViews::pointOnPlane, as_it_is), 0.95);
  for (const Vector3d& t : {Vector3d(1, 0, 0), Vector3d(0, 1, 0), Vector3d(0, 0, 1)}) {
    const auto translate = [&](ExactViews& views) {
      views.R.setIdentity();
      views.t = t;
    };
    EXPECT_GT(recovered(200, &ExactViews::point, translate), 0.95) << t.transpose();
  }
}

TEST(Essential5, DecomposesIntoTheMotion) {
  for (int trial = 0; trial < 500; ++trial) {
    ExactViews views(static_cast<uint64_t>(trial));
    const EssentialDecomposition d = decomposeEssential(-3.0 * crossMatrix(views.t) * views.R);
    EXPECT_LT(std::min((d.R1 - views.R).norm(), (d.R2 - views.R).norm()), 1e-12);
    EXPECT_LT(std::min((d.t - views.t).norm(), (d.t + views.t).norm()), 1e-12);
    EXPECT_NEAR(1, d.R1.determinant(), 1e-12);
    EXPECT_NEAR(1, d.R2.determinant(), 1e-12);
  }
}

TEST(Fundamental7, RecoversTheMatrixInPixels) {
  Matrix3d K;
  K << 520, 0, 320, 0, 515, 240, 0, 0, 1;
  const Matrix3d Ki = K.inverse();
  int accurate = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    ExactViews views(static_cast<uint64_t>(trial));
    Sample<7> sample(views);
    for (auto* points : {&sample.x1, &sample.x2}) {
      for (auto& x : *points) {
        x[0] = K(0, 0) * x[0] + K(0, 2);
        x[1] = K(1, 1) * x[1] + K(1, 2);
      }
    }
    Matrix3d models[3];
    const int count = solveFundamental7(sample.x1, sample.x2, models);
    accurate += nearest(models, count, Ki.transpose() * crossMatrix(views.t) * views.R * Ki) < 1e-6;
    for (int k = 0; k < count; ++k) {
      // Determinant of the matrix scaled back to order-one coordinates.
      Matrix3d E = K.transpose() * models[k] * K;
      E /= E.norm();
      EXPECT_LT(std::abs(E.determinant()), 1e-8);
    }
  }
  EXPECT_GT(accurate, 0.98 * kTrials);
}

TEST(Homography4, RecoversTheMatrixInPixels) {
  std::mt19937_64 generator(7);
  std::uniform_real_distribution<double> pixel(0, 640), small(-1e-1, 1e-1);
  for (int trial = 0; trial < kTrials; ++trial) {
    Matrix3d H;
    H << 1 + small(generator), small(generator), 100 * small(generator), small(generator), 1 + small(generator),
        100 * small(generator), 1e-3 * small(generator), 1e-3 * small(generator), 1;
    double x1[4][2], x2[4][2];
    for (int i = 0; i < 4; ++i) {
      x1[i][0] = pixel(generator);
      x1[i][1] = pixel(generator);
      const Vector3d q = H * Vector3d(x1[i][0], x1[i][1], 1);
      x2[i][0] = q.x() / q.z();
      x2[i][1] = q.y() / q.z();
    }
    Matrix3d models[1];
    ASSERT_EQ(1, solveHomography4(x1, x2, models));
    EXPECT_LT(distance(models[0], H), 1e-6);
  }
}

TEST(Homography4, RefusesCollinearAndRepeatedPoints) {
  const double square[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}}, collinear[4][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}},
               repeated[4][2] = {{0, 0}, {0, 0}, {1, 1}, {0, 1}}, same[4][2] = {{2, 3}, {2, 3}, {2, 3}, {2, 3}};
  Matrix3d models[1];
  EXPECT_EQ(1, solveHomography4(square, square, models));
  EXPECT_EQ(0, solveHomography4(square, collinear, models));
  EXPECT_EQ(0, solveHomography4(collinear, square, models));
  EXPECT_EQ(0, solveHomography4(repeated, square, models));
  EXPECT_EQ(0, solveHomography4(same, same, models));
}

enum class Degenerate { kCollinear, kRepeated, kAllEqual, kCoplanar, kPureRotation, kNoMotion, kInfinite };

/// N points of that kind seen by `views`, and the models that the solver finds for them.
template <int N, typename Solver>
void expectFiniteModels(Degenerate kind, ExactViews& views, int most, const Solver& solve) {
  if (kind == Degenerate::kPureRotation || kind == Degenerate::kNoMotion) views.t.setZero();
  if (kind == Degenerate::kNoMotion) views.R.setIdentity();
  const Vector3d first = views.point(), second = views.point();
  double x1[N][2], x2[N][2];
  for (int i = 0; i < N; ++i) {
    Vector3d X = views.point();
    if (kind == Degenerate::kCollinear) X = first + 0.3 * i * (second - first);
    if (kind == Degenerate::kRepeated && i % 2) X = first;
    if (kind == Degenerate::kAllEqual) X = first;
    if (kind == Degenerate::kCoplanar) X = views.pointOnPlane();
    if (kind == Degenerate::kInfinite) X *= 1e12;
    views.project(X, x1[i], x2[i]);
  }
  Matrix3d models[10];
  const int count = solve(x1, x2, models);
  ASSERT_LE(count, most);
  for (int k = 0; k < count; ++k) EXPECT_TRUE(models[k].allFinite()) << static_cast<int>(kind);
}

TEST(DegenerateSample, GivesFiniteModelsOnly) {
  for (int kind = 0; kind <= static_cast<int>(Degenerate::kInfinite); ++kind) {
    for (int trial = 0; trial < 300; ++trial) {
      ExactViews views(static_cast<uint64_t>(trial));
      expectFiniteModels<5>(static_cast<Degenerate>(kind), views, 10, solveEssential5);
      expectFiniteModels<7>(static_cast<Degenerate>(kind), views, 3, solveFundamental7);
      expectFiniteModels<4>(static_cast<Degenerate>(kind), views, 1, solveHomography4);
    }
  }
}

}  // namespace
}  // namespace gms_ransac
