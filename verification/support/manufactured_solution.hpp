#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/elasticity/cell_response.hpp"
#include "core/elasticity/material.hpp"
#include "core/space/supports.hpp"
#include "verification/support/jet.hpp"

namespace finegauge {

/// A displacement chosen beforehand, given once as a formula in jets. Strain, stress and the body force that balances
/// it follow by automatic differentiation; linear isotropic elasticity.
struct ManufacturedSolution {
  std::string name;
  Jets (*formula)(const Jets& x);  ///< displacement [m] of the rest position [m]
};

Eigen::Vector3d displacement(const ManufacturedSolution& solution, const Eigen::Vector3d& X);            ///< [m]
Voigt stress(const ManufacturedSolution& solution, const Material& material, const Eigen::Vector3d& X);  ///< [Pa]
/// -div σ = -(lambda + mu) grad div u - mu Δu [N/m³].
Eigen::Vector3d body_force(const ManufacturedSolution& solution, const Material& material, const Eigen::Vector3d& X);

/// The solution on all six sides of a box, each named x_min to z_max.
std::vector<SupportCondition> held_all_around(const ManufacturedSolution& solution);

/// 0.1 (sin πx cos πy e^{z/2}, cos πx sin πz + xyz, sin(π(x + y)) z²): no component is a sum of functions of one
/// coordinate, for which trilinear hexahedra are exact at the nodes and prove nothing.
ManufacturedSolution smooth_solution();
/// 0.1 curl (ψ, ψ, ψ), ψ = sin πx sin πy sin πz: keeps its volume, so its stress stays bounded as nu -> 1/2. The body
/// force is 3 mu π² u.
ManufacturedSolution isochoric_solution();

}  // namespace finegauge
