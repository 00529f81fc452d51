#include "benchmarks/program/static_notes.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdio>
#include <numbers>

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

std::vector<std::string> static_notes(const Scene& scene, const Discretization& d, const Eigen::Matrix3Xd& u) {
  std::vector<std::string> notes = scene.notes;
  if (nothing_acts(scene, d))
    notes.push_back("nothing acts on the body: the scene has no load, no body force and no prescribed displacement");
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
  return notes;
}

}  // namespace finegauge
