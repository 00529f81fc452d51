#pragma once

#include <Eigen/Core>
#include <array>
#include <span>

#include "core/elasticity/cell_response.hpp"

namespace finegauge {

using VoigtColumns = Eigen::Matrix<double, 6, Eigen::Dynamic>;  ///< a stress per cell or node [Pa]

/// How many terms a patch's polynomial has.
enum class PatchBasis {
  mean,      ///< 1
  linear,    ///< 1 x y z
  trilinear  ///< 1 x y z xy yz zx xyz
};

/// Polynomial through the stresses at the centres of a patch's cells: p(X) = Σ_k coefficients_k b_k(y) in patch
/// coordinates y = to_patch (X - origin), in which the centres fill [-1, 1]³. Term k is the product of the y_i whose
/// bit i is set in k: 1 x y xy z zx yz xyz. A shift of the origin or a scaling along the axes does not change which
/// polynomials these terms span, so the origin may lie where the conditioning is best.
struct PatchPolynomial {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();                                ///< [m]
  Eigen::Matrix3d to_patch = Eigen::Matrix3d::Zero();                              ///< [1/m]
  Eigen::Matrix<double, 6, 8> coefficients = Eigen::Matrix<double, 6, 8>::Zero();  ///< [Pa]
  PatchBasis basis = PatchBasis::mean;
  double condition = 1.0;  ///< 1-norm condition of the normal matrix of this basis, in patch coordinates

  Voigt operator()(const Eigen::Vector3d& X) const;
  /// Largest patch coordinate of X in magnitude. In a regular patch of hexahedra the centres reach to 1, the cells
  /// to 2.
  double distance(const Eigen::Vector3d& X) const;
};

/// Largest condition (1-norm) of the normal matrix in patch coordinates with which a basis is used. Regular patches
/// have 1, refinement fronts over one to four levels 6 to 130. At the bound, errors of single stresses can grow a
/// hundredfold.
inline constexpr double largest_patch_condition = 1.0e4;

/// Least-squares fit with the largest basis up to `most` that the centres determine. `axes`: columns are the directions
/// of the patch coordinates, of any length, not coplanar; the trilinear terms depend on them, the linear ones do not.
PatchPolynomial fit_patch(std::span<const int> cells, const Eigen::Matrix3Xd& centres, const VoigtColumns& values,
                          const Eigen::Matrix3d& axes, PatchBasis most);

/// Eight cells around a node, cell k in octant k (bit i set: on the upper side along axis i of the cells).
/// `linear_part` has the mean directions of the patch as columns. `polynomial` is the trilinear fit where the centres
/// form a lattice of parallelepipeds: then the normal matrix is 8 I and no system has to be solved. It equals fit_patch
/// with these axes to round-off.
struct OctantFit {
  Eigen::Matrix3d linear_part;
  bool is_lattice;
  PatchPolynomial polynomial;  ///< set if is_lattice
};
OctantFit fit_octants(const std::array<int, 8>& cells, const Eigen::Matrix3Xd& centres, const VoigtColumns& values);

}  // namespace finegauge
