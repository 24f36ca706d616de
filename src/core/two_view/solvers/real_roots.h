// Real roots of the polynomials the minimal solvers end in.
#pragma once

namespace gms_ransac {

/// Real roots of c[0] + c[1] x + c[2] x^2 + c[3] x^3; lower degrees are handled. Returns their number, 0..3.
int solveCubic(const double (&c)[4], double (&roots)[3]);

/// Distinct real roots of the polynomial with coefficients c[0] + ... + c[degree] x^degree, degree <= 10: isolated by
/// Sturm's theorem, refined by bracketed Newton steps to about 1e-13 relative. Returns their number; ascending order.
int solvePolynomial(const double* c, int degree, double (&roots)[10]);

}  // namespace gms_ransac
