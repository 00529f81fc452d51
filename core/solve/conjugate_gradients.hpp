#pragma once

#include <Eigen/Core>
#include <functional>
#include <limits>

#include "core/solve/solve_report.hpp"
#include "core/space/block_matrix.hpp"

namespace finegauge {

using Preconditioner = std::function<void(const Eigen::VectorXd& r, Eigen::VectorXd& z)>;

struct IterationLimits {
  double relative_residual = 1e-6;  ///< ‖b - A x‖ ≤ this × ‖b‖
  int iterations = 1000;
};

/// Whether x may stay as it is, by how the last iteration changed it. Conjugate gradients change x by about its error
/// before the iteration where they converge fast (the delay of one of Strakoš & Tichý 2002, in any measure of x).
using Settled = std::function<bool(const Eigen::VectorXd& change)>;

/// Preconditioned conjugate gradients from the x given. Reports non-convergence and breakdown; never throws for them.
/// With `settled` x is the solution only where that agrees too.
SolveReport conjugate_gradients(const BlockMatrix<double>& A, const Eigen::VectorXd& b, const Preconditioner& M,
                                const IterationLimits& limits, Eigen::VectorXd& x, const Settled& settled = {});

// The same iteration with its parts given: an operator that is no matrix, a preconditioner that is renewed on the way.

enum class Renewal { none, renewed, failed };
struct ConjugateGradientParts {
  std::function<void(const Eigen::VectorXd& x, Eigen::VectorXd& y)> apply;  ///< y = A x
  Preconditioner precondition;                                              ///< z = M⁻¹ r
  /// Asked before every iteration with the number of those done; may be empty. Renewed: M is another from here on, and
  /// the iteration starts afresh from the x it has. Failed: it ends.
  std::function<Renewal(int iterations)> renew;
  /// Asked where the residual suffices; may be empty. A start is not asked about and does not suffice by itself, unless
  /// b - A x is zero.
  Settled settled;
};
struct ConjugateGradientRules {
  /// ‖b - A x‖² at which x is the solution. A square, as all that decides: in units scaled by powers of two squares are
  /// the same numbers, exactly scaled.
  double squared_residual = 0.0;
  int iterations = 1000;
  int least_iterations = 0;  ///< done however good the start, unless b - A x is zero
  /// The recursive residual drifts from the true one by round-off. Where it says "done" and the true one does not agree
  /// the iteration starts afresh; unless ‖b - A x‖² is above this share of what it was at the last such place: that is
  /// the round-off of b - A x itself.
  double stagnation = std::numeric_limits<double>::infinity();
};
/// Kept between solves, so that none is allocated anew.
struct ConjugateGradientVectors {
  Eigen::VectorXd r, z, p, Ap;
};
/// From the x given; r = b - A x, the true residual, when it returns. What that is relative to the caller knows:
/// relative_residual is not set.
SolveReport conjugate_gradients(const ConjugateGradientParts& parts, const Eigen::VectorXd& b,
                                const ConjugateGradientRules& rules, ConjugateGradientVectors& vectors,
                                Eigen::VectorXd& x);

}  // namespace finegauge
