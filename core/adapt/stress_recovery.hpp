#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/adapt/patch_polynomial.hpp"
#include "core/elasticity/cell_response.hpp"
#include "core/mesh/hanging_nodes.hpp"
#include "core/space/discretization.hpp"

namespace finegauge {

/// Stresses of the finite element solution, global frame [Pa].
struct CellStresses {
  Eigen::Matrix<double, 6, Eigen::Dynamic> centre;      ///< 6 × cells
  Eigen::Matrix<double, 6, Eigen::Dynamic> quadrature;  ///< 6 × (cells · quadrature points)
};
CellStresses cell_stresses(const Discretization& d, const Eigen::Matrix3Xd& u);

/// Share of material from which the stress at a cell's centre counts as a sample in the recovery: with less the centre
/// mostly lies outside the body, where the stress is what the extended shape functions make of it and superconverges to
/// nothing.
inline constexpr double least_sampled_share = 0.5;

/// Nodal stresses by superconvergent patch recovery (Zienkiewicz & Zhu 1992), global frame [Pa], 6 × n_nodes.
///
/// - A node inside the body that does not hang: the least-squares polynomial through the stresses at the centres of the
///   cells around it, in coordinates centred among those centres and scaled by their extent (patch_polynomial.hpp);
///   hexahedra 1 x y z xy yz zx xyz, tetrahedra 1 x y z; fewer terms where the patch does not determine all.
/// - A node on the boundary: the mean of the polynomials of the inner nodes that share a cell with it. Where there is
///   none, of those that share a cell with a neighbour and whose patch, grown by one layer of cells of its own size,
///   reaches the node. Where there is none either, and so in all of a body without inner nodes, its own patch: linear
///   where that determines it, else the mean of its cells. Where an eight-term polynomial is poorly determined
///   (condition above 100: uneven refinement around its node) boundary nodes are given the linear one of that patch.
/// - A node that hangs: interpolated from its masters.
///
/// In an immersed body a node with a cell of less than `least_sampled_share` around it is treated as a node on the
/// boundary, and where its own patch decides, such cells are left out as long as others remain.
///
/// `most` = PatchBasis::linear leaves out the mixed terms everywhere: a poorer fit, but one that does not carry
/// alternating errors of the samples, such as the pressures of a mean dilatation on distorted cells, to the boundary.
Eigen::Matrix<double, 6, Eigen::Dynamic> recover_stress_spr(const Discretization& d, const CellStresses& stresses,
                                                            PatchBasis most = PatchBasis::trilinear);

/// The recovered stress σ_s = G σ_h with what the recovery takes from a smooth stress given back: G σ_h + (σ_s - G
/// σ_s), the last one recovered from σ_s at the cells' centres ("twicing", Tukey 1977). Averaging flattens waves by
/// O(h²); applied to σ_s, which is smooth, G shows by how much. Interpolated from the nodes to the centres of regular
/// cells the result is of fourth order. Linear stresses stay exact. Two recoveries long to compute.
///
/// In both recoveries the stress at nodes of the free surface is made P σ P by `free_directions` (free_surface.hpp)
/// (recovery constrained to the tractions, as in Ródenas et al. 2007, but at the nodes alone): what inner patches
/// extrapolate to the surface of tetrahedra follows the cells there so closely that near a singular edge they would
/// show a third of their error.
Eigen::Matrix<double, 6, Eigen::Dynamic> recover_stress_twice(const Discretization& d, const CellStresses& stresses,
                                                              const std::vector<Eigen::Matrix3d>& free_directions = {});

}  // namespace finegauge
