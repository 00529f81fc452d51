#pragma once

#include <Eigen/Core>

#include "core/space/discretization.hpp"

namespace finegauge {

/// Row-sum lumped mass of the reduced space, per node that does not hang [kg]: m_i = ∫ ρ φ_i, with φ_i the function of
/// node i, hanging nodes included: m = Tᵀ m_nodal. The sum is the mass of the body to round-off, and m of a coarser
/// mesh is the adjoint interpolation of that of a finer one.
///
/// A cell that is filled in part has ρ times its share of material all over. The total is then as exact as the shares
/// are; a finer mesh, whose cells have shares of their own, knows better where in the cell the mass is, so there the
/// adjointness does not hold. A node whose cells have no material has no mass: zero, exactly.
///
/// Where T has negative weights (six of 200,000 random forests of all templates have some, down to -1/3; nested halves,
/// thirds and 2x3x3 were never seen to) a row sum may cancel or turn negative. The cells of a node that
/// keeps less than `least_share` of the sum of its contributions' magnitudes are lumped by diagonal scaling instead
/// (Hinton, Rock & Zienkiewicz 1976): the cell's mass is shared as ∫ φ_i² over the cell. Every mass beside material is
/// positive then and the total is kept, but there the adjointness holds no more.
Eigen::VectorXd lumped_mass(const Discretization& d, double density);

/// See lumped_mass. Any share in (0, 1) gives positive masses; a tenth leaves no node so light that it alone would set
/// the highest frequency, and touches nothing where weights are positive (their share is one).
inline constexpr double least_share = 0.1;

/// The cells that lumped_mass scales, ascending; mostly none.
std::vector<int> cells_with_scaled_mass(const Discretization& d);

}  // namespace finegauge
