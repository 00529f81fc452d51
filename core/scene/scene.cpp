#include "core/scene/scene.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "core/scene/attachments.hpp"

namespace finegauge {
namespace {

// Faces of the bounding box are flat to rounding in every sensible file; nine digits is what text files often carry.
constexpr double bounding_plane_tolerance = 1e-8;

bool face_lies_in(const BaseMesh& mesh, BaseFace face, const std::vector<std::uint8_t>& chosen) {
  const auto& corners = face_corners(mesh.shape, face.face);
  return std::all_of(corners.begin(), corners.begin() + face_corner_count(mesh.shape),
                     [&](int corner) { return chosen[mesh.cells[face.cell][corner]] != 0; });
}

SurfaceDefinition bounding_plane(const BaseMesh& mesh, int axis, bool upper) {
  SurfaceDefinition plane;
  plane.name = std::string(1, static_cast<char>('x' + axis)) + (upper ? "_max" : "_min");
  plane.normal = Eigen::Vector3d::Unit(axis);
  if (upper)
    plane.point = mesh.nodes.rowwise().maxCoeff();
  else
    plane.point = mesh.nodes.rowwise().minCoeff();
  plane.tolerance = bounding_plane_tolerance;
  return plane;
}

/// Empty where there is none: a support without a motion costs nothing in time.
std::function<double(double)> course_function(const std::optional<Course>& course) {
  if (!course) return {};
  return [known = *course](double time) { return course_factor(known, time); };
}

/// Empty where it is zero.
std::function<Eigen::Vector3d(const Eigen::Vector3d&)> constant_field(const Eigen::Vector3d& value) {
  if (value.isZero(0.0)) return {};
  return [value](const Eigen::Vector3d&) { return value; };
}

}  // namespace

std::vector<BaseFace> select_faces(const BaseMesh& mesh, const SurfaceDefinition& definition) {
  std::vector<std::uint8_t> chosen(static_cast<std::size_t>(mesh.nodes.cols()), 0);
  if (definition.normal.isZero(0.0)) {
    for (const int node : definition.nodes) chosen[node] = 1;
  } else {
    const Eigen::Vector3d normal = definition.normal.stableNormalized();
    const double diagonal = (mesh.nodes.rowwise().maxCoeff() - mesh.nodes.rowwise().minCoeff()).norm();
    for (Eigen::Index i = 0; i < mesh.nodes.cols(); ++i)
      chosen[i] = std::abs(normal.dot(mesh.nodes.col(i) - definition.point)) <= definition.tolerance * diagonal;
  }
  std::vector<BaseFace> faces;
  for (const BaseFace face : boundary_faces(mesh))
    if (face_lies_in(mesh, face, chosen)) faces.push_back(face);
  return faces;
}

BaseMesh base_mesh(const Scene& scene) {
  BaseMesh mesh;
  if (const auto* box = std::get_if<BoxMeshOptions>(&scene.geometry))
    mesh = box_mesh(*box);
  else
    mesh = std::get<BaseMesh>(scene.geometry);
  add_regions(scene.attachments, mesh);
  if (mesh.body) return mesh;

  for (int axis = 0; axis < 3; ++axis)
    for (const bool upper : {false, true}) {
      const SurfaceDefinition plane = bounding_plane(mesh, axis, upper);
      if (mesh.surfaces.contains(plane.name)) continue;
      std::vector<BaseFace> faces = select_faces(mesh, plane);
      if (!faces.empty()) mesh.surfaces.emplace(plane.name, std::move(faces));
    }
  if (!mesh.surfaces.contains("boundary")) mesh.surfaces.emplace("boundary", boundary_faces(mesh));
  for (const SurfaceDefinition& definition : scene.surfaces)
    mesh.surfaces[definition.name] = select_faces(mesh, definition);
  return mesh;
}

std::vector<SupportCondition> support_conditions(const Scene& scene) {
  std::vector<SupportCondition> conditions;
  for (const SceneSupport& support : scene.supports) {
    SupportCondition condition;
    condition.surface = support.surface;
    condition.normal = support.normal;
    if (!support.displacement.isZero(0.0) || !support.gradient.isZero(0.0))
      condition.displacement = [a = support.displacement, G = support.gradient](const Eigen::Vector3d& X) {
        return Eigen::Vector3d(a + G * X);
      };
    condition.course = course_function(support.course);
    if (support.components.empty()) conditions.push_back(condition);
    for (const int axis : support.components) {
      condition.normal = Eigen::Vector3d::Unit(axis);
      conditions.push_back(condition);
    }
  }
  for (const SceneAttachment& attachment : scene.attachments) {
    if (held_by_springs(attachment)) continue;
    SupportCondition condition;
    condition.surface = attachment.name;
    condition.displacement = constant_field(attachment.displacement);
    condition.course = course_function(attachment.course);
    conditions.push_back(condition);
  }
  return conditions;
}

std::vector<SpringSupport> spring_supports(const Scene& scene) {
  std::vector<SpringSupport> springs;
  if (std::ranges::none_of(scene.attachments, held_by_springs)) return springs;
  const BaseMesh mesh = base_mesh(scene);
  for (const SceneAttachment& attachment : scene.attachments) {
    if (!held_by_springs(attachment)) continue;
    SpringSupport& support = springs.emplace_back();
    support.name = attachment.name;
    for (const SurfacePoint& point : spring_places(mesh, attachment))
      support.points.push_back({point.at, attachment.stiffness * point.area});
    support.displacement = constant_field(attachment.displacement);
    support.course = course_function(attachment.course);
  }
  return springs;
}

BodyForce body_force(const Scene& scene) {
  if (scene.body_force.isZero(0.0)) return {};
  return [force = scene.body_force](const Eigen::Vector3d&) { return force; };
}

}  // namespace finegauge
