#include "verification/support/scrambled_mesh.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "verification/support/sample_cells.hpp"

namespace finegauge {
namespace {

template <std::size_t N>
std::array<int, N> random_permutation(std::mt19937& generator) {
  std::array<int, N> order;
  std::iota(order.begin(), order.end(), 0);
  for (std::size_t i = N - 1; i > 0; --i) std::swap(order[i], order[generator() % (i + 1)]);
  return order;
}

bool is_odd(const std::vector<int>& order) {
  int inversions = 0;
  for (std::size_t i = 0; i < order.size(); ++i)
    for (std::size_t j = i + 1; j < order.size(); ++j) inversions += order[i] > order[j];
  return inversions % 2 == 1;
}

/// Old corners and old faces in their new order.
struct Turn {
  std::array<int, max_corners> corner;
  std::array<int, 6> face;
};

Turn random_turn(CellShape shape, std::mt19937& generator) {
  Turn turn;
  turn.corner.fill(-1);
  turn.face.fill(-1);
  if (shape == CellShape::tetrahedron) {
    auto order = random_permutation<4>(generator);
    if (is_odd({order.begin(), order.end()})) std::swap(order[0], order[1]);
    std::copy(order.begin(), order.end(), turn.corner.begin());
    std::copy(order.begin(), order.end(), turn.face.begin());  // face f is opposite to corner f
    return turn;
  }
  const auto axis = random_permutation<3>(generator);  // the old axis that the new one runs along
  std::array<int, 3> flip;
  for (int& f : flip) f = static_cast<int>(generator() % 2);
  if (is_odd({axis.begin(), axis.end()}) != ((flip[0] + flip[1] + flip[2]) % 2 == 1)) flip[0] = 1 - flip[0];
  for (int c = 0; c < 8; ++c) {
    turn.corner[c] = 0;
    for (int k = 0; k < 3; ++k) turn.corner[c] |= (((c >> k) & 1) ^ flip[k]) << axis[k];
  }
  for (int k = 0; k < 3; ++k)
    for (int side = 0; side < 2; ++side) turn.face[2 * k + side] = 2 * axis[k] + (side ^ flip[k]);
  return turn;
}

}  // namespace

BaseMesh scrambled(const BaseMesh& mesh, std::mt19937& generator) {
  BaseMesh result = mesh;
  std::vector<int> number(mesh.nodes.cols());
  std::iota(number.begin(), number.end(), 0);
  for (std::size_t i = number.size() - 1; i > 0; --i) std::swap(number[i], number[generator() % (i + 1)]);
  for (Eigen::Index node = 0; node < mesh.nodes.cols(); ++node) result.nodes.col(number[node]) = mesh.nodes.col(node);
  std::vector<std::array<int, 6>> new_face(mesh.cells.size());
  for (std::size_t cell = 0; cell < mesh.cells.size(); ++cell) {
    const Turn turn = random_turn(mesh.shape, generator);
    for (int c = 0; c < corner_count(mesh.shape); ++c) result.cells[cell][c] = number[mesh.cells[cell][turn.corner[c]]];
    for (int f = 0; f < face_count(mesh.shape); ++f) new_face[cell][turn.face[f]] = f;
  }
  for (auto& [name, faces] : result.surfaces) {
    for (BaseFace& face : faces) face.face = new_face[face.cell][face.face];
    std::sort(faces.begin(), faces.end());
  }
  return result;
}

BaseMesh distorted_box(const BoxMeshOptions& options, double share, std::mt19937& generator) {
  BaseMesh mesh = box_mesh(options);
  for (Eigen::Index node = 0; node < mesh.nodes.cols(); ++node)
    for (int axis = 0; axis < 3; ++axis) {
      const double edge = options.size[axis] / options.cells[axis], x = mesh.nodes(axis, node) - options.origin[axis];
      const double shift = share * edge * random_number(generator);
      if (x > 0.5 * edge && x < options.size[axis] - 0.5 * edge) mesh.nodes(axis, node) += shift;
    }
  return mesh;
}

BaseMesh macneal_harder_patch() {
  BaseMesh mesh;
  mesh.nodes.resize(3, 16);
  for (int c = 0; c < 8; ++c) mesh.nodes.col(c) = Eigen::Vector3d(c & 1, (c >> 1) & 1, (c >> 2) & 1);
  mesh.nodes.rightCols<8>() << 0.249, 0.826, 0.273, 0.850, 0.320, 0.677, 0.165, 0.788,  //
      0.342, 0.288, 0.750, 0.649, 0.186, 0.305, 0.745, 0.693,                           //
      0.192, 0.288, 0.230, 0.263, 0.643, 0.683, 0.702, 0.644;
  mesh.cells.push_back({8, 9, 10, 11, 12, 13, 14, 15});
  for (int face = 0; face < 6; ++face) {
    // Between an outer face and the inner cell's face: the outer one is at the lower end of the cell's own axis.
    const int axis = face / 2, side = face % 2;
    std::array<int, max_corners> cell;
    for (int c = 0; c < 8; ++c) {
      const int along = (c >> axis) & 1;
      const int corner = side ? c | (1 << axis) : c & ~(1 << axis);
      cell[c] = along == side ? corner : 8 + corner;
    }
    mesh.surfaces["outside"].push_back({static_cast<int>(mesh.cells.size()), face});
    mesh.cells.push_back(cell);
  }
  return mesh;
}

}  // namespace finegauge
