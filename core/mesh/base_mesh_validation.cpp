#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/mesh/base_mesh.hpp"
#include "core/mesh/position_text.hpp"

namespace finegauge {

namespace {

struct FaceRecord {
  std::array<int, 4> nodes;  ///< ascending
  BaseFace face;
  auto operator<=>(const FaceRecord&) const = default;  // NOLINT(modernize-use-nullptr): the compiler's own 0
};

/// All faces of all cells; those of one node set next to each other, ascending by cell.
std::vector<FaceRecord> sorted_faces(const BaseMesh& mesh) {
  std::vector<FaceRecord> records;
  records.reserve(mesh.cells.size() * face_count(mesh.shape));
  for (int cell = 0; cell < static_cast<int>(mesh.cells.size()); ++cell)
    for (int face = 0; face < face_count(mesh.shape); ++face) {
      FaceRecord record{{-1, -1, -1, -1}, {cell, face}};
      const auto& corners = face_corners(mesh.shape, face);
      for (int c = 0; c < face_corner_count(mesh.shape); ++c) record.nodes[c] = mesh.cells[cell][corners[c]];
      std::sort(record.nodes.begin(), record.nodes.end());
      records.push_back(record);
    }
  std::sort(records.begin(), records.end());
  return records;
}

std::string find_bad_cell_nodes(const BaseMesh& mesh, int cell) {
  const int count = corner_count(mesh.shape);
  const int n = static_cast<int>(mesh.nodes.cols());
  const auto& corners = mesh.cells[cell];
  for (int c = 0; c < count; ++c) {
    if (corners[c] < 0 || corners[c] >= n)
      return "cell " + std::to_string(cell) + ": corner " + std::to_string(c) + " is node " +
             std::to_string(corners[c]) + ", but the mesh has nodes 0 to " + std::to_string(n - 1);
    for (int other = 0; other < c; ++other)
      if (corners[other] == corners[c])
        return "cell " + std::to_string(cell) + ": corners " + std::to_string(other) + " and " + std::to_string(c) +
               " are both node " + std::to_string(corners[c]);
  }
  return {};
}

/// The Jacobian over the lengths of its columns: the volume of the tripod of unit edges, between -1 and 1. Free of the
/// cell's size and aspect ratio, so that round-off alone cannot make a flat cell look sound.
double relative_jacobian(const BaseMesh& mesh, int cell, const Eigen::Vector3d& xi) {
  const auto dN = shape_gradients(mesh.shape, xi);
  Eigen::Matrix3d J = Eigen::Matrix3d::Zero();
  const Eigen::Vector3d X0 = mesh.nodes.col(mesh.cells[cell][0]);
  double farthest = 0.0;
  for (int c = 0; c < corner_count(mesh.shape); ++c) {
    farthest = std::max(farthest, mesh.nodes.col(mesh.cells[cell][c]).cwiseAbs().maxCoeff());
    J += (mesh.nodes.col(mesh.cells[cell][c]) - X0) * dN.col(c).transpose();
  }
  for (int k = 0; k < 3; ++k) {
    const double length = J.col(k).norm();
    if (!(length > 1e-14 * farthest)) return 0.0;  // an edge without length has no direction but that of round-off
    J.col(k) /= length;
  }
  return J.col(0).dot(J.col(1).cross(J.col(2)));
}

/// At the quadrature points and not at the corners: the patch of MacNeal & Harder (1985) itself has a cell whose
/// Jacobian is negative at a corner, and integrals see the quadrature points only.
std::string find_bad_jacobian(const BaseMesh& mesh, int cell) {
  constexpr double flat = 1e-12;
  const int count = corner_count(mesh.shape);
  const double low = 0.5 - 0.5 / std::sqrt(3.0), high = 1.0 - low;
  for (int q = 0; q < (mesh.shape == CellShape::hexahedron ? 8 : 1); ++q) {
    Eigen::Vector3d xi((q & 1) ? high : low, (q & 2) ? high : low, (q & 4) ? high : low);
    if (mesh.shape == CellShape::tetrahedron) xi.setConstant(0.25);
    const double jacobian = relative_jacobian(mesh, cell, xi);
    if (jacobian > flat) continue;
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (int c = 0; c < count; ++c) centre += mesh.nodes.col(mesh.cells[cell][c]) / count;
    const std::string place = mesh.shape == CellShape::hexahedron ? " near corner " + std::to_string(q) + " (node " +
                                                                        std::to_string(mesh.cells[cell][q]) + ")"
                                                                  : std::string();
    return "cell " + std::to_string(cell) + " around " + describe(centre) +
           (jacobian < -flat ? " is inverted" : " is flat") + place +
           ": its Jacobian must be positive at the quadrature points";
  }
  return {};
}

std::string find_bad_surface(const BaseMesh& mesh, const std::vector<BaseFace>& boundary) {
  for (const auto& [name, faces] : mesh.surfaces)
    for (std::size_t i = 0; i < faces.size(); ++i) {
      const BaseFace& face = faces[i];
      const std::string subject =
          "surface '" + name + "': face " + std::to_string(face.face) + " of cell " + std::to_string(face.cell);
      if (face.cell < 0 || face.cell >= static_cast<int>(mesh.cells.size()) || face.face < 0 ||
          face.face >= face_count(mesh.shape))
        return subject + " does not exist";
      if (i > 0 && faces[i - 1] == face) return subject + " is listed twice";
      if (i > 0 && faces[i - 1] > face) return subject + " is out of order: faces must ascend by cell and face";
      if (!std::binary_search(boundary.begin(), boundary.end(), face))
        return subject + " is not on the boundary: another cell lies behind it";
    }
  return {};
}

std::string find_bad_region(const BaseMesh& mesh) {
  for (const auto& [name, nodes] : mesh.regions) {
    const std::string subject = "region '" + name + "'";
    if (mesh.surfaces.contains(name)) return subject + " has the name of a surface";
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (nodes[i] < 0 || nodes[i] >= mesh.nodes.cols())
        return subject + ": node " + std::to_string(nodes[i]) + " does not exist";
      if (i > 0 && nodes[i] <= nodes[i - 1])
        return subject + ": node " + std::to_string(nodes[i]) + " is out of order: nodes must ascend";
    }
  }
  return {};
}

std::vector<BaseFace> unshared(const std::vector<FaceRecord>& records) {
  std::vector<BaseFace> faces;
  for (std::size_t i = 0; i < records.size(); ++i) {
    const bool like_previous = i > 0 && records[i - 1].nodes == records[i].nodes;
    const bool like_next = i + 1 < records.size() && records[i + 1].nodes == records[i].nodes;
    if (!like_previous && !like_next) faces.push_back(records[i].face);
  }
  std::sort(faces.begin(), faces.end());
  return faces;
}

}  // namespace

std::vector<BaseFace> boundary_faces(const BaseMesh& mesh) { return unshared(sorted_faces(mesh)); }

std::string validate(const BaseMesh& mesh) {
  if (mesh.cells.empty()) return "the mesh has no cells";
  for (int node = 0; node < mesh.nodes.cols(); ++node)
    if (!mesh.nodes.col(node).allFinite())
      return "node " + std::to_string(node) + " is at " + describe(mesh.nodes.col(node)) +
             ": coordinates must be finite";
  std::vector<bool> used(mesh.nodes.cols(), false);
  for (int cell = 0; cell < static_cast<int>(mesh.cells.size()); ++cell) {
    if (std::string problem = find_bad_cell_nodes(mesh, cell); !problem.empty()) return problem;
    for (int c = 0; c < corner_count(mesh.shape); ++c) used[mesh.cells[cell][c]] = true;
  }
  for (int node = 0; node < mesh.nodes.cols(); ++node)
    if (!used[node]) return "node " + std::to_string(node) + " is not a corner of any cell";
  if (std::string problem = find_bad_region(mesh); !problem.empty()) return problem;
  for (int cell = 0; cell < static_cast<int>(mesh.cells.size()); ++cell)
    if (std::string problem = find_bad_jacobian(mesh, cell); !problem.empty()) return problem;

  const std::vector<FaceRecord> records = sorted_faces(mesh);
  for (std::size_t i = 2; i < records.size(); ++i)
    if (records[i - 2].nodes == records[i].nodes)
      return "cells " + std::to_string(records[i - 2].face.cell) + ", " + std::to_string(records[i - 1].face.cell) +
             " and " + std::to_string(records[i].face.cell) + " share one face: at most two cells may";
  return find_bad_surface(mesh, unshared(records));
}

}  // namespace finegauge
