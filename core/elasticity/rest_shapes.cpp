#include <bit>
#include <cmath>
#include <cstdint>

#include "core/elasticity/cell_geometry.hpp"

namespace finegauge {

namespace {

/// A cell's shape without its place, in whole steps of 2^-42 of its size: the differences that make up the trilinear
/// (or linear) map, and the exponent of the size.
struct ShapeKey {
  Eigen::Matrix<double, 3, max_corners> steps;  ///< column 0, the translation, holds the exponent instead
  bool operator==(const ShapeKey& other) const { return steps == other.steps; }
};

ShapeKey shape_key(const Mesh& mesh, int cell) {
  CellVectors c = corner_values(mesh, cell, mesh.nodes);
  if (mesh.shape == CellShape::hexahedron) {
    for (int bit = 1; bit < 8; bit *= 2)
      for (int a = 0; a < 8; ++a)
        if (a & bit) c.col(a) -= c.col(a ^ bit);
  } else {
    for (int a = 1; a < 4; ++a) c.col(a) -= c.col(0).eval();
  }
  c.col(0).setZero();
  // A little over the size, so that sizes which are powers of two up to round-off do not straddle two exponents.
  int exponent = 0;
  std::frexp(c.cwiseAbs().maxCoeff() * (1.0 + 0x1p-20), &exponent);
  ShapeKey key;
  // + 0.0 makes a negative zero positive: equal steps then have equal bits.
  key.steps = ((c.array() * std::ldexp(1.0, 42 - exponent)).rint() + 0.0).matrix();
  key.steps(0, 0) = exponent;
  return key;
}

std::uint64_t hash(const ShapeKey& key) {
  // Multiply and fold word by word (the mixing step of splitmix64 at the end).
  std::uint64_t h = 0x9e3779b97f4a7c15ull;
  const double* word = key.steps.data();
  for (int i = 0; i < 24; ++i) {
    h = (h ^ std::bit_cast<std::uint64_t>(word[i])) * 0xbf58476d1ce4e5b9ull;
    h ^= h >> 32;
  }
  h = (h ^ (h >> 27)) * 0x94d049bb133111ebull;
  return h ^ (h >> 31);
}

}  // namespace

RestShapes::RestShapes(const Mesh& mesh, const Material& material) : material_(material) {
  // Open addressing on the hash; a hit is confirmed by the key of the first cell, so a collision cannot merge shapes.
  struct Slot {
    std::uint64_t hash;
    int first = -1;
  };
  const int n = mesh.cell_count();
  std::vector<Slot> slots(std::bit_ceil(2 * static_cast<std::size_t>(n) + 2));
  const std::size_t mask = slots.size() - 1;
  std::vector<int> first_of(n);
  std::vector<int> members(n, 0);
  ShapeKey previous;
  for (int cell = 0; cell < n; ++cell) {
    const ShapeKey key = shape_key(mesh, cell);
    if (cell > 0 && key == previous) {  // siblings
      first_of[cell] = first_of[cell - 1];
    } else {
      const std::uint64_t h = hash(key);
      std::size_t at = h & mask;
      while (slots[at].first >= 0 && !(slots[at].hash == h && shape_key(mesh, slots[at].first) == key))
        at = (at + 1) & mask;
      if (slots[at].first < 0) slots[at] = {h, cell};
      first_of[cell] = slots[at].first;
      previous = key;
    }
    ++members[first_of[cell]];
  }

  shared_of_.assign(n, -1);
  for (int cell = 0; cell < n; ++cell) {
    const int first = first_of[cell];
    if (members[first] < 2) continue;
    if (first == cell) {
      shared_of_[cell] = static_cast<int>(shared_.size());
      Entry& added = shared_.emplace_back();
      added.geometry = cell_geometry(mesh.shape, corner_values(mesh, cell, mesh.nodes));
      added.stiffness = cell_stiffness(mesh.shape, added.geometry, material_);
    }
    shared_of_[cell] = shared_of_[first];
  }
}

CellMatrix RestShapes::stiffness_of(const Mesh& mesh, int cell, const CellGeometry& geometry,
                                    const CellMatrix& full) const {
  const Gradients average = mesh.means.empty()
                                ? geometry.mean_gradients
                                : material_gradients(corner_values(mesh, cell, mesh.nodes), mesh.means[cell]);
  return partial_stiffness(geometry, full, average, material_share(mesh, cell), material_);
}

RestShapes::CellView RestShapes::entry(const Mesh& mesh, int cell, Entry& scratch) const {
  const bool whole = material_share(mesh, cell) == 1.0;
  if (shared_of_[cell] >= 0) {
    const Entry& shared = shared_[shared_of_[cell]];
    if (whole) return {shared.geometry, shared.stiffness};
    scratch.stiffness = stiffness_of(mesh, cell, shared.geometry, shared.stiffness);
    return {shared.geometry, scratch.stiffness};
  }
  scratch.geometry = cell_geometry(mesh.shape, corner_values(mesh, cell, mesh.nodes));
  scratch.stiffness = cell_stiffness(mesh.shape, scratch.geometry, material_);
  if (!whole) scratch.stiffness = stiffness_of(mesh, cell, scratch.geometry, scratch.stiffness);
  return {scratch.geometry, scratch.stiffness};
}

const CellGeometry& RestShapes::geometry(const Mesh& mesh, int cell, CellGeometry& scratch) const {
  const bool placed =
      material_.dilatation == Dilatation::mean && !mesh.means.empty() && material_share(mesh, cell) < 1.0;
  if (shared_of_[cell] >= 0 && !placed) return shared_[shared_of_[cell]].geometry;
  const CellVectors corners = corner_values(mesh, cell, mesh.nodes);
  scratch = shared_of_[cell] >= 0 ? shared_[shared_of_[cell]].geometry : cell_geometry(mesh.shape, corners);
  if (placed) scratch.mean_gradients = material_gradients(corners, mesh.means[cell]);
  return scratch;
}

}  // namespace finegauge
