#include "core/scene/imported_mesh.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <sstream>
#include <tuple>
#include <vector>

#include "core/scene/number_limits.hpp"

namespace finegauge {
namespace {

// Below this share of the product of its edge lengths a volume is rounding, below that of its coordinates an edge is.
// Twice the limits of validate, whose sums round differently: what was read must not be unsound later.
constexpr double flat = 2e-12, shortest = 2e-14;

/// Jacobian determinant over the lengths of its columns, in [-1, 1]; NaN where a column is no edge: nothing beside
/// `farthest`, the largest coordinate, or out of the magnitudes allowed. `corners` are relative to the first.
double relative_jacobian(CellShape shape, const Eigen::Matrix<double, 3, max_corners>& corners, double farthest,
                         const Eigen::Vector3d& xi) {
  Eigen::Matrix3d J = corners * shape_gradients(shape, xi).transpose();
  for (int k = 0; k < 3; ++k) {
    const double length = J.col(k).norm();
    if (!(length > shortest * farthest && has_sound_magnitude(length))) return std::numeric_limits<double>::quiet_NaN();
    J.col(k) /= length;
  }
  return J.determinant();
}

/// A face as one of its cells sees it.
struct SeenFace {
  std::array<int, 4> nodes;  // ascending
  bool positive;             // which way round the cell sees them
  int cell;
  bool operator<(const SeenFace& other) const { return std::tie(nodes, cell) < std::tie(other.nodes, other.cell); }
};

SeenFace seen_face(const BaseMesh& mesh, int cell, int face) {
  const auto& corners = face_corners(mesh.shape, face);
  const auto node = [&](int k) { return mesh.cells[cell][corners[k]]; };
  std::vector<int> loop;
  bool outward;
  if (mesh.shape == CellShape::hexahedron) {
    loop = {node(0), node(1), node(3), node(2)};
    outward = face % 2 == 1;
  } else {
    loop = {node(0), node(1), node(2)};
    outward = face % 2 == 0;
  }
  std::rotate(loop.begin(), std::min_element(loop.begin(), loop.end()), loop.end());
  SeenFace seen{{-1, -1, -1, -1}, (loop[1] < loop.back()) == outward, cell};
  std::sort(loop.begin(), loop.end());
  std::copy(loop.begin(), loop.end(), seen.nodes.begin());
  return seen;
}

}  // namespace

std::array<int, max_corners> corners_from_file_order(CellShape shape, std::span<const int> listed) {
  std::array<int, max_corners> corners;
  corners.fill(-1);
  for (std::size_t k = 0; k < listed.size(); ++k)
    corners[shape == CellShape::hexahedron ? static_cast<std::size_t>(vtk_corner_order[k]) : k] = listed[k];
  return corners;
}

std::string cell_defect(CellShape shape, const Eigen::Matrix3Xd& nodes, const std::array<int, max_corners>& cell) {
  const int count = corner_count(shape);
  for (int a = 0; a < count; ++a)
    for (int b = 0; b < a; ++b)
      if (cell[a] == cell[b]) return "found the same corner twice, allowed " + std::to_string(count) + " distinct ones";

  Eigen::Matrix<double, 3, max_corners> corners = Eigen::Matrix<double, 3, max_corners>::Zero();
  double farthest = 0.0;
  for (int c = 0; c < count; ++c) {
    corners.col(c) = nodes.col(cell[c]) - nodes.col(cell[0]);
    farthest = std::max(farthest, nodes.col(cell[c]).cwiseAbs().maxCoeff());
  }
  const auto defect_at = [&](const Eigen::Vector3d& xi, const std::string& place) {
    const double jacobian = relative_jacobian(shape, corners, farthest, xi);
    if (jacobian > flat) return std::string();
    if (std::isnan(jacobian))
      return "found a flat cell, without edges " + place +
             ", allowed those that are longer than 2e-14 of the largest coordinate, and 1e-60 to 1e60";
    std::ostringstream words;
    words << "found " << (jacobian < -flat ? "an inverted" : "a flat") << " cell, Jacobian determinant " << jacobian
          << " of its edge lengths " << place << ", allowed > 0 (corners in the order of VTK and gmsh)";
    return words.str();
  };
  const Eigen::Vector3d centre = Eigen::Vector3d::Constant(shape == CellShape::hexahedron ? 0.5 : 0.25);
  std::string defect = defect_at(centre, "at the centre");
  for (int listed = 0; defect.empty() && shape == CellShape::hexahedron && listed < 8; ++listed) {
    const int c = vtk_corner_order[listed];
    const Eigen::Vector3d corner(c & 1, (c >> 1) & 1, (c >> 2) & 1);
    defect = defect_at(centre + (corner - centre) / std::numbers::sqrt3, "near corner " + std::to_string(listed));
  }
  return defect;
}

ConnectionDefect connection_defect(const BaseMesh& mesh) {
  std::vector<SeenFace> faces;
  for (int cell = 0; cell < static_cast<int>(mesh.cells.size()); ++cell)
    for (int face = 0; face < face_count(mesh.shape); ++face) faces.push_back(seen_face(mesh, cell, face));
  std::sort(faces.begin(), faces.end());
  for (std::size_t i = 1; i < faces.size(); ++i) {
    if (faces[i].nodes != faces[i - 1].nodes) continue;
    if (i >= 2 && faces[i].nodes == faces[i - 2].nodes)
      return {faces[i].cell, "found a face that two cells before it share, allowed two cells on a face"};
    if (faces[i].positive == faces[i - 1].positive)
      return {faces[i].cell, "found a cell on the same side of a face as a cell before it, allowed one on each side"};
  }
  return {};
}

int unused_node(const BaseMesh& mesh) {
  std::vector<std::uint8_t> used(static_cast<std::size_t>(mesh.nodes.cols()), 0);
  for (const auto& cell : mesh.cells)
    for (int c = 0; c < corner_count(mesh.shape); ++c) used[static_cast<std::size_t>(cell[c])] = 1;
  const auto found = std::find(used.begin(), used.end(), std::uint8_t{0});
  return found == used.end() ? -1 : static_cast<int>(found - used.begin());
}

}  // namespace finegauge
