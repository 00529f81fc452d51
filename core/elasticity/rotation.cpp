#include "core/elasticity/rotation.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>
#include <limits>

namespace finegauge {

namespace {

/// det A A⁻ᵀ.
Eigen::Matrix3d cofactors(const Eigen::Matrix3d& A) {
  Eigen::Matrix3d C;
  C.col(0) = A.col(1).cross(A.col(2));
  C.col(1) = A.col(2).cross(A.col(0));
  C.col(2) = A.col(0).cross(A.col(1));
  return C;
}

/// Definition by singular values: good for every finite F, and some twenty times slower than the iteration.
Eigen::Matrix3d rotation_by_singular_values(const Eigen::Matrix3d& F) {
  const double largest = F.cwiseAbs().maxCoeff();
  if (largest == 0.0) return Eigen::Matrix3d::Identity();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(F / largest, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d U = svd.matrixU();
  const Eigen::Matrix3d& V = svd.matrixV();
  const Eigen::Vector3d& s = svd.singularValues();
  const bool reversed = U.determinant() * V.determinant() < 0.0;
  // Of several rotations that are equally near (a line, a mirror image), the one that turns least: neighbours then
  // agree, and what is let go finds its way back. tie: below this nothing but round-off tells them apart.
  const double tie = 1e-12 * s[0];
  if (reversed && s[0] - s[2] <= tie) {  // a reflection reversed along any direction n: Q (I - 2 n nT)
    const Eigen::Matrix3d Q = U * V.transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> symmetric(0.5 * (Q + Q.transpose()));
    const Eigen::Vector3d n = symmetric.eigenvectors().col(0);
    return Q - 2.0 * (Q * n) * n.transpose();
  }
  if (s[1] + (reversed ? -s[2] : s[2]) <= tie) {  // any turn in the plane of the two smaller ones
    const Eigen::Matrix2d M = U.rightCols<2>().transpose() * V.rightCols<2>();
    Eigen::Vector2d turn = reversed ? Eigen::Vector2d(M(0, 0) - M(1, 1), M(0, 1) + M(1, 0))
                                    : Eigen::Vector2d(M(0, 0) + M(1, 1), M(1, 0) - M(0, 1));
    if (turn.norm() > 1e-12)
      turn.normalize();
    else
      turn = {1.0, 0.0};
    Eigen::Matrix2d Q;
    if (reversed)
      Q << turn[0], turn[1], turn[1], -turn[0];
    else
      Q << turn[0], -turn[1], turn[1], turn[0];
    return U.col(0) * V.col(0).transpose() + U.rightCols<2>() * Q * V.rightCols<2>().transpose();
  }
  // Singular values descend, so the last column belongs to the smallest.
  if (reversed) U.col(2) = -U.col(2);
  return U * V.transpose();
}

}  // namespace

Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& F) {
  // A state that has diverged has no rotation; the caller's residual shows it.
  if (!F.allFinite()) return Eigen::Matrix3d::Constant(std::numeric_limits<double>::quiet_NaN());

  // det / norm³ is 0.19 for a rotation. The iteration needs det > 0; below the bound here it would lose digits.
  constexpr double smallest_relative_determinant = 1e-4;
  const double norm = F.norm();
  const Eigen::Matrix3d C0 = cofactors(F);
  const double det0 = F.col(0).dot(C0.col(0));
  const bool in_range = norm > 1e-60 && norm < 1e60;
  if (!(in_range && det0 > smallest_relative_determinant * norm * norm * norm)) return rotation_by_singular_values(F);

  // R <- (gamma R + R⁻ᵀ / gamma) / 2, with Higham's scaling by Frobenius norms as long as it is far from a rotation.
  Eigen::Matrix3d R = F;
  Eigen::Matrix3d C = C0;
  double det = det0;
  constexpr int enough = 20;  // quadratic convergence: nine steps suffice at the bound above
  for (int step = 0; step < enough; ++step) {
    const Eigen::Matrix3d inverse_transpose = C / det;
    const double change = (R - inverse_transpose).squaredNorm();
    double gamma = 1.0;
    if (change > 1e-2) gamma = std::sqrt(inverse_transpose.norm() / R.norm());
    R = 0.5 * (gamma * R + (1.0 / gamma) * inverse_transpose);
    // A step maps the distance to orthogonality δ to δ² / 2; below this it has reached round-off.
    if (change < 1e-15) break;
    C = cofactors(R);
    det = R.col(0).dot(C.col(0));
  }
  return R;
}

}  // namespace finegauge
