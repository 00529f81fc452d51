#include "core/solve/conjugate_gradients.hpp"

#include <cmath>

namespace finegauge {

SolveReport conjugate_gradients(const ConjugateGradientParts& parts, const Eigen::VectorXd& b,
                                const ConjugateGradientRules& rules, ConjugateGradientVectors& vectors,
                                Eigen::VectorXd& x) {
  // Not by a structured binding: clang before 16 lets no lambda refer to one.
  Eigen::VectorXd &r = vectors.r, &z = vectors.z, &p = vectors.p, &Ap = vectors.Ap;
  SolveReport report;
  double residual = 0.0, rz = 0.0, alpha = 0.0, last_checked = INFINITY;
  bool checked = false;  // r is b - A x and not its recursion
  const auto check = [&] {
    parts.apply(x, Ap);
    r = b - Ap;
    residual = r.squaredNorm();
    checked = true;
  };
  const auto settled = [&] {
    if (report.iterations < rules.least_iterations) return false;
    return !parts.settled || (report.iterations > 0 && parts.settled(alpha * p));
  };
  check();
  while (std::isfinite(residual)) {
    if (residual <= rules.squared_residual && (residual == 0.0 || settled())) {
      if (!checked) check();
      if (residual <= rules.squared_residual) {
        report.converged = true;
        break;
      }
      if (residual > rules.stagnation * last_checked) break;
      last_checked = residual;
      rz = 0.0;
    }
    if (report.iterations >= rules.iterations) break;
    const Renewal renewal = parts.renew ? parts.renew(report.iterations) : Renewal::none;
    if (renewal == Renewal::failed) break;
    if (renewal == Renewal::renewed) {
      check();
      rz = 0.0;
    }
    parts.precondition(r, z);
    const double rz_new = r.dot(z);
    if (!(rz_new > 0.0)) break;
    if (rz == 0.0)
      p = z;
    else
      p = z + (rz_new / rz) * p;
    rz = rz_new;
    parts.apply(p, Ap);
    const double pAp = p.dot(Ap);
    if (!(pAp > 0.0)) break;
    alpha = rz / pAp;
    if (!std::isfinite(alpha)) break;
    x += alpha * p;
    r -= alpha * Ap;
    residual = r.squaredNorm();
    checked = false;
    ++report.iterations;
  }
  if (!checked) check();
  return report;
}

SolveReport conjugate_gradients(const BlockMatrix<double>& A, const Eigen::VectorXd& b, const Preconditioner& M,
                                const IterationLimits& limits, Eigen::VectorXd& x, const Settled& settled) {
  const double b_squared = b.squaredNorm();
  if (b_squared == 0.0) {
    x.setZero(b.size());
    return {true, 0, 0.0};
  }
  const ConjugateGradientParts parts = {
      [&A](const Eigen::VectorXd& y, Eigen::VectorXd& Ay) { multiply(A, y, Ay); }, M, {}, settled};
  ConjugateGradientRules rules;
  rules.squared_residual = limits.relative_residual * limits.relative_residual * b_squared;
  rules.iterations = limits.iterations;
  ConjugateGradientVectors vectors;
  SolveReport report = conjugate_gradients(parts, b, rules, vectors, x);
  report.relative_residual = vectors.r.norm() / b.norm();
  return report;
}

}  // namespace finegauge
