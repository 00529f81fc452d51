#pragma once

#include <Eigen/Core>
#include <string>

#include "core/static_step.hpp"

namespace finegauge {

/// An estimate that is meant never to be below the error: the distance of the solution's stress from one that is in
/// equilibrium with the loads (Ladevèze & Leguillon 1983, error in the constitutive relation; Prager & Synge 1947).
///
/// - Tractions between cells: those of the recovered stress (SPR), one value for both sides; on loaded and on free
///   surfaces what is prescribed there. Plus the smallest change, measured by cell size times traction squared, that
///   puts each cell in equilibrium under its tractions and body forces. The change on a face is the difference of two
///   rigid motions, one for each of its cells: one symmetric positive definite system with six unknowns a cell. Hanging
///   faces are split into what they share (mesh/face_patches.hpp), so any mix of templates will do.
/// - In each cell the displacement w under these tractions, polynomials of `degree` along each axis: η_e² = ∫ (ε(w) -
///   ε_h):D:(ε(w) - ε_h). With exact local solutions Σ η_e² bounds the error's energy from above; polynomials lose a
///   little of it, less the higher their degree.
///
/// With Dilatation::mean the distance is that of the stresses, in the norm of C⁻¹. The error of interpolating
/// prescribed displacements is not part of it.
struct EquilibratedEstimate {
  Eigen::VectorXd eta;       ///< per cell [√J]; empty where there is no estimate
  double total = 0.0;        ///< sqrt Σ η_e² [√J]
  double relative = 0.0;     ///< total over that of the solution; zero when both vanish
  double imbalance = 0.0;    ///< largest force or moment (over the cell's size) left on a cell, over the largest before
  double correction = 0.0;   ///< sqrt Σ h ∫ |change of traction|² / E [√J]: how far SPR was from equilibrium
  std::string why_not = {};  ///< where there is none

  bool exists() const { return why_not.empty(); }
};

struct EquilibratedOptions {
  int degree = 2;  ///< of the local solutions, 2 to 4: 2 is what the ladder gates
};

/// For linear kinematics on hexahedra that are full of material, held and loaded on surfaces by tractions, total forces
/// by area and body forces. What is none of that is refused in words (`why_not`). `spr`: of the same solution.
EquilibratedEstimate estimate_error_equilibrated(const RefinementForest& forest, const Discretization& d,
                                                 const StaticProblem& problem, const Eigen::Matrix3Xd& u,
                                                 const ErrorEstimate& spr, const EquilibratedOptions& options = {});

}  // namespace finegauge
