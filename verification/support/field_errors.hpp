#pragma once

#include <Eigen/Core>

#include "core/space/discretization.hpp"
#include "verification/support/manufactured_solution.hpp"

namespace finegauge {

/// Errors of a finite element solution against a manufactured one, and the solution's own size. Linear kinematics,
/// hexahedra.
struct FieldErrors {
  double displacement = 0.0, displacement_norm = 0.0;  ///< sqrt ∫ |u_h - u|², sqrt ∫ |u|² [m^2.5]
  double nodal = 0.0, nodal_norm = 0.0;                ///< sqrt Σ |u_h - u|² over inner nodes, sqrt Σ |u|² [m]
  double energy = 0.0, energy_norm = 0.0;  ///< sqrt ∫ (σ_h - σ):C⁻¹:(σ_h - σ), sqrt ∫ σ:C⁻¹:σ [√J]
  double recovered_stress = 0.0;           ///< the same of the recovered stress, interpolated from the nodes [√J]
  Eigen::VectorXd cell_energy;             ///< per cell, the energy error [√J]
};

/// σ_h at a point [Pa], of corner displacements and gradients there: with Dilatation::mean the volumetric part is the
/// cell's.
Voigt discrete_stress(const Material& material, const CellVectors& u, const Gradients& gradients,
                      const Gradients& mean_gradients);

/// Gauss-Legendre with `points_per_axis`³ points in each leaf.
FieldErrors field_errors(const Discretization& d, const ManufacturedSolution& exact, const Eigen::Matrix3Xd& u,
                         const Eigen::Matrix<double, 6, Eigen::Dynamic>& nodal_stress, int points_per_axis = 4);

}  // namespace finegauge
