#pragma once

#include <Eigen/Core>
#include <deque>

namespace finegauge {

/// How many differences of iterates the corotational iterations mix. From 5 on bending cantilevers hardly gain.
inline constexpr int mixing_depth = 5;

/// Accelerates a fixed-point iteration x <- x + g(x) from its last few steps (Anderson 1965; Walker & Ni 2011, type
/// II): the combination of the stored iterates whose g is smallest is found by least squares, and the step is taken
/// from it. On a linear problem it is GMRES in disguise; like that it also converges where the plain iteration
/// oscillates.
class AndersonMixing {
 public:
  /// `depth`: how many differences of iterates are kept; zero is the plain iteration.
  explicit AndersonMixing(int depth) : depth_(depth) {}

  /// The next iterate from the present one and its g.
  Eigen::VectorXd next(const Eigen::VectorXd& x, const Eigen::VectorXd& g);

 private:
  int depth_;
  std::deque<Eigen::VectorXd> x_changes_, g_changes_;  // oldest first, between consecutive calls
  Eigen::VectorXd last_x_, last_g_;
};

}  // namespace finegauge
