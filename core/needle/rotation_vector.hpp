#pragma once

#include <Eigen/Core>

namespace finegauge {

/// [a]×, so that [a]× b = a × b.
Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& a);

/// exp [a]×: the turn about a by |a| radians.
Eigen::Matrix3d rotation_of(const Eigen::Vector3d& a);
/// log R as a vector, |log R| ≤ π. Exact to round-off for small turns too; discontinuous at half turns, so that it may
/// be taken of rotations that are measured in a frame close by, never of total ones.
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R);
/// One step of Newton towards the nearest rotation, R (3 I - Rᵀ R) / 2: squares the distance of an almost orthonormal
/// R.
Eigen::Matrix3d orthonormalized(const Eigen::Matrix3d& R);

/// How the rotation vector changes with a turn from the left: log(exp([δ]×) exp([Θ]×)) = Θ + T⁻¹(Θ) δ + O(δ²),
/// T⁻¹ = I - [Θ]× / 2 + η(|Θ|) [Θ]×². Finite for |Θ| < 2π.
Eigen::Matrix3d inverse_rotation_tangent(const Eigen::Vector3d& Theta);
/// ∂(T⁻ᵀ(Θ) m) / ∂Θ with m held fixed.
Eigen::Matrix3d derivative_of_transposed_tangent(const Eigen::Vector3d& Theta, const Eigen::Vector3d& m);

}  // namespace finegauge
