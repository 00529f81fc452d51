#pragma once

#include <string>
#include <vector>

#include "core/elasticity/material.hpp"
#include "core/mesh/refinement_forest.hpp"
#include "verification/studies/manufactured_static.hpp"
#include "verification/support/convergence.hpp"
#include "verification/support/evidence.hpp"

// Corotational statics at finite rotation, held against two things that must not be mixed up. First the discrete
// operator: its own internal forces, taken as loads, have to give the displacement back; no mesh size enters. Then the
// continuum that it tends to. Frozen rotations R give R C:(U - 1), F = R U, for the first Piola-Kirchhoff stress, and
// that is the whole derivative of the corotated energy ½ (U - 1):C:(U - 1): what the change of R would add is the
// product of a symmetric and a skew matrix. So against this energy the error vanishes with the cell size, however large
// the strain. Against St. Venant and Kirchhoff's energy, whose stress is R (U C:(V + ½ V²)), V = U - 1, a difference
// V C:V + ½ C:V² of second order in the strain stays for ever.

namespace finegauge {

/// Positions x = φ(X) of a motion, as a formula in jets.
struct Motion {
  std::string name;
  FieldFormula positions;

  FieldFormula displacement() const;                         ///< φ - X
  Eigen::Matrix3d gradient(const Eigen::Vector3d& X) const;  ///< F
};
/// X + strain × `field`, turned by `angle` about an oblique axis.
Motion turned_motion(double angle, double strain, const ManufacturedSolution& field);
/// A bar along x, its axis at y = z = 0: strained by a field that varies over the thickness, of `strain`'s size, then
/// twisted about its axis by `twist` and bent into an arc by `bend` [rad] over a length of one. Bending strains are up
/// to bend × thickness / 2.
Motion bar_motion(double bend, double twist, double thickness, double strain);

enum class HyperelasticLaw { corotated, saint_venant_kirchhoff };
/// Energy of a deformation gradient [J/m³] and its derivative P, the first Piola-Kirchhoff stress [Pa].
double stored_energy(HyperelasticLaw law, const Material& material, const Eigen::Matrix3d& F);
Eigen::Matrix3d piola_stress(HyperelasticLaw law, const Material& material, const Eigen::Matrix3d& F);
/// -div P of a motion [N/m³], by automatic differentiation, the rotation's change included.
Eigen::Vector3d hyperelastic_body_force(const Motion& motion, HyperelasticLaw law, const Material& material,
                                        const Eigen::Vector3d& X);

/// A displacement, chosen beforehand and recovered from its own internal forces.
struct RecoveredRow {
  std::string name;
  int dofs = 0, hanging_nodes = 0;
  double largest_turn = 0.0;          ///< of a cell [rad]
  double largest_strain = 0.0;        ///< of a cell's centre, of the symmetric part of Rᵀ F - 1
  double start_distance = 0.0;        ///< ‖u_start - u‖ / ‖u‖
  std::vector<int> iterations;        ///< to residuals of 1e-4, 1e-8 and 1e-12; -1: not reached
  double distance = 0.0;              ///< ‖u_h - u‖ / ‖u‖ after the last
  double frozen_tangent_error = 0.0;  ///< of K against differences of the force with the rotations held, relative
  double turning_share = 0.0;         ///< the same with the rotations free to follow
};
std::vector<RecoveredRow> recovered_displacements();

/// The turning share of a turned cube whose strain is halved row by row.
struct TurningShareRow {
  double strain = 0.0;
  double share = 0.0;
};
std::vector<TurningShareRow> turning_shares();

/// One grid of a motion whose boundary is prescribed all around and whose body force is that of a law.
struct HyperelasticRow {
  int cells_across = 0;
  int dofs = 0, hanging_nodes = 0, iterations = 0;
  double h = 0.0;                   ///< cell size before refinement [m]
  double displacement_error = 0.0;  ///< sqrt ∫ |u_h - u|² [m^2.5]
  double gradient_error = 0.0;      ///< sqrt ∫ |∇(u_h - u)|² [m^1.5]
  double displacement_over_best = 0.0;
};
struct HyperelasticTable {
  std::string name;
  std::vector<HyperelasticRow> rows;  ///< coarsest first

  ErrorSeries displacement() const, gradient() const;
};

/// The unit cube turned by 2 rad, strained by a smooth field of the given root mean square.
HyperelasticTable turned_cube_table(const std::string& name, const CubeMesh& mesh, const Material& material,
                                    HyperelasticLaw law, double strain, const std::vector<int>& grids);
/// The L2 error of linear elasticity on the same grid at rest, for the same field.
double cube_error_at_rest(const CubeMesh& mesh, Material material, double strain, int n);
/// A bar of an eighth of its length, bent by 180° and twisted by 90°.
HyperelasticTable bent_bar_table(const std::string& name, HyperelasticLaw law, const std::vector<int>& across);

/// How far apart the solutions under the body forces of the two laws are, on one mesh.
struct LawDifferenceRow {
  double strain = 0.0;      ///< root of the mean square over the cube; of a bar bend × thickness / 2
  double difference = 0.0;  ///< root of the mean square of |u_S - u_C|, over the body's thickness
  double predicted = 0.0;   ///< by linear elasticity at rest, under the difference of the forces turned back
};
/// Of the turned cube in 6 cells along an edge.
std::vector<LawDifferenceRow> cube_law_differences(const std::vector<double>& strains);
/// Of bars that are bent and twisted alike, 4 cells across; the strain goes with the thickness. No prediction.
std::vector<LawDifferenceRow> bar_law_differences(const std::vector<double>& thicknesses);

Evidence manufactured_corotational_evidence(const EvidenceOptions& options);

}  // namespace finegauge
