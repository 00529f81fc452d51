#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>

#include "core/space/discretization.hpp"
#include "core/space/loads.hpp"
#include "verification/support/manufactured_solution.hpp"

namespace finegauge {

/// A solution of linear elasticity that is known: what an estimate of the error is measured against.
struct ExactField {
  std::string name;
  std::function<Eigen::Vector3d(const Eigen::Vector3d&)> displacement;  ///< [m]
  std::function<Voigt(const Eigen::Vector3d&)> stress;                  ///< [Pa]
  BodyForce body;                                                       ///< none: zero
  std::optional<Eigen::Vector2d> singular_line;  ///< (x, y) of a line along z on which the stress is unbounded
};

ExactField exact_field(const ManufacturedSolution& solution, const Material& material);

/// The leading term of the stress at a corner of a body in plane strain whose two faces there are free (Williams 1952),
/// in Kolosov's and Muskhelishvili's form: 2 mu (u_x + i u_y) = κ φ - z φ'̄ - ψ̄, φ = a z^λ, ψ = b z^λ, κ = 3 - 4 nu.
enum class CornerMode {
  opening,  ///< symmetric: sin 2αλ = -λ sin 2α, a real, b = -a (cos 2αλ + λ cos 2α)
  sliding   ///< antisymmetric: sin 2αλ = +λ sin 2α, a imaginary
};
/// The smallest root λ in (0, 1] of the mode's equation for an opening of the material of 2α [rad], in (π, 2π]. By
/// bisection; throws std::invalid_argument where there is none.
double corner_exponent(CornerMode mode, double opening);
/// The corner lies on the line through `at` along z, its bisector (into the material) at the angle `bisector` from x;
/// a = 1.
ExactField corner_field(CornerMode mode, double opening, const Eigen::Vector2d& at, double bisector,
                        const Material& material);

/// The same where the face at the angle `free_face` [rad from x] is free and the one at `clamped_face` is clamped; the
/// material lies between them. φ and ψ then have complex factors; λ is the smallest real root in (0.3, 1) of the four
/// conditions' determinant. Throws std::invalid_argument where there is none (flat angles have complex exponents).
ExactField clamped_corner_field(double free_face, double clamped_face, const Eigen::Vector2d& at,
                                const Material& material, double* exponent = nullptr);

/// Energy norm of the error in each cell [√J], and of the exact solution: Gauss-Legendre with `points_per_axis`³
/// points. Hexahedra that the singular line touches are split towards it; tetrahedra are cubes that are collapsed to
/// their edge or corner on it, with points that are dense there.
struct TrueError {
  Eigen::VectorXd cell;  ///< sqrt ∫ (σ_h - σ):C⁻¹:(σ_h - σ)
  double total = 0.0, energy_norm = 0.0;
  double recovered = 0.0;  ///< the same of the nodal stresses, interpolated
};
/// Linear kinematics; a tetrahedron touches the line in a corner or an edge or not at all.
TrueError true_error(const Discretization& d, const ExactField& exact, const Eigen::Matrix3Xd& u,
                     const Eigen::Matrix<double, 6, Eigen::Dynamic>& recovered, int points_per_axis = 4);

}  // namespace finegauge
