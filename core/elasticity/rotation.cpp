#include "core/elasticity/rotation.hpp"

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
  // Singular values descend, so the last column belongs to the smallest.
  if (U.determinant() * V.determinant() < 0.0) U.col(2) = -U.col(2);
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
