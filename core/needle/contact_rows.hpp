#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/needle/tissue_coupling.hpp"

namespace finegauge {

/// Sign convention of all constraints, decided here: a point's relative velocity is r = N v_needle - Σ w_i v_tissue,i,
/// its rows are the components of r along n (the needle's tangent, positive for advance), t1 and t2. J stacks these
/// rows; the impulses λ [N s] enter as A dv = b - Jᵀ λ: positive λ_n pushes the needle back and the tissue forward. A
/// violation is reduced by λ <- λ + W (J dv - rhs), W > 0.
enum class AxialLaw {
  none,
  bilateral,   ///< J_n (v + dv) + g_n/τ = 0, λ_n of either sign
  unilateral,  ///< J_n (v + dv) + g_n/τ <= 0, λ_n >= 0, complementary; g_n > 0: penetration
  friction     ///< J_n (v + dv) = 0 while -friction_out N <= λ_n <= friction_in N, N = |λ_t| + clamp τ (Coulomb)
};
enum class LateralLaw {
  none,
  bilateral,  ///< J_t (v + dv) + g_t/τ = 0
  coulomb  ///< J_t (v + dv) = 0 while |λ_t| <= surface_friction λ_n; slips along the relative velocity at the bound
};

/// One point where needle and tissue meet, for one frame.
struct ContactRows {
  ReducedWeights tissue;
  int element = 0;                      ///< of the needle
  Eigen::Matrix<double, 3, 12> needle;  ///< N of the element's two nodes
  Eigen::Matrix3d frame;                ///< columns n, t1, t2, orthonormal
  AxialLaw axial = AxialLaw::none;
  LateralLaw lateral = LateralLaw::none;
  Eigen::Vector3d gap =
      Eigen::Vector3d::Zero();  ///< position of the needle's point minus the tissue's, in the frame [m]
  double friction_in = 0.0, friction_out = 0.0;      ///< of AxialLaw::friction: against advance, against withdrawal
  double clamp = 0.0;                                ///< p ℓ [N]
  double surface_friction = 0.0;                     ///< of LateralLaw::coulomb
  Eigen::Vector3d lambda = Eigen::Vector3d::Zero();  ///< start value [N s], in the frame; none-rows are ignored
};

/// Frame of a point's rows: n, and the second column as near to `like` as it can be.
Eigen::Matrix3d frame_along(const Eigen::Vector3d& n, const Eigen::Vector3d& like);

}  // namespace finegauge
