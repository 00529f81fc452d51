#include "core/needle/beam_element.hpp"

#include <Eigen/Geometry>

#include "core/needle/rotation_vector.hpp"

namespace finegauge {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Row12 = Eigen::Matrix<double, 1, 12>;
using Rows3 = Eigen::Matrix<double, 3, 12>;

/// First dof of a node's displacement and rotation.
constexpr int u(int node) { return 6 * node; }
constexpr int theta(int node) { return 6 * node + 3; }

/// What the ends feel in the element's frame.
struct LocalForces {
  double N;                         ///< axial force, tension positive [N]
  std::array<Vector3d, 2> moments;  ///< conjugate to the rotation vectors Θ_i [N m]
  std::array<Vector3d, 2> mu;       ///< conjugate to the spins, T⁻ᵀ m_i [N m]
};
LocalForces local_forces(const LocalStiffness& D, const BeamConfiguration& c) {
  LocalForces f;
  f.N = D.axial * c.elongation;
  for (int i = 0; i < 2; ++i) {
    f.moments[i] = D.same_end.cwiseProduct(c.Theta[i]) + D.other_end.cwiseProduct(c.Theta[1 - i]);
    f.mu[i] = inverse_rotation_tangent(c.Theta[i]).transpose() * f.moments[i];
  }
  return f;
}

/// Coefficients of the frame's own spin: ω_1 = Σ_i (b_i θ_i1 - a_i θ_i2) / (b_1 + b_2) + ρ ω_2, where a_i and b_i are
/// the first two components of the nodes' second axes and ρ = (a_1 + a_2) / (b_1 + b_2).
struct SpinCoefficients {
  std::array<double, 2> by_twist, by_bend;
  double rho, sum;  ///< sum = b_1 + b_2
};
SpinCoefficients spin_coefficients(const BeamConfiguration& c) {
  SpinCoefficients g;
  g.sum = c.second_axes[0].y() + c.second_axes[1].y();
  for (int i = 0; i < 2; ++i) {
    g.by_twist[i] = c.second_axes[i].y() / g.sum;
    g.by_bend[i] = c.second_axes[i].x() / g.sum;
  }
  g.rho = g.by_bend[0] + g.by_bend[1];
  return g;
}

/// Forces on the ends in the element's frame: the virtual work of N and mu on the increments of l and of the local
/// spins.
Vector12 end_forces(const BeamConfiguration& c, const LocalForces& f) {
  const SpinCoefficients g = spin_coefficients(c);
  const Vector3d mu = f.mu[0] + f.mu[1];
  Vector12 force;
  force.segment<3>(u(1)) << f.N, -mu.z() / c.length, (mu.y() + g.rho * mu.x()) / c.length;
  force.segment<3>(u(0)) = -force.segment<3>(u(1));
  for (int i = 0; i < 2; ++i)
    force.segment<3>(theta(i)) = f.mu[i] - mu.x() * Vector3d(g.by_twist[i], -g.by_bend[i], 0.0);
  return force;
}

/// The spins of the local rotations by the dofs in the element's axes: that of the node minus that of the frame.
std::array<Rows3, 2> local_spins(const Rows3& omega) {
  std::array<Rows3, 2> P;
  for (int i = 0; i < 2; ++i) {
    P[i] = -omega;
    P[i].middleCols<3>(theta(i)) += Matrix3d::Identity();
  }
  return P;
}

/// Σ_ij P_iᵀ M_ij P_j + r rᵀ k with r the increment of the length. The P_i differ by a block of the identity alone, so
/// the 12 × 12 product is one 3 × 3 sandwich and copies.
Matrix12 congruence(const std::array<std::array<Matrix3d, 2>, 2>& M, const Rows3& omega, double axial) {
  const Matrix3d sum = M[0][0] + M[0][1] + M[1][0] + M[1][1];
  Matrix12 K;
  K.noalias() = omega.transpose() * (sum * omega);
  for (int i = 0; i < 2; ++i) {
    const Matrix3d row = M[i][0] + M[i][1], column = M[0][i] + M[1][i];
    K.middleRows<3>(theta(i)).noalias() -= row * omega;
    K.middleCols<3>(theta(i)).noalias() -= omega.transpose() * column;
  }
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j) K.block<3, 3>(theta(i), theta(j)) += M[i][j];
  K(u(0), u(0)) += axial;
  K(u(1), u(1)) += axial;
  K(u(0), u(1)) -= axial;
  K(u(1), u(0)) -= axial;
  return K;
}

/// From the element's axes to global ones.
Matrix12 turned(const Matrix12& K, const Matrix3d& R) {
  Matrix12 result;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) result.block<3, 3>(3 * i, 3 * j) = R * K.block<3, 3>(3 * i, 3 * j) * R.transpose();
  return result;
}

/// T_i⁻ᵀ D_ij T_j⁻¹.
std::array<std::array<Matrix3d, 2>, 2> bending_by_spins(const LocalStiffness& D, const BeamConfiguration& c) {
  const std::array<Matrix3d, 2> T = {inverse_rotation_tangent(c.Theta[0]), inverse_rotation_tangent(c.Theta[1])};
  std::array<std::array<Matrix3d, 2>, 2> M;
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j) M[i][j] = T[i].transpose() * (i == j ? D.same_end : D.other_end).asDiagonal() * T[j];
  return M;
}

}  // namespace

Eigen::Vector2d shear_ratios(const BeamSection& section, double rest_length) {
  const double twelve_by_square = 12.0 / (rest_length * rest_length);
  return {twelve_by_square * section.EI_2 / section.GA_3, twelve_by_square * section.EI_3 / section.GA_2};
}

LocalStiffness local_stiffness(const BeamSection& section, double rest_length) {
  const Eigen::Vector2d Phi = shear_ratios(section, rest_length);
  LocalStiffness D;
  D.axial = section.EA / rest_length;
  const double torsion = section.GJ / rest_length;
  const double b_2 = section.EI_2 / (rest_length * (1.0 + Phi[0]));
  const double b_3 = section.EI_3 / (rest_length * (1.0 + Phi[1]));
  D.same_end << torsion, b_2 * (4.0 + Phi[0]), b_3 * (4.0 + Phi[1]);
  D.other_end << -torsion, b_2 * (2.0 - Phi[0]), b_3 * (2.0 - Phi[1]);
  return D;
}

BeamConfiguration configuration(const BeamElement& element, const BeamNodes& nodes) {
  BeamConfiguration c;
  c.rest_length = element.rest_chord.norm();
  c.length = nodes.chord.norm();
  // As a product, so that a small elongation is not the difference of two lengths.
  c.elongation = (nodes.chord - element.rest_chord).dot(nodes.chord + element.rest_chord) / (c.length + c.rest_length);
  const std::array<Matrix3d, 2> ends = {*nodes.rotations[0] * element.rest_frame,
                                        *nodes.rotations[1] * element.rest_frame};
  c.frame.col(0) = nodes.chord / c.length;
  const Vector3d mean = ends[0].col(1) + ends[1].col(1);
  c.frame.col(2) = c.frame.col(0).cross(mean).normalized();
  c.frame.col(1) = c.frame.col(2).cross(c.frame.col(0));
  for (int i = 0; i < 2; ++i) {
    const Matrix3d local = c.frame.transpose() * ends[i];
    c.Theta[i] = rotation_vector(local);
    c.second_axes[i] = local.col(1);
  }
  return c;
}

double beam_energy(const BeamElement& element, const BeamNodes& nodes) {
  const BeamConfiguration c = configuration(element, nodes);
  const LocalStiffness D = local_stiffness(element.section, c.rest_length);
  double energy = 0.5 * D.axial * c.elongation * c.elongation;
  energy += c.Theta[0].dot(D.other_end.cwiseProduct(c.Theta[1]));
  for (int i = 0; i < 2; ++i) energy += 0.5 * c.Theta[i].dot(D.same_end.cwiseProduct(c.Theta[i]));
  return energy;
}

Vector12 beam_forces(const BeamElement& element, const BeamNodes& nodes) {
  const BeamConfiguration c = configuration(element, nodes);
  const Vector12 local = end_forces(c, local_forces(local_stiffness(element.section, c.rest_length), c));
  Vector12 force;
  for (int i = 0; i < 4; ++i) force.segment<3>(3 * i) = c.frame * local.segment<3>(3 * i);
  return force;
}

Rows3 frame_spin(const BeamConfiguration& c) {
  const SpinCoefficients g = spin_coefficients(c);
  Rows3 omega = Rows3::Zero();
  for (int i = 0; i < 2; ++i) {
    const double side = (i == 0 ? -1.0 : 1.0) / c.length;
    omega(2, u(i) + 1) = side;
    omega(1, u(i) + 2) = -side;
    omega(0, u(i) + 2) = -g.rho * side;
    omega(0, theta(i)) = g.by_twist[i];
    omega(0, theta(i) + 1) = -g.by_bend[i];
  }
  return omega;
}

Matrix12 beam_material_stiffness(const BeamElement& element, const BeamNodes& nodes) {
  const BeamConfiguration c = configuration(element, nodes);
  const LocalStiffness D = local_stiffness(element.section, c.rest_length);
  return turned(congruence(bending_by_spins(D, c), frame_spin(c), D.axial), c.frame);
}

Matrix12 beam_tangent_stiffness(const BeamElement& element, const BeamNodes& nodes) {
  const BeamConfiguration c = configuration(element, nodes);
  const LocalStiffness D = local_stiffness(element.section, c.rest_length);
  const LocalForces f = local_forces(D, c);
  const Rows3 omega = frame_spin(c);

  // Material part, and the change of T⁻ᵀ under the moments.
  auto M = bending_by_spins(D, c);
  for (int i = 0; i < 2; ++i)
    M[i][i] += derivative_of_transposed_tangent(c.Theta[i], f.moments[i]) * inverse_rotation_tangent(c.Theta[i]);
  Matrix12 K = congruence(M, omega, D.axial);

  // The forces turn with the frame.
  const Vector12 local = end_forces(c, f);
  for (int block = 0; block < 4; ++block)
    K.middleRows<3>(3 * block) -= cross_matrix(local.segment<3>(3 * block)) * omega;

  // The lever arm: transverse forces are moments over l, δl = u_21 - u_11.
  for (int axis = 1; axis < 3; ++axis) {
    const double change = local[u(1) + axis] / c.length;
    K(u(1) + axis, u(1)) -= change;
    K(u(1) + axis, u(0)) += change;
    K(u(0) + axis, u(1)) += change;
    K(u(0) + axis, u(0)) -= change;
  }

  // The coefficients of ω_1 change as the nodes' second axes turn: δ(a, b, c) = δϑ × (a, b, c).
  const SpinCoefficients g = spin_coefficients(c);
  const std::array<Rows3, 2> P = local_spins(omega);
  std::array<Row12, 2> a, b;
  for (int i = 0; i < 2; ++i) {
    const Vector3d& q = c.second_axes[i];
    a[i] = q.z() * P[i].row(1) - q.y() * P[i].row(2);
    b[i] = q.x() * P[i].row(2) - q.z() * P[i].row(0);
  }
  const Row12 sum = b[0] + b[1];
  const double torque = (f.mu[0].x() + f.mu[1].x()) / g.sum;
  for (int i = 0; i < 2; ++i) {
    K.row(theta(i)) -= torque * (b[i] - g.by_twist[i] * sum);
    K.row(theta(i) + 1) += torque * (a[i] - g.by_bend[i] * sum);
  }
  const Row12 rho = torque / c.length * (a[0] + a[1] - g.rho * sum);
  K.row(u(0) + 2) -= rho;
  K.row(u(1) + 2) += rho;
  return turned(K, c.frame);
}

}  // namespace finegauge
