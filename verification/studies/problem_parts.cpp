#include "verification/studies/problem_parts.hpp"

#include "core/mesh/cell_shape.hpp"

namespace finegauge {

SupportCondition clamped(const std::string& surface) { return {surface, std::nullopt, {}}; }

SupportCondition moved(const std::string& surface, const Eigen::Vector3d& by) {
  return {surface, std::nullopt, [by](const Eigen::Vector3d&) { return by; }};
}

SupportCondition roller(const std::string& surface, int axis) {
  return {surface, Eigen::Vector3d(Eigen::Vector3d::Unit(axis)), {}};
}

SurfaceLoad traction(const std::string& surface, const Eigen::Vector3d& value) {
  return {surface, LoadKind::traction, value};
}

void hold_plane(StaticProblem& problem) {
  for (const char* surface : {"z_min", "z_max"}) problem.supports.push_back(roller(surface, 2));
}

void hold_exactly(const ExactField& exact, const std::vector<std::string>& surfaces, StaticProblem& problem) {
  for (const std::string& surface : surfaces) problem.supports.push_back({surface, std::nullopt, exact.displacement});
}

void name_surface(BaseMesh& mesh, const std::string& name, const std::function<bool(const Eigen::Vector3d&)>& holds) {
  for (const BaseFace& face : boundary_faces(mesh)) {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (const int corner : hexahedron_faces[face.face]) centre += 0.25 * mesh.nodes.col(mesh.cells[face.cell][corner]);
    if (holds(centre)) mesh.surfaces[name].push_back(face);
  }
}

BaseMesh block(const Eigen::Vector3d& size, std::array<int, 3> cells) {
  BoxMeshOptions options;
  options.size = size;
  options.cells = cells;
  return box_mesh(options);
}

BaseMesh block(const Eigen::Vector3d& size, std::array<int, 3> cells, const RemovedBlock& removed) {
  BoxMeshOptions options;
  options.size = size;
  options.cells = cells;
  options.removed = removed;
  return box_mesh(options);
}

BaseMesh notched_square(int n, int m, int layers) {
  BoxMeshOptions options;
  options.origin = {-1.0, -1.0, 0.0};
  options.size = {2.0, 2.0, 0.5};
  options.cells = {2 * n, 2 * m, layers};
  options.removed = RemovedBlock{{n, 0, 0}, {2 * n, m, layers}};
  return box_mesh(options);
}

Material with_poisson_ratio(double nu) {
  Material material;
  material.poisson_ratio = nu;
  return material;
}

ExactField combined(double a, const ExactField& u, double b, const ExactField& v) {
  ExactField sum{u.name + " and " + v.name, {}, {}, {}, u.singular_line ? u.singular_line : v.singular_line};
  sum.displacement = [=](const Eigen::Vector3d& X) -> Eigen::Vector3d {
    return a * u.displacement(X) + b * v.displacement(X);
  };
  sum.stress = [=](const Eigen::Vector3d& X) -> Voigt { return a * u.stress(X) + b * v.stress(X); };
  if (u.body && v.body)
    sum.body = [=](const Eigen::Vector3d& X) -> Eigen::Vector3d { return a * u.body(X) + b * v.body(X); };
  return sum;
}

}  // namespace finegauge
