#include "core/space/loads.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace finegauge {

namespace {

/// Points and weights on [0, 1].
struct GaussRule {
  std::vector<double> points, weights;
};

GaussRule gauss_rule(int points) {
  if (points == 2) {
    const double offset = 0.5 / std::sqrt(3.0);
    return {{0.5 - offset, 0.5 + offset}, {0.5, 0.5}};
  }
  if (points == 3) {
    const double offset = 0.5 * std::sqrt(0.6);
    return {{0.5 - offset, 0.5, 0.5 + offset}, {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0}};
  }
  throw std::invalid_argument("body_points_per_axis is " + std::to_string(points) + ", but must be 2 or 3");
}

std::vector<BoundaryFace> leaf_faces(const BaseMesh& base, const Mesh& mesh, const std::string& surface) {
  const auto found = base.surfaces.find(surface);
  if (found == base.surfaces.end()) {
    std::string known;
    for (const auto& [name, faces] : base.surfaces) known += (known.empty() ? "" : ", ") + name;
    throw std::invalid_argument("load on surface '" + surface + "', but the mesh has " +
                                (known.empty() ? "no surfaces" : "only " + known));
  }
  std::vector<BoundaryFace> faces;
  for (const BoundaryFace& face : mesh.boundary)
    if (std::binary_search(found->second.begin(), found->second.end(), face.base)) faces.push_back(face);
  if (faces.empty()) throw std::invalid_argument("load on surface '" + surface + "', which has no faces");
  return faces;
}

/// ∫ N_c dA [m²] for the face's corners, in their order in cell_shape.hpp.
std::array<double, 4> face_shares(const Mesh& mesh, const BoundaryFace& face) {
  const auto& corners = face_corners(mesh.shape, face.face);
  std::array<Eigen::Vector3d, 4> X;
  for (int c = 0; c < face_corner_count(mesh.shape); ++c) X[c] = mesh.nodes.col(mesh.cells[face.cell][corners[c]]);
  std::array<double, 4> shares{};
  if (mesh.shape == CellShape::tetrahedron) {
    // The three-point rule and every other exact for linear functions agree here.
    const double area = 0.5 * (X[1] - X[0]).cross(X[2] - X[0]).norm();
    return {area / 3.0, area / 3.0, area / 3.0, 0.0};
  }
  static const GaussRule rule = gauss_rule(2);
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j) {
      const double s = rule.points[i], t = rule.points[j];
      const Eigen::Vector3d along_s = (1.0 - t) * (X[1] - X[0]) + t * (X[3] - X[2]);
      const Eigen::Vector3d along_t = (1.0 - s) * (X[2] - X[0]) + s * (X[3] - X[1]);
      const double dA = rule.weights[i] * rule.weights[j] * along_s.cross(along_t).norm();
      const std::array<double, 4> N = {(1.0 - s) * (1.0 - t), s * (1.0 - t), (1.0 - s) * t, s * t};
      for (int c = 0; c < 4; ++c) shares[c] += N[c] * dA;
    }
  return shares;
}

void add_total_by_node(const Mesh& mesh, const std::vector<BoundaryFace>& faces, const Eigen::Vector3d& total,
                       Eigen::Matrix3Xd& forces) {
  std::vector<int> nodes;
  for (const BoundaryFace& face : faces)
    for (int c = 0; c < face_corner_count(mesh.shape); ++c)
      nodes.push_back(mesh.cells[face.cell][face_corners(mesh.shape, face.face)[c]]);
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  const Eigen::Vector3d share = total / static_cast<double>(nodes.size());
  for (const int node : nodes) forces.col(node) += share;
}

void add_surface_load(const BaseMesh& base, const Mesh& mesh, const SurfaceLoad& load, Eigen::Matrix3Xd& forces) {
  if (!load.value.allFinite())
    throw std::invalid_argument("load on surface '" + load.surface + "': its value must be finite");
  const std::vector<BoundaryFace> faces = leaf_faces(base, mesh, load.surface);
  if (load.kind == LoadKind::total_by_node) {
    add_total_by_node(mesh, faces, load.value, forces);
    return;
  }
  Eigen::Vector3d traction = load.value;
  if (load.kind == LoadKind::total_by_area) {
    double area = 0.0;
    for (const BoundaryFace& face : faces)
      for (const double share : face_shares(mesh, face)) area += share;
    traction /= area;
  }
  for (const BoundaryFace& face : faces) {
    const std::array<double, 4> shares = face_shares(mesh, face);
    for (int c = 0; c < face_corner_count(mesh.shape); ++c)
      forces.col(mesh.cells[face.cell][face_corners(mesh.shape, face.face)[c]]) += shares[c] * traction;
  }
}

struct VolumePoint {
  std::array<double, max_corners> N;
  Eigen::Matrix<double, 3, max_corners> dN;
  double weight;  ///< of the reference cell
};

std::vector<VolumePoint> volume_points(CellShape shape, int points_per_axis) {
  const GaussRule rule = gauss_rule(points_per_axis);
  std::vector<VolumePoint> points;
  const auto add = [&](const Eigen::Vector3d& xi, double weight) {
    points.push_back({shape_functions(shape, xi), shape_gradients(shape, xi), weight});
  };
  if (shape == CellShape::tetrahedron) {
    // Exact for quadratics (Hammer & Stroud 1956).
    const double near = (5.0 + 3.0 * std::sqrt(5.0)) / 20.0, far = (5.0 - std::sqrt(5.0)) / 20.0;
    for (int corner = 0; corner < 4; ++corner) {
      Eigen::Vector3d xi = Eigen::Vector3d::Constant(far);
      if (corner > 0) xi[corner - 1] = near;
      add(xi, 1.0 / 24.0);
    }
    return points;
  }
  for (int k = 0; k < points_per_axis; ++k)
    for (int j = 0; j < points_per_axis; ++j)
      for (int i = 0; i < points_per_axis; ++i)
        add({rule.points[i], rule.points[j], rule.points[k]}, rule.weights[i] * rule.weights[j] * rule.weights[k]);
  return points;
}

void add_body_force(const Mesh& mesh, const BodyForce& body, int points_per_axis, Eigen::Matrix3Xd& forces) {
  const std::vector<VolumePoint> points = volume_points(mesh.shape, points_per_axis);
  const int count = corner_count(mesh.shape);
  for (int number = 0; number < mesh.cell_count(); ++number) {
    const auto& cell = mesh.cells[number];
    const double share = material_share(mesh, number);
    if (share == 0.0) continue;
    for (const VolumePoint& point : points) {
      Eigen::Matrix3d J = Eigen::Matrix3d::Zero();
      Eigen::Vector3d X = Eigen::Vector3d::Zero();
      for (int c = 0; c < count; ++c) {
        X += point.N[c] * mesh.nodes.col(cell[c]);
        J += (mesh.nodes.col(cell[c]) - mesh.nodes.col(cell[0])) * point.dN.col(c).transpose();
      }
      const double dV = share * point.weight * std::abs(J.col(0).dot(J.col(1).cross(J.col(2))));
      const Eigen::Vector3d force = dV * body(X);
      for (int c = 0; c < count; ++c) forces.col(cell[c]) += point.N[c] * force;
    }
  }
}

}  // namespace

Eigen::Matrix3Xd nodal_loads(const BaseMesh& base, const Mesh& mesh, const std::vector<SurfaceLoad>& loads,
                             const BodyForce& body, int body_points_per_axis) {
  Eigen::Matrix3Xd forces = Eigen::Matrix3Xd::Zero(3, mesh.node_count());
  for (const SurfaceLoad& load : loads) add_surface_load(base, mesh, load, forces);
  if (body) add_body_force(mesh, body, body_points_per_axis, forces);
  if (!forces.allFinite()) throw std::invalid_argument("body force: it must be finite everywhere in the body");
  return forces;
}

}  // namespace finegauge
