#pragma once

#include <Eigen/Core>
#include <array>

#include "core/needle/beam_section.hpp"

namespace finegauge {

/// Corotational beam element of two nodes. A frame R_e follows the element: e_1 along the chord, e_2 in the plane of
/// the chord and the mean of the nodes' second axes (Crisfield 1990; Battini & Pacoste 2002). In it the element is
/// linear: the energy is quadratic in the elongation and in the two local rotation vectors Θ_i = log(R_eᵀ R_i R_e0).
/// Forces and tangent are the exact first and second derivatives of that energy. Nothing but the present configuration
/// enters, and only local rotations pass through a logarithm, so the total ones are free. Limits: |Θ_i| < π, the nodes'
/// second axes not opposite, the chord's length not zero; small strains. Order of the 12 dofs: u_1, θ_1, u_2, θ_2;
/// rotations turn from the left, δR_i = [δθ_i]× R_i.

using Vector12 = Eigen::Matrix<double, 12, 1>;
using Matrix12 = Eigen::Matrix<double, 12, 12>;

/// What an element is made of.
struct BeamElement {
  const BeamSection& section;
  Eigen::Vector3d rest_chord;         ///< X_2 - X_1 [m]
  const Eigen::Matrix3d& rest_frame;  ///< R_e0
};
/// Where its two nodes are.
struct BeamNodes {
  Eigen::Vector3d chord;                            ///< x_2 - x_1 [m]
  std::array<const Eigen::Matrix3d*, 2> rotations;  ///< R_i, identity at rest
};

/// Stiffness in the element's frame: interdependent interpolation, exact for end loads and free of shear locking at any
/// slenderness (Przemieniecki 1968). With Φ = 12 EI / (GA l_0²), a pair of end rotations has EI / (l_0 (1 + Φ)) times
/// [4 + Φ, 2 - Φ; 2 - Φ, 4 + Φ]. Vectors run over the axes 1, 2, 3; torsion comes first.
struct LocalStiffness {
  double axial;               ///< EA / l_0 [N/m]
  Eigen::Vector3d same_end;   ///< moment at an end by the rotation there [N m]
  Eigen::Vector3d other_end;  ///< by the rotation at the other end [N m]
};
LocalStiffness local_stiffness(const BeamSection& section, double rest_length);
/// Φ of bending about axes 2 and 3, i.e. with shear along axes 3 and 2.
Eigen::Vector2d shear_ratios(const BeamSection& section, double rest_length);

/// The element as seen from its own frame.
struct BeamConfiguration {
  Eigen::Matrix3d frame;                       ///< R_e
  double rest_length, length;                  ///< l_0, l [m]
  double elongation;                           ///< l - l_0 [m]
  std::array<Eigen::Vector3d, 2> Theta;        ///< local rotation vectors
  std::array<Eigen::Vector3d, 2> second_axes;  ///< of the nodes, R_eᵀ R_i R_e0 e_2
};
BeamConfiguration configuration(const BeamElement& element, const BeamNodes& nodes);

/// [J].
double beam_energy(const BeamElement& element, const BeamNodes& nodes);
/// Forces [N] and moments [N m] that the nodes exert on the element, in global axes.
Vector12 beam_forces(const BeamElement& element, const BeamNodes& nodes);
/// Bᵀ D B in global axes, symmetric and positive semidefinite: B = ∂(l, Θ_1, Θ_2) / ∂(dofs), D the local stiffness.
Matrix12 beam_material_stiffness(const BeamElement& element, const BeamNodes& nodes);
/// The exact derivative of beam_forces. Not symmetric: spins do not commute, and the skew part is half of [m_i]× in the
/// diagonal block of each node's rotation, m_i being the moment there (Simo 1992).
Matrix12 beam_tangent_stiffness(const BeamElement& element, const BeamNodes& nodes);

/// How the frame turns: δθ_e = spin of R_e in its own axes by the dofs in its own axes, 3 × 12.
Eigen::Matrix<double, 3, 12> frame_spin(const BeamConfiguration& c);

}  // namespace finegauge
