#include "verification/support/needle_in_box.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

#include "core/space/assembly.hpp"

namespace finegauge {

namespace {

constexpr double box_cell_size = 0.01;  // [m]
constexpr double tissue_density = 1e3;  // [kg/m³]
constexpr double needle_density = 7.8e3;
constexpr double radius = 1e-3;  // [m]

/// Turns about z, by an angle that grows with x: cells near x_max turn by `angle`.
Eigen::Matrix3Xd bent(const Mesh& mesh, double length, double angle) {
  Eigen::Matrix3Xd u(3, mesh.node_count());
  for (int i = 0; i < mesh.node_count(); ++i) {
    const Eigen::Vector3d X = mesh.nodes.col(i);
    const double turn = angle * X.x() / length;
    u.col(i) = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()) * X - X;
  }
  return u;
}

/// The masters of the point's cell, with their weights. Cells are bricks along the axes.
ReducedWeights weights_at(const Discretization& d, const Eigen::Vector3d& X) {
  for (const auto& cell : d.mesh.cells) {
    const Eigen::Vector3d lower = d.mesh.nodes.col(cell[0]), upper = d.mesh.nodes.col(cell[7]);
    const Eigen::Vector3d xi = (X - lower).cwiseQuotient(upper - lower);
    if (xi.minCoeff() < 0.0 || xi.maxCoeff() > 1.0) continue;
    const auto N = shape_functions(CellShape::hexahedron, xi);
    std::map<int, double> sum;
    for (int c = 0; c < 8; ++c)
      for (int k = d.hanging.row_start[cell[c]]; k < d.hanging.row_start[cell[c] + 1]; ++k)
        sum[d.hanging.master[k]] += N[c] * d.hanging.weight[k];
    ReducedWeights weights;
    for (const auto& [node, weight] : sum) {
      weights.node.push_back(node);
      weights.weight.push_back(weight);
    }
    return weights;
  }
  throw std::runtime_error("needle_in_box: a point lies outside of the box");
}

using Element = Eigen::Matrix<double, 12, 12>;

/// Global axes from the element's: four times Q on the diagonal.
Element turned(const Eigen::Matrix3d& Q) {
  Element R = Element::Zero();
  for (int k = 0; k < 4; ++k) R.block<3, 3>(3 * k, 3 * k) = Q;
  return R;
}

/// Stiffness of a straight round beam, Euler and Bernoulli, in its own axes.
Element beam_stiffness(double E, double length) {
  const double area = std::numbers::pi * radius * radius, I = area * radius * radius / 4.0;
  const double G = E / 2.6, L = length;
  Element K = Element::Zero();
  const auto couple = [&](int i, int j, double value) {
    K(i, j) += value;
    if (i != j) K(j, i) += value;
  };
  for (const auto& [at, stiffness] : {std::pair{0, E * area / L}, std::pair{3, G * 2.0 * I / L}}) {
    couple(at, at, stiffness);
    couple(at + 6, at + 6, stiffness);
    couple(at, at + 6, -stiffness);
  }
  const double k = E * I / (L * L * L);
  for (const auto& [w, turn, sign] : {std::tuple{1, 5, 1.0}, std::tuple{2, 4, -1.0}}) {
    couple(w, w, 12.0 * k);
    couple(w + 6, w + 6, 12.0 * k);
    couple(w, w + 6, -12.0 * k);
    couple(w, turn, sign * 6.0 * k * L);
    couple(w, turn + 6, sign * 6.0 * k * L);
    couple(w + 6, turn, -sign * 6.0 * k * L);
    couple(w + 6, turn + 6, -sign * 6.0 * k * L);
    couple(turn, turn, 4.0 * k * L * L);
    couple(turn + 6, turn + 6, 4.0 * k * L * L);
    couple(turn, turn + 6, 2.0 * k * L * L);
  }
  return K;
}

/// The cubic between two nodes at a share of the length, in the element's axes.
Eigen::Matrix<double, 3, 12> cubic(double s, double L) {
  const double h_1 = 1.0 - 3.0 * s * s + 2.0 * s * s * s, h_2 = L * s * (1.0 - s) * (1.0 - s);
  const double h_3 = 1.0 - h_1, h_4 = -L * s * s * (1.0 - s);
  Eigen::Matrix<double, 3, 12> N = Eigen::Matrix<double, 3, 12>::Zero();
  N(0, 0) = 1.0 - s;
  N(0, 6) = s;
  N(1, 1) = N(2, 2) = h_1;
  N(1, 7) = N(2, 8) = h_3;
  N(1, 5) = h_2;
  N(1, 11) = h_4;
  N(2, 4) = -h_2;
  N(2, 10) = -h_4;
  return N;
}

void add_element(const Element& K, int element, ChainMatrix& A) {
  A.diagonal[element] += K.topLeftCorner<6, 6>();
  A.diagonal[element + 1] += K.bottomRightCorner<6, 6>();
  A.upper[element] += K.topRightCorner<6, 6>();
}

void make_tissue(const NeedleInBoxOptions& options, NeedleInBox& box) {
  BoxMeshOptions mesh;
  mesh.cells = options.cells;
  for (int k = 0; k < 3; ++k) mesh.size[k] = box_cell_size * options.cells[k];
  RefinementForest forest(box_mesh(mesh));
  if (options.refine)  // the column of cells around the axis, but for the one at the clamp
    for (int i = 1; i < options.cells[0]; ++i)
      forest.refine(i + options.cells[0] * (options.cells[1] / 2 + options.cells[1] * (options.cells[2] / 2)), {});
  Material material;
  material.youngs_modulus = options.tissue_modulus;
  material.poisson_ratio = 0.4;
  material.kinematics = Kinematics::corotational;
  box.d = std::make_shared<const Discretization>(
      discretize(forest, material, {{"x_min", {}, {}, {}}, {"z_max", Eigen::Vector3d(1.0, 2.0, 2.0), {}, {}}}));
  box.A = assemble_stiffness(*box.d, bent(box.d->mesh, mesh.size.x(), options.bend));
  const double tau = options.tau, mass = tissue_density * mesh.size.prod() / box.d->hanging.reduced_count();
  for (double& value : box.A.values) value *= tau * tau;
  for (const int at : box.d->pattern.diagonal) box.A.block(at) += mass * Eigen::Matrix3d::Identity();
  apply_supports(box.d->supports, box.A);
  box.b.resize(box.d->dof_count());
  for (int i = 0; i < box.d->hanging.reduced_count(); ++i)
    box.b.segment<3>(3 * i) = tau * mass * Eigen::Vector3d(0.3, -9.8, 1.0);
  project(box.d->supports, box.b);
  box.velocity = Eigen::VectorXd::Zero(box.d->dof_count());
}

}  // namespace

InteractionSystem NeedleInBox::system() const {
  return {A, b, d->supports, velocity, needle_A, needle_b, held, needle_velocity, points, tau, reference_speed};
}

NeedleInBox needle_in_box(const NeedleInBoxOptions& options) {
  NeedleInBox box;
  box.tau = options.tau;
  make_tissue(options, box);
  const Eigen::Vector3d size = box_cell_size * Eigen::Vector3d(options.cells[0], options.cells[1], options.cells[2]);

  // Oblique to the cells, so that the rows of points in one cell are independent.
  const Eigen::Vector3d n = Eigen::Vector3d(-1.0, 0.11, 0.07).normalized();
  const Eigen::Vector3d tip = size.cwiseProduct(Eigen::Vector3d(0.3, 0.56, 0.53));
  const double inside = (size.x() - tip.x()) / -n.x(), length = 1.5 * inside;
  Eigen::Matrix3d frame;
  frame.col(0) = n;
  frame.col(1) = n.cross(Eigen::Vector3d::UnitZ()).normalized();
  frame.col(2) = n.cross(frame.col(1));

  const int elements = options.elements, nodes = elements + 1;
  const double L = length / elements, tau = options.tau;
  const Eigen::Vector3d velocity =
      options.advance * n + options.sideways[0] * frame.col(1) + options.sideways[1] * frame.col(2);
  box.needle_A.diagonal.assign(nodes, Eigen::Matrix<double, 6, 6>::Zero());
  box.needle_A.upper.assign(elements, Eigen::Matrix<double, 6, 6>::Zero());
  const Element R = turned(frame);
  const Element K = tau * tau * R * beam_stiffness(options.needle_modulus, L) * R.transpose();
  const double mass = needle_density * std::numbers::pi * radius * radius * L / 2.0;
  for (int e = 0; e < elements; ++e) {
    add_element(K, e, box.needle_A);
    for (const int node : {e, e + 1})
      for (int k = 0; k < 6; ++k) box.needle_A.diagonal[node](k, k) += k < 3 ? mass : mass * L * L / 12.0;
  }
  box.needle_b = Eigen::VectorXd::Zero(6 * nodes);
  box.needle_b.segment<3>(6 * elements) = 1e-5 * tau / 0.01 * (frame.col(1) - 0.5 * frame.col(2));
  box.needle_velocity = Eigen::VectorXd::Zero(6 * nodes);
  for (int i = 0; i < nodes; ++i) box.needle_velocity.segment<3>(6 * i) = velocity;
  box.held.assign(nodes, 0u);
  if (options.base_held) box.held[0] = 63u;
  hold(box.held, box.needle_A);
  hold(box.held, box.needle_b);
  box.reference_speed = velocity.norm() + 1e-3;

  const double turn = 0.6;  // rows across the needle need not follow the beam's axes
  Eigen::Matrix3d contact_frame = frame;
  contact_frame.col(1) = std::cos(turn) * frame.col(1) + std::sin(turn) * frame.col(2);
  contact_frame.col(2) = std::cos(turn) * frame.col(2) - std::sin(turn) * frame.col(1);
  for (int p = 0; p < options.points; ++p) {
    const double from_base = length - inside + inside * (p + 1.0) / options.points * 0.999;
    ContactRows point;
    point.element = std::min(static_cast<int>(from_base / L), elements - 1);
    point.tissue = weights_at(*box.d, tip - (length - from_base) * n);
    point.needle = frame * cubic(from_base / L - point.element, L) * R.transpose();
    point.frame = contact_frame;
    point.axial = options.axial;
    point.lateral = options.lateral;
    point.gap = 1e-5 * Eigen::Vector3d(std::sin(p + 1.0), std::cos(2.0 * p), std::sin(3.0 * p + 0.5));
    point.friction_in = 0.5;
    point.friction_out = 0.3;
    point.clamp = 0.002 * (1.0 + 0.2 * p);
    point.surface_friction = 0.4;
    box.points.push_back(point);
  }
  return box;
}

void change_units(double mass, double length, double time, NeedleInBox& box) {
  const double impulse = mass * length / time, speed = length / time;
  Eigen::Matrix<double, 6, 1> unit, generalized;  // of a node's impulses and of its velocities
  unit << Eigen::Vector3d::Constant(impulse), Eigen::Vector3d::Constant(impulse * length);
  generalized << Eigen::Vector3d::Constant(speed), Eigen::Vector3d::Constant(1.0 / time);
  for (double& value : box.A.values) value *= mass;
  box.b *= impulse;
  box.velocity *= speed;
  for (auto* blocks : {&box.needle_A.diagonal, &box.needle_A.upper})
    for (auto& block : *blocks) block = (unit.asDiagonal() * block * generalized.cwiseInverse().asDiagonal()).eval();
  for (Eigen::Index i = 0; i < box.needle_b.size(); ++i) {
    box.needle_b[i] *= unit[i % 6];
    box.needle_velocity[i] *= generalized[i % 6];
  }
  for (ContactRows& point : box.points) {
    for (const int at : {3, 9}) point.needle.middleCols<3>(at) *= length;
    point.gap *= length;
    point.clamp *= impulse / time;
    point.lambda *= impulse;
  }
  box.tau *= time;
  box.reference_speed *= speed;
}

}  // namespace finegauge
