#include "core/solve/conjugate_gradients.hpp"

#include <cmath>

namespace finegauge {

SolveReport conjugate_gradients(const BlockMatrix<double>& A, const Eigen::VectorXd& b, const Preconditioner& M,
                                const IterationLimits& limits, Eigen::VectorXd& x) {
  SolveReport report;
  // Squares decide: in units scaled by powers of two they are the same numbers, exactly scaled.
  const double target = limits.relative_residual * limits.relative_residual * b.squaredNorm();
  if (b.squaredNorm() == 0.0) {
    x.setZero(b.size());
    report.converged = true;
    return report;
  }
  Eigen::VectorXd Ap, z, p;
  multiply(A, x, Ap);
  Eigen::VectorXd r = b - Ap;
  double residual = r.squaredNorm(), rz = 0.0;
  // The recursive residual drifts from the true one by round-off; when it says "done" the true one decides, and the
  // iteration starts afresh from there if it does not agree.
  while (std::isfinite(residual)) {
    if (residual <= target) {
      multiply(A, x, Ap);
      r = b - Ap;
      residual = r.squaredNorm();
      if (residual <= target) {
        report.converged = true;
        break;
      }
      rz = 0.0;
    }
    if (report.iterations >= limits.iterations) break;
    M(r, z);
    const double rz_new = r.dot(z);
    if (!(rz_new > 0.0)) break;
    if (rz == 0.0)
      p = z;
    else
      p = z + (rz_new / rz) * p;
    rz = rz_new;
    multiply(A, p, Ap);
    const double pAp = p.dot(Ap);
    if (!(pAp > 0.0)) break;
    const double alpha = rz / pAp;
    x += alpha * p;
    r -= alpha * Ap;
    residual = r.squaredNorm();
    ++report.iterations;
  }
  multiply(A, x, Ap);
  report.relative_residual = (b - Ap).norm() / b.norm();
  return report;
}

}  // namespace finegauge
