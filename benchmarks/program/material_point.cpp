#include "benchmarks/program/material_point.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "core/elasticity/cell_geometry.hpp"

namespace finegauge {
namespace {

constexpr double slack = 1e-9;  // of a cell

bool inside(CellShape shape, const Eigen::Vector3d& xi) {
  if (!(xi.minCoeff() >= -slack)) return false;
  return shape == CellShape::hexahedron ? xi.maxCoeff() <= 1.0 + slack : xi.sum() <= 1.0 + slack;
}

/// Newton's method on the cell's map, which has one solution in a sound cell; exact after one step when it is affine.
std::optional<Eigen::Vector3d> natural_coordinates(CellShape shape, const CellVectors& corners,
                                                   const Eigen::Vector3d& x) {
  Eigen::Vector3d xi = Eigen::Vector3d::Constant(shape == CellShape::hexahedron ? 0.5 : 0.25);
  for (int iteration = 0; iteration < 30; ++iteration) {
    const std::array<double, max_corners> N = shape_functions(shape, xi);
    Eigen::Vector3d residual = x;
    for (int c = 0; c < corner_count(shape); ++c) residual -= N[c] * corners.col(c);
    const Eigen::Matrix3d jacobian = corners * shape_gradients(shape, xi).transpose();
    const Eigen::Vector3d step = jacobian.partialPivLu().solve(residual);
    if (!step.allFinite()) return std::nullopt;
    xi += step;
    if (step.lpNorm<Eigen::Infinity>() < 1e-13) break;
  }
  return xi;
}

}  // namespace

std::optional<MaterialPoint> locate(const Mesh& mesh, const Eigen::Vector3d& rest_position) {
  for (int e = 0; e < mesh.cell_count(); ++e) {
    const CellVectors corners = corner_values(mesh, e, mesh.nodes);
    const auto used = corners.leftCols(corner_count(mesh.shape));
    const Eigen::AlignedBox3d box(used.rowwise().minCoeff(), used.rowwise().maxCoeff());
    if (box.exteriorDistance(rest_position) > slack * box.diagonal().norm()) continue;
    const std::optional<Eigen::Vector3d> xi = natural_coordinates(mesh.shape, corners, rest_position);
    if (xi && inside(mesh.shape, *xi)) return MaterialPoint{e, *xi};
  }
  return std::nullopt;
}

Eigen::Vector3d interpolate(const Mesh& mesh, const MaterialPoint& point,
                            const Eigen::Ref<const Eigen::Matrix3Xd>& nodal) {
  const std::array<double, max_corners> N = shape_functions(mesh.shape, point.xi);
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  for (int c = 0; c < corner_count(mesh.shape); ++c) value += N[c] * nodal.col(mesh.cells[point.cell][c]);
  return value;
}

}  // namespace finegauge
