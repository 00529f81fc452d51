#include "core/mesh/face_patches.hpp"

#include <algorithm>
#include <map>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace finegauge {

namespace {

using Interval = std::array<std::uint64_t, 2>;

/// A leaf's face in the plane that it lies in.
struct PlaneFace {
  int cell, face;
  std::array<Interval, 2> extent;      ///< along the plane's coordinates
  std::array<int, 2> natural_axis;     ///< of the leaf, along the plane's coordinates
  std::array<bool, 2> natural_flip{};  ///< whether it runs against them
};

/// A plane inside a base cell, or a face of base cells; the two sides of it.
struct Plane {
  std::array<std::vector<PlaneFace>, 2> sides;
};
using PlaneKey = std::tuple<int, int, int, std::uint64_t>;  // 0, base cell, axis, coordinate; or 1, base face, 0, 0

struct Placed {
  PlaneKey key;
  int side;
  PlaneFace face;
};

Placed place(const BaseTopology& topology, const Mesh& mesh, int cell, int local_face) {
  const LeafFrame& frame = mesh.frames[cell];
  const int axis = local_face / 2;
  const bool upper = local_face % 2 == 1;
  const std::uint64_t unit = lattice_unit(mesh.shape);
  const std::uint64_t coordinate = frame.corners[0][axis] + (upper ? frame.corners[1][axis] : 0);
  Placed placed{{0, frame.base_cell, axis, coordinate}, upper ? 0 : 1, {cell, local_face, {}, {}, {}}};
  for (int k = 0; k < 2; ++k) {
    const int along = (axis + 1 + k) % 3;
    placed.face.natural_axis[k] = along;
    placed.face.extent[k] = {frame.corners[0][along], frame.corners[0][along] + frame.corners[1][along]};
  }
  if (coordinate != 0 && coordinate != unit) return placed;

  const BaseTopology::FaceView& view = topology.cell_faces[frame.base_cell][local_face];
  const BaseFace& first = topology.face_cells[view.face][0];
  placed.key = {1, view.face, 0, 0};
  placed.side = first.cell == frame.base_cell && first.face == local_face ? 0 : 1;
  if (view.swap) {
    std::swap(placed.face.extent[0], placed.face.extent[1]);
    std::swap(placed.face.natural_axis[0], placed.face.natural_axis[1]);
  }
  for (int k = 0; k < 2; ++k) {
    if (!view.flip[k]) continue;
    const Interval local = placed.face.extent[k];
    placed.face.extent[k] = {unit - local[1], unit - local[0]};
    placed.face.natural_flip[k] = true;
  }
  return placed;
}

/// The part of a leaf's face that lies in `extent`.
FacePatch::Side side_of(const PlaneFace& face, const std::array<Interval, 2>& extent) {
  FacePatch::Side side{face.cell, face.face};
  side.origin[face.face / 2] = face.face % 2;
  std::array<Eigen::Vector3d*, 2> along = {&side.along_s, &side.along_t};
  for (int k = 0; k < 2; ++k) {
    const double size = static_cast<double>(face.extent[k][1] - face.extent[k][0]);
    double begin = static_cast<double>(extent[k][0] - face.extent[k][0]) / size,
           end = static_cast<double>(extent[k][1] - face.extent[k][0]) / size;
    if (face.natural_flip[k]) begin = 1.0 - begin, end = 1.0 - end;
    side.origin[face.natural_axis[k]] = begin;
    (*along[k])[face.natural_axis[k]] = end - begin;
  }
  return side;
}

/// Ascending along the second coordinate of the plane, then along the first.
bool before(const PlaneFace& a, const PlaneFace& b) {
  return std::tie(a.extent[1][0], a.extent[0][0]) < std::tie(b.extent[1][0], b.extent[0][0]);
}

void meet(Plane& plane, std::vector<FacePatch>& patches) {
  for (auto& side : plane.sides) std::ranges::sort(side, before);
  for (const PlaneFace& a : plane.sides[0])
    for (const PlaneFace& b : plane.sides[1]) {
      if (b.extent[1][0] >= a.extent[1][1]) break;  // and so are all after it
      std::array<Interval, 2> common;
      bool overlap = true;
      for (int k = 0; k < 2; ++k) {
        common[k] = {std::max(a.extent[k][0], b.extent[k][0]), std::min(a.extent[k][1], b.extent[k][1])};
        overlap = overlap && common[k][0] < common[k][1];
      }
      if (overlap) patches.push_back({{side_of(a, common), side_of(b, common)}});
    }
}

}  // namespace

std::vector<FacePatch> face_patches(const BaseTopology& topology, const Mesh& mesh) {
  if (mesh.shape != CellShape::hexahedron) throw std::invalid_argument("face_patches: hexahedra only");
  std::map<PlaneKey, Plane> planes;
  for (int cell = 0; cell < mesh.cell_count(); ++cell)
    for (int face = 0; face < 6; ++face) {
      const Placed placed = place(topology, mesh, cell, face);
      planes[placed.key].sides[placed.side].push_back(placed.face);
    }
  std::vector<FacePatch> patches;
  for (auto& [key, plane] : planes)
    if (!plane.sides[0].empty() && !plane.sides[1].empty()) meet(plane, patches);
  for (const BoundaryFace& boundary : mesh.boundary) {
    const PlaneFace face = place(topology, mesh, boundary.cell, boundary.face).face;
    patches.push_back({{side_of(face, face.extent), {}}, boundary.base});
  }
  return patches;
}

}  // namespace finegauge
