#pragma once

#include <Eigen/Core>
#include <vector>

namespace finegauge {

/// Symmetric block-tridiagonal matrix of 6 × 6 blocks, three translations and three rotations a node.
struct ChainMatrix {
  std::vector<Eigen::Matrix<double, 6, 6>> diagonal;  ///< per node
  std::vector<Eigen::Matrix<double, 6, 6>> upper;     ///< (i, i + 1)

  int node_count() const { return static_cast<int>(diagonal.size()); }
  /// A zero matrix of that many nodes; keeps its memory.
  void set_zero(int nodes);
};
/// y = A x.
void multiply(const ChainMatrix& A, const Eigen::VectorXd& x, Eigen::VectorXd& y);

/// Block LDLᵀ of a symmetric chain matrix, positive definite or not (no pivoting between nodes, so that a singular
/// leading part of a regular matrix is reported as not factored). Each node's pivot is inverted with the complete
/// pivoting of Bunch & Parlett (1971), decided by ratios without units: translations are measured by the
/// size of the node's own block of translations, rotations by that of rotations (neither may be zero as a whole). A
/// chain whose units of length or force change by powers of two gives the same digits.
class ChainFactor {
 public:
  ChainFactor() = default;
  explicit ChainFactor(const ChainMatrix& A) { factor(A); }
  /// Anew, in the memory at hand.
  void factor(const ChainMatrix& A);
  /// False where a pivot is not finite or, beside the node's own block, below round-off; solve must not be called then.
  bool factored() const { return factored_; }
  int negative_pivots() const { return negative_pivots_; }  ///< number of negative eigenvalues (Sylvester)
  /// x <- A⁻¹ x, in place; columns are right sides.
  void solve(Eigen::Ref<Eigen::MatrixXd> x) const;

 private:
  std::vector<Eigen::Matrix<double, 6, 6>> inverse_pivots_;  ///< D_i⁻¹
  std::vector<Eigen::Matrix<double, 6, 6>> lower_;           ///< block (i + 1, i) of L
  bool factored_ = false;
  int negative_pivots_ = 0;
};

/// Which dofs of a node are held: bit k for entry k of its six.
using HeldDofs = std::vector<unsigned>;  ///< per node
inline constexpr unsigned hold_all = 63u, hold_position = 7u, hold_rotation = 56u;
/// Held rows and columns become those of a positive diagonal matrix of the node's own scale: the size of the entry that
/// was there, or where that is zero of the largest of the node's translations or rotations, or one.
void hold(const HeldDofs& held, ChainMatrix& A);
/// Held entries become zero.
void hold(const HeldDofs& held, Eigen::VectorXd& x);

}  // namespace finegauge
