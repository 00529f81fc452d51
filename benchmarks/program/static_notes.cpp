#include "benchmarks/program/static_notes.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <utility>

#include "core/elasticity/cell_response.hpp"

namespace finegauge {
namespace {

/// A rotation by this angle [rad] alone gives linear kinematics a strain of 1 - cos(angle) = 1.5 % where there is none.
constexpr double largest_linear_rotation = 10.0 * std::numbers::pi / 180.0;

bool nothing_acts(const Scene& scene, const Discretization& d) {
  const auto is_zero = [](const Eigen::Vector3d& v) { return v.isZero(0.0); };
  return std::ranges::all_of(scene.loads, is_zero, &SurfaceLoad::value) && is_zero(scene.body_force) &&
         std::ranges::all_of(d.supports.displacement, is_zero) &&
         std::ranges::all_of(d.springs.points, is_zero, &Springs::Point::displacement);
}

}  // namespace

double largest_cell_rotation(const Discretization& d, const Eigen::Matrix3Xd& u) {
  Material turning = d.shapes.material();
  turning.kinematics = Kinematics::corotational;
  CellGeometry scratch;
  double largest = 0.0;
  for (int cell = 0; cell < d.mesh.cell_count(); ++cell) {
    const CellVectors x = corner_values(d.mesh, cell, d.mesh.nodes) + corner_values(d.mesh, cell, u);
    const Eigen::Matrix3d R = cell_rotation(d.shapes.geometry(d.mesh, cell, scratch), turning, x);
    largest = std::max(largest, Eigen::AngleAxisd(R).angle());
  }
  return largest;
}

ThroughCells through_cells(const Mesh& mesh, const Eigen::Matrix3Xd& u) {
  ThroughCells found;
  if (mesh.shape != CellShape::hexahedron) return found;
  // Corner c has the bits of its place along x, y, z; so has each corner of a face, without the axis' bit.
  const auto face = [&](int cell, int axis, int side) {
    std::array<int, 4> nodes{};
    for (int c = 0, k = 0; c < 8; ++c)
      if ((c >> axis & 1) == side) nodes[static_cast<std::size_t>(k++)] = mesh.cells[static_cast<std::size_t>(cell)][c];
    return nodes;
  };
  std::map<std::array<int, 4>, int> cells_of;
  for (int cell = 0; cell < mesh.cell_count(); ++cell)
    for (int k = 0; k < 6; ++k) {
      std::array<int, 4> nodes = face(cell, k / 2, k % 2);
      std::ranges::sort(nodes);
      ++cells_of[nodes];
    }
  const auto on_boundary = [&](std::array<int, 4> nodes) {
    std::ranges::sort(nodes);
    return cells_of.at(nodes) == 1 && std::ranges::all_of(nodes, [&](int node) { return mesh.on_boundary[node] != 0; });
  };
  const auto stretch = [&](int from, int to) {
    const Eigen::Vector3d rest = mesh.nodes.col(to) - mesh.nodes.col(from);
    return (rest + u.col(to) - u.col(from)).norm() / rest.norm() - 1.0;
  };
  constexpr double round_off = 1e-12;  // of a stretch: nothing bends
  constexpr std::array<std::array<int, 2>, 4> edges = {{{0, 1}, {2, 3}, {0, 2}, {1, 3}}};
  for (int cell = 0; cell < mesh.cell_count(); ++cell)
    for (int axis = 0; axis < 3; ++axis) {
      const std::array<int, 4> low = face(cell, axis, 0), high = face(cell, axis, 1);
      if (material_share(mesh, cell) < 1.0 || !on_boundary(low) || !on_boundary(high)) continue;
      ++found.through;
      found.bent += std::ranges::any_of(edges, [&](const std::array<int, 2>& edge) {
        const auto from = static_cast<std::size_t>(edge[0]), to = static_cast<std::size_t>(edge[1]);
        const double one = stretch(low[from], low[to]), other = stretch(high[from], high[to]);
        return std::abs(one - other) > std::abs(one + other) + round_off;
      });
    }
  return found;
}

std::vector<std::string> cell_notes(const Scene& scene, const Mesh& mesh, const Eigen::Matrix3Xd& u) {
  constexpr double locks_from = 0.45;
  std::vector<std::string> notes;
  const double nu = scene.material.poisson_ratio;
  const bool tetrahedra = mesh.shape == CellShape::tetrahedron;
  if (nu >= locks_from && (tetrahedra || scene.material.dilatation == Dilatation::standard)) {
    char text[256];
    std::snprintf(text, sizeof text,
                  "cells lock as material.poisson_ratio nears 1/2: at %g displacements come out too small; %s", nu,
                  tetrahedra ? "hexahedra with material.dilatation = \"mean\" do not, tetrahedra do with either"
                             : "material.dilatation = \"mean\" does not");
    notes.emplace_back(text);
  }
  if (scene.material.dilatation == Dilatation::mean)
    if (const ThroughCells cells = through_cells(mesh, u); cells.bent > 0)
      notes.push_back(std::to_string(cells.bent) + " of " + std::to_string(mesh.cell_count()) +
                      " cells reach through the body from boundary to boundary and bend (their two faces there change "
                      "lengths more unlike than alike): with material.dilatation = \"mean\" one cell through the depth "
                      "bends up to 2.5 times too far; two or more do not");
  return notes;
}

std::vector<std::string> static_notes(const Scene& scene, const Discretization& d, const Eigen::Matrix3Xd& u) {
  std::vector<std::string> notes = scene.notes;
  if (nothing_acts(scene, d))
    notes.push_back("nothing acts on the body: the scene has no load, no body force and no prescribed displacement");
  else if (u.isZero(0.0))
    notes.push_back("the body does not move: what loads it cancels, or acts on nodes that supports hold");
  if (scene.material.kinematics == Kinematics::linear) {
    const double angle = largest_cell_rotation(d, u);
    if (angle > largest_linear_rotation) {
      char degrees[32];
      std::snprintf(degrees, sizeof degrees, "%.0f", angle * 180.0 / std::numbers::pi);
      notes.push_back(std::string("cells turn by up to ") + degrees +
                      " degrees, which linear kinematics takes for strain; material.kinematics = \"corotational\" does "
                      "not");
    }
  }
  for (std::string& note : cell_notes(scene, d.mesh, u)) notes.push_back(std::move(note));
  return notes;
}

}  // namespace finegauge
