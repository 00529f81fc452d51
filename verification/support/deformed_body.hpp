#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "core/mesh/hanging_nodes.hpp"
#include "core/mesh/point_location.hpp"
#include "core/space/discretization.hpp"
#include "verification/support/refinement_history.hpp"
#include "verification/support/sample_cells.hpp"
#include "verification/support/scrambled_mesh.hpp"

namespace finegauge {

/// A distorted, renumbered and randomly refined box of 3 × 2 × 2 base cells around the origin, bent and then turned by
/// 170 degrees. Conforming: nodes that hang follow their masters.
struct DeformedBody {
  RefinementForest forest;
  Mesh mesh;
  HangingNodes hanging;
  Eigen::Matrix3Xd u;  ///< [m], 3 × n_nodes

  Eigen::Matrix3Xd positions() const { return mesh.nodes + u; }  ///< current [m]
};

/// A conforming field that is not linear, of the size of one.
inline Eigen::Matrix3Xd smooth_field(const Mesh& mesh, const HangingNodes& hanging) {
  Eigen::Matrix3Xd field(3, mesh.node_count());
  for (int node = 0; node < mesh.node_count(); ++node) {
    const Eigen::Vector3d X = mesh.nodes.col(node);
    field.col(node) = Eigen::Vector3d(std::sin(2.0 * X.x() + X.y()), std::cos(X.y() - 2.0 * X.z()), X.x() * X.z());
  }
  return expand(hanging, gather(hanging, field));
}

/// Bent by `bend` [1/m], turned by `angle` about an axis that is none of the coordinates'.
inline Eigen::Matrix3Xd bent_and_turned(const Mesh& mesh, const HangingNodes& hanging, double bend, double angle) {
  const Eigen::Matrix3d R = Eigen::AngleAxisd(angle, Eigen::Vector3d(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
  Eigen::Matrix3Xd u(3, mesh.node_count());
  for (int node = 0; node < mesh.node_count(); ++node) {
    const Eigen::Vector3d X = mesh.nodes.col(node);
    const Eigen::Vector3d x(X.x() + bend * X.y() * X.z(), X.y() + bend * (X.x() * X.x() - 0.5 * X.z()),
                            1.3 * X.z() + bend * std::sin(2.0 * X.x()) * X.y());
    u.col(node) = R * x + Eigen::Vector3d(0.3, -2.0, 1.0) - X;
  }
  return expand(hanging, gather(hanging, u));
}

inline DeformedBody deformed_body(CellShape shape, int refinements, std::mt19937& generator, double bend = 0.25,
                                  double angle = 170.0 / 180.0 * std::numbers::pi) {
  BoxMeshOptions options;
  options.cells = {3, 2, 2};
  options.origin = {-0.75, -0.5, -0.5};
  options.size = {1.5, 1.0, 1.0};
  options.shape = shape;
  RefinementForest forest(
      scrambled(distorted_box(options, shape == CellShape::hexahedron ? 0.2 : 0.1, generator), generator));
  const auto templates = all_templates(shape);
  refine_randomly(forest, {templates, refinements, 3, 2000}, generator);
  Mesh mesh = forest.leaf_mesh();
  HangingNodes hanging = find_hanging_nodes(forest, mesh);
  Eigen::Matrix3Xd u = bent_and_turned(mesh, hanging, bend, angle);
  return {std::move(forest), std::move(mesh), std::move(hanging), std::move(u)};
}

/// A random point of a random leaf, two in three of them on a face, an edge or a corner of it.
inline LeafPoint random_leaf_point(const Mesh& mesh, std::mt19937& generator) {
  LeafPoint point{static_cast<int>(generator() % static_cast<unsigned>(mesh.cell_count())), Eigen::Vector3d::Zero()};
  const bool snapped = generator() % 3 != 0;
  if (mesh.shape == CellShape::hexahedron) {
    for (int axis = 0; axis < 3; ++axis) {
      const double inside = 0.5 + 0.5 * random_number(generator);
      const unsigned choice = generator() % 3;
      point.xi[axis] = snapped && choice < 2 ? choice : inside;
    }
    return point;
  }
  Eigen::Vector4d weights;
  for (int c = 0; c < 4; ++c) {
    const double inside = 0.501 + 0.5 * random_number(generator);
    weights[c] = snapped && generator() % 2 ? 0.0 : inside;
  }
  if (weights.sum() == 0.0) weights[generator() % 4] = 1.0;
  point.xi = weights.tail<3>() / weights.sum();
  return point;
}

/// Smallest determinant of the current map over all leaves' corners, relative to that of the rest map: > 0 where the
/// deformation inverts nothing.
inline double least_stretch(const Mesh& mesh, const Eigen::Matrix3Xd& u) {
  double least = 1e300;
  for (int cell = 0; cell < mesh.cell_count(); ++cell)
    for (int corner = 0; corner < corner_count(mesh.shape); ++corner) {
      Eigen::Vector3d xi = Eigen::Vector3d::Zero();
      for (int axis = 0; axis < 3; ++axis)
        if (mesh.shape == CellShape::hexahedron ? (corner >> axis) & 1 : corner == axis + 1) xi[axis] = 1.0;
      const auto dN = shape_gradients(mesh.shape, xi);
      const Eigen::Matrix3d rest = corner_values(mesh, cell, mesh.nodes) * dN.transpose();
      const Eigen::Matrix3d current = corner_values(mesh, cell, mesh.nodes + u) * dN.transpose();
      least = std::min(least, current.determinant() / rest.determinant());
    }
  return least;
}

}  // namespace finegauge
