#include "core/mesh/refinement_forest.hpp"

#include <algorithm>
#include <cassert>
#include <iterator>
#include <stdexcept>
#include <string>

#include "core/mesh/immersed_body.hpp"
#include "core/mesh/material_share.hpp"
#include "core/mesh/node_identity.hpp"
#include "core/mesh/tetrahedron_children.hpp"

namespace finegauge {

RefinementForest::RefinementForest(BaseMesh base) : base_(std::move(base)) {
  if (const std::string fault = validate(base_); !fault.empty()) throw std::invalid_argument("base mesh: " + fault);
  if (base_.body)
    if (const std::string fault = validate(*base_.body, base_); !fault.empty())
      throw std::invalid_argument("base mesh: " + fault);
  topology_ = base_topology(base_);
  leaf_count_ = static_cast<int>(base_.cells.size());
  cells_.reserve(base_.cells.size());
  for (int cell = 0; cell < leaf_count_; ++cell) {
    cells_.push_back({-1, -1, cell, 0, {{1, 1, 1}}, {1, 1, 1}, 1.0, means_of_full_cell});
    if (!base_.body) continue;
    cells_.back().share = base_.body->share[cell];
    cells_.back().means = material_means(*base_.body, base_frame(base_.shape, cell), cells_.back().share);
  }
}

std::size_t RefinementForest::storage_bytes() const {
  return cells_.capacity() * sizeof(Cell) + free_.size() * sizeof(*free_.begin());
}

bool RefinementForest::can_refine(int leaf, RefinementTemplate refinement) const {
  if (!is_leaf(leaf) || refinement.child_count() < 2) return false;
  if (base_.shape == CellShape::tetrahedron && refinement != RefinementTemplate{{2, 2, 2}}) return false;
  // One more halving than the children need, so that a tetrahedron's inner faces can be told apart on the lattice.
  const std::uint64_t unit = lattice_unit(base_.shape) / (base_.shape == CellShape::tetrahedron ? 2 : 1);
  for (int axis = 0; axis < 3; ++axis) {
    const std::uint64_t divisions = refinement.divisions[axis];
    if (divisions < 1 || divisions > max_divisions) return false;
    if (cells_[leaf].per_edge[axis] > unit / divisions || unit % (cells_[leaf].per_edge[axis] * divisions) != 0)
      return false;
  }
  return true;
}

void RefinementForest::refine(int leaf, RefinementTemplate refinement) {
  assert(can_refine(leaf, refinement));
  const int count = refinement.child_count();
  int first = static_cast<int>(cells_.size());
  const auto run = std::find_if(free_.begin(), free_.end(), [&](const auto& r) { return r.second >= count; });
  if (run != free_.end()) {
    const auto [start, length] = *run;
    first = start;
    free_.erase(run);
    if (length > count) free_.emplace(start + count, length - count);
  } else {
    cells_.resize(cells_.size() + count);
  }
  Cell child{leaf,
             -1,
             cells_[leaf].base,
             cells_[leaf].depth + 1,
             {{1, 1, 1}},
             cells_[leaf].per_edge,
             cells_[leaf].share,
             means_of_full_cell};
  for (int axis = 0; axis < 3; ++axis) child.per_edge[axis] *= refinement.divisions[axis];
  std::fill_n(cells_.begin() + first, count, child);
  cells_[leaf].first_child = first;
  cells_[leaf].refinement = refinement;
  leaf_count_ += count - 1;
  if (base_.body && 0.0 < child.share && child.share < 1.0)
    for (int k = first; k < first + count; ++k) {
      const LeafFrame frame = hexahedron_frame(*this, k);
      cells_[k].share = material_share(*base_.body, frame);
      cells_[k].means = material_means(*base_.body, frame, cells_[k].share);
    }
}

bool RefinementForest::can_coarsen(int handle) const {
  const Cell& cell = cells_[handle];
  if (cell.first_child < 0) return false;
  const int count = cell.refinement.child_count();
  return std::all_of(cells_.begin() + cell.first_child, cells_.begin() + cell.first_child + count,
                     [](const Cell& child) { return child.first_child < 0; });
}

void RefinementForest::coarsen(int handle) {
  assert(can_coarsen(handle));
  Cell& cell = cells_[handle];
  const int count = cell.refinement.child_count();
  int first = cell.first_child, length = count;
  cell.first_child = -1;
  cell.refinement = {{1, 1, 1}};
  leaf_count_ -= count - 1;
  // Join with the unused runs on both sides; what ends the storage is given back.
  auto next = free_.lower_bound(first);
  if (next != free_.end() && first + length == next->first) {
    length += next->second;
    next = free_.erase(next);
  }
  if (next != free_.begin()) {
    const auto before = std::prev(next);
    if (before->first + before->second == first) {
      first = before->first;
      length += before->second;
      free_.erase(before);
    }
  }
  if (first + length == handle_count())
    cells_.resize(static_cast<std::size_t>(first));
  else
    free_.emplace(first, length);
}

namespace {

void fill_heights(const RefinementForest& forest, int handle, std::vector<int>& heights) {
  const auto& cell = forest.cell(handle);
  heights[handle] = 0;
  if (cell.first_child < 0) return;
  for (int child = cell.first_child; child < cell.first_child + cell.refinement.child_count(); ++child) {
    fill_heights(forest, child, heights);
    heights[handle] = std::max(heights[handle], 1 + heights[child]);
  }
}

/// Corners of a leaf on the lattice of its base cell.
void corner_points(CellShape shape, const LeafFrame& frame, std::array<LatticePoint, max_corners>& points) {
  if (shape == CellShape::tetrahedron) {
    std::copy(frame.corners.begin(), frame.corners.end(), points.begin());
    return;
  }
  const auto& [lower, size, unused_a, unused_b] = frame.corners;
  for (int c = 0; c < 8; ++c)
    for (int axis = 0; axis < 3; ++axis) points[c][axis] = lower[axis] + ((c >> axis) & 1 ? size[axis] : 0);
}

/// Whether the leaf touches the given face of its base cell with a face of its own.
bool lies_on_base_face(CellShape shape, const LeafFrame& frame, int base_face, int& leaf_face) {
  const std::uint64_t unit = lattice_unit(shape);
  if (shape == CellShape::hexahedron) {
    leaf_face = base_face;
    const int axis = base_face / 2;
    const std::uint64_t lower = frame.corners[0][axis], size = frame.corners[1][axis];
    return base_face % 2 == 0 ? lower == 0 : lower + size == unit;
  }
  int off_face = -1, off_count = 0;
  for (int c = 0; c < 4; ++c) {
    const LatticePoint& p = frame.corners[c];
    const std::uint64_t weight = base_face == 0 ? unit - p[0] - p[1] - p[2] : p[base_face - 1];
    if (weight != 0) {
      off_face = c;
      ++off_count;
    }
  }
  leaf_face = off_face;
  return off_count == 1;
}

struct MeshBuilder {
  const RefinementForest& forest;
  const std::vector<int>& heights;
  int height;
  NodeNumbers numbers;
  Mesh mesh;
  std::vector<std::vector<LeafFrame>> frames;  // children per depth, reused

  void visit(int handle, const LeafFrame& frame) {
    if (heights[handle] <= height) {
      add_leaf(handle, frame);
      return;
    }
    const auto& cell = forest.cell(handle);
    const auto depth = static_cast<std::size_t>(frame.depth);
    if (frames.size() <= depth) frames.resize(depth + 1);
    std::vector<LeafFrame> children = std::move(frames[depth]);
    child_frames(mesh.shape, frame, cell.refinement, children);
    for (std::size_t k = 0; k < children.size(); ++k) visit(cell.first_child + static_cast<int>(k), children[k]);
    frames[depth] = std::move(children);
  }

  void add_leaf(int handle, const LeafFrame& frame) {
    std::array<LatticePoint, max_corners> points;
    corner_points(mesh.shape, frame, points);
    std::array<int, max_corners> nodes;
    nodes.fill(-1);
    for (int c = 0; c < corner_count(mesh.shape); ++c)
      nodes[c] = numbers.number(identity_of(forest.base(), forest.topology(), frame.base_cell, points[c]));
    const int cell = mesh.cell_count();
    mesh.cells.push_back(nodes);
    mesh.frames.push_back(frame);
    mesh.forest_cell.push_back(handle);
    if (forest.base().body) {
      mesh.fraction.push_back(forest.cell(handle).share);
      mesh.means.push_back(forest.cell(handle).means);
    }
    for (int f = 0; f < face_count(mesh.shape); ++f) {
      const auto& view = forest.topology().cell_faces[frame.base_cell][f];
      if (forest.topology().face_cells[view.face][1].cell >= 0) continue;
      if (int leaf_face = 0; lies_on_base_face(mesh.shape, frame, f, leaf_face))
        mesh.boundary.push_back({cell, leaf_face, {frame.base_cell, f}});
    }
  }
};

}  // namespace

LeafFrame base_frame(CellShape shape, int base_cell) {
  const std::uint64_t unit = lattice_unit(shape);
  if (shape == CellShape::hexahedron) return {base_cell, 0, {{{0, 0, 0}, {unit, unit, unit}, {}, {}}}};
  return {base_cell, 0, {{{0, 0, 0}, {unit, 0, 0}, {0, unit, 0}, {0, 0, unit}}}};
}

LeafFrame hexahedron_frame(const RefinementForest& forest, int handle) {
  constexpr std::uint64_t unit = lattice_unit(CellShape::hexahedron);
  LeafFrame frame{forest.cell(handle).base, forest.cell(handle).depth, {}};
  for (int axis = 0; axis < 3; ++axis) frame.corners[1][axis] = unit / forest.cell(handle).per_edge[axis];
  for (int cell = handle, parent = forest.cell(cell).parent; parent >= 0;
       cell = parent, parent = forest.cell(cell).parent) {
    int number = cell - forest.cell(parent).first_child;
    for (int axis = 0; axis < 3; ++axis) {
      const int divisions = forest.cell(parent).refinement.divisions[axis];
      frame.corners[0][axis] +=
          static_cast<std::uint64_t>(number % divisions) * (unit / forest.cell(cell).per_edge[axis]);
      number /= divisions;
    }
  }
  return frame;
}

double share_of_base_cell(const RefinementForest::Cell& cell) {
  double share = 1.0;
  for (const std::uint64_t count : cell.per_edge) share /= static_cast<double>(count);
  return share;
}

void child_frames(CellShape shape, const LeafFrame& frame, RefinementTemplate refinement,
                  std::vector<LeafFrame>& children) {
  children.clear();
  LeafFrame child{frame.base_cell, frame.depth + 1, {}};
  if (shape == CellShape::tetrahedron) {
    for (const auto& corners : tetrahedron_children) {
      for (int c = 0; c < 4; ++c) {
        const auto& [a, b] = corners[c];
        for (int axis = 0; axis < 3; ++axis)
          child.corners[c][axis] = frame.corners[a][axis] / 2 + frame.corners[b][axis] / 2;
      }
      children.push_back(child);
    }
    return;
  }
  const auto& n = refinement.divisions;
  for (int axis = 0; axis < 3; ++axis) child.corners[1][axis] = frame.corners[1][axis] / n[axis];
  const auto& size = child.corners[1];
  for (std::uint64_t k = 0; k < n[2]; ++k)
    for (std::uint64_t j = 0; j < n[1]; ++j)
      for (std::uint64_t i = 0; i < n[0]; ++i) {
        child.corners[0] = {frame.corners[0][0] + i * size[0], frame.corners[0][1] + j * size[1],
                            frame.corners[0][2] + k * size[2]};
        children.push_back(child);
      }
}

std::vector<int> RefinementForest::heights() const {
  std::vector<int> heights(cells_.size(), 0);
  for (int cell = 0; cell < static_cast<int>(base_.cells.size()); ++cell) fill_heights(*this, cell, heights);
  return heights;
}

Mesh RefinementForest::leaf_mesh(int height, const std::vector<int>& heights) const {
  MeshBuilder builder{*this, heights, height, NodeNumbers(static_cast<std::size_t>(leaf_count_) * 3 / 2), {}, {}};
  builder.mesh.shape = base_.shape;
  for (int cell = 0; cell < static_cast<int>(base_.cells.size()); ++cell)
    builder.visit(cell, base_frame(base_.shape, cell));
  Mesh mesh = std::move(builder.mesh);
  mesh.identities = builder.numbers.take();
  const int nodes = static_cast<int>(mesh.identities.size());
  mesh.nodes.resize(3, nodes);
  mesh.on_boundary.resize(nodes);
  for (int node = 0; node < nodes; ++node) {
    mesh.nodes.col(node) = position_of(base_, topology_, mesh.identities[node]);
    mesh.on_boundary[node] = on_boundary(topology_, mesh.identities[node]);
  }
  return mesh;
}

NodeCells cells_around_nodes(const Mesh& mesh) {
  NodeCells around;
  around.start.assign(mesh.node_count() + 1, 0);
  const int corners = corner_count(mesh.shape);
  for (const auto& cell : mesh.cells)
    for (int c = 0; c < corners; ++c) ++around.start[cell[c] + 1];
  for (int node = 0; node < mesh.node_count(); ++node) around.start[node + 1] += around.start[node];
  around.cells.resize(around.start.back());
  std::vector<int> next(around.start.begin(), around.start.end() - 1);
  for (int cell = 0; cell < mesh.cell_count(); ++cell)
    for (int c = 0; c < corners; ++c) around.cells[next[mesh.cells[cell][c]]++] = cell;
  return around;
}

}  // namespace finegauge
