#include "core/mesh/hanging_nodes.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "core/mesh/node_identity.hpp"
#include "core/mesh/tetrahedron_children.hpp"

namespace finegauge {
namespace {

/// A leaf demands that a node has the leaf's interpolated value.
struct Equation {
  int node;
  int dimension;  // of the node's base entity
  double size;    // share of the leaf in its base cell
  int count;      // corners with a weight
  std::array<int, 4> corner;
  std::array<double, 4> weight;
};

/// Finds the leaves that contain a point without having it as a corner.
class LeafSearch {
 public:
  LeafSearch(const RefinementForest& forest, const Mesh& mesh)
      : forest_(forest), mesh_(mesh), cell_of_(forest.handle_count(), -1) {
    for (int cell = 0; cell < mesh.cell_count(); ++cell) cell_of_[mesh.forest_cell[cell]] = cell;
    if (mesh.shape == CellShape::tetrahedron)
      for (int child = 0; child < 8; ++child) child_maps_[child] = tetrahedron_child_map(child);
  }

  /// The node as interpolated in the cell whose refinement brought it, as if it did not bend the field; of several
  /// such cells the largest. Names nodes of the closure of the node's base entity. Hexahedra only.
  Equation unbent(int node) {
    local_points(forest_.base(), forest_.topology(), mesh_.identities[node], points_);
    const std::uint64_t unit = lattice_unit(mesh_.shape);
    std::vector<Equation> candidates;
    for (const auto& [base_cell, point] : points_)
      descend_to_origin(node, base_cell, point, {unit, unit, unit}, candidates);
    return *std::max_element(candidates.begin(), candidates.end(),
                             [](const Equation& a, const Equation& b) { return a.size < b.size; });
  }

  void equations_of(int node, std::vector<Equation>& equations) {
    local_points(forest_.base(), forest_.topology(), mesh_.identities[node], points_);
    for (const auto& [base_cell, point] : points_) {
      const std::uint64_t unit = lattice_unit(mesh_.shape);
      if (mesh_.shape == CellShape::hexahedron) {
        descend_hexahedron(node, base_cell, point, {unit, unit, unit}, equations);
      } else {
        const auto x = static_cast<std::int64_t>(point[0]), y = static_cast<std::int64_t>(point[1]),
                   z = static_cast<std::int64_t>(point[2]);
        descend_tetrahedron(node, base_cell, {static_cast<std::int64_t>(unit) - x - y - z, x, y, z}, equations);
      }
    }
  }

 private:
  /// `at` is the point relative to the cell's lower corner, 0 <= at <= size on each axis.
  void descend_hexahedron(int node, int handle, const LatticePoint& at, const LatticePoint& size,
                          std::vector<Equation>& equations) {
    if (const int cell = cell_of_[handle]; cell >= 0) {
      if (!is_corner(at, size)) add_hexahedron_equation(node, handle, mesh_.cells[cell], share_of(at, size), equations);
      return;
    }
    visit_children_at(handle, at, size, [&](int child, const LatticePoint& child_at, const LatticePoint& child_size) {
      descend_hexahedron(node, child, child_at, child_size, equations);
    });
  }

  /// Calls visit(child, point relative to it, its size) for the children that contain the point.
  template <class Visit>
  void visit_children_at(int handle, const LatticePoint& at, const LatticePoint& size, const Visit& visit) {
    const auto& parent = forest_.cell(handle);
    const auto& n = parent.refinement.divisions;
    std::array<std::uint64_t, 3> first, last;
    LatticePoint child_size;
    for (int axis = 0; axis < 3; ++axis) {
      child_size[axis] = size[axis] / n[axis];
      const std::uint64_t index = at[axis] / child_size[axis], rest = at[axis] % child_size[axis];
      first[axis] = rest == 0 && index > 0 ? index - 1 : index;
      last[axis] = std::min<std::uint64_t>(index, n[axis] - 1u);
    }
    for (std::uint64_t k = first[2]; k <= last[2]; ++k)
      for (std::uint64_t j = first[1]; j <= last[1]; ++j)
        for (std::uint64_t i = first[0]; i <= last[0]; ++i)
          visit(parent.first_child + static_cast<int>(i + n[0] * (j + n[1] * k)),
                LatticePoint{at[0] - i * child_size[0], at[1] - j * child_size[1], at[2] - k * child_size[2]},
                child_size);
  }

  static bool is_corner(const LatticePoint& at, const LatticePoint& size) {
    bool corner = true;
    for (int axis = 0; axis < 3; ++axis) corner = corner && (at[axis] == 0 || at[axis] == size[axis]);
    return corner;
  }
  /// Natural coordinates ξ along each axis as {1 - ξ, ξ}, each to round-off: 1 - ξ by subtraction would have lost the
  /// digits that a deep leaf beside a coarse one needs.
  using Shares = std::array<std::array<double, 2>, 3>;
  static Shares share_of(const LatticePoint& at, const LatticePoint& size) {
    Shares shares;
    for (int axis = 0; axis < 3; ++axis)
      shares[axis] = {static_cast<double>(size[axis] - at[axis]) / static_cast<double>(size[axis]),
                      static_cast<double>(at[axis]) / static_cast<double>(size[axis])};
    return shares;
  }

  /// Collects the cells that contain the point without having it as a corner while a child of theirs has.
  void descend_to_origin(int node, int handle, const LatticePoint& at, const LatticePoint& size,
                         std::vector<Equation>& origins) {
    if (cell_of_[handle] >= 0 || is_corner(at, size)) return;
    bool brought = false;
    visit_children_at(handle, at, size, [&](int child, const LatticePoint& child_at, const LatticePoint& child_size) {
      brought = brought || is_corner(child_at, child_size);
      descend_to_origin(node, child, child_at, child_size, origins);
    });
    if (!brought) return;
    std::array<int, max_corners> corners;
    for (int c = 0; c < 8; ++c) {
      int cell = handle;  // a corner of a cell is the same corner of the child there
      while (cell_of_[cell] < 0) {
        const auto& parent = forest_.cell(cell);
        const auto& n = parent.refinement.divisions;
        cell = parent.first_child + (c & 1 ? n[0] - 1 : 0) +
               n[0] * ((c & 2 ? n[1] - 1 : 0) + n[1] * (c & 4 ? n[2] - 1 : 0));
      }
      corners[c] = mesh_.cells[cell_of_[cell]][c];
    }
    add_hexahedron_equation(node, handle, corners, share_of(at, size), origins);
  }

  /// Without corners yet.
  Equation equation_for(int node, int handle) const {
    return {node, entity_dimension(mesh_.identities[node]), share_of_base_cell(forest_.cell(handle)), 0, {}, {}};
  }

  void add_hexahedron_equation(int node, int handle, const std::array<int, max_corners>& corners, const Shares& shares,
                               std::vector<Equation>& equations) const {
    Equation equation = equation_for(node, handle);
    for (int c = 0; c < 8; ++c) {
      const double N = shares[0][c & 1] * shares[1][c >> 1 & 1] * shares[2][c >> 2 & 1];
      if (N == 0.0) continue;
      equation.corner[equation.count] = corners[c];
      equation.weight[equation.count++] = N;
    }
    equations.push_back(equation);
  }

  /// `at`: barycentric coordinates in lattice units, none negative, sum = the cell's size.
  void descend_tetrahedron(int node, int handle, const std::array<std::int64_t, 4>& at,
                           std::vector<Equation>& equations) {
    if (const int cell = cell_of_[handle]; cell >= 0) {
      const double size = static_cast<double>(at[0] + at[1] + at[2] + at[3]);
      Equation equation = equation_for(node, handle);
      for (int c = 0; c < 4; ++c) {
        if (at[c] == 0) continue;
        equation.corner[equation.count] = mesh_.cells[cell][c];
        equation.weight[equation.count++] = static_cast<double>(at[c]) / size;
      }
      if (equation.count > 1) equations.push_back(equation);
      return;
    }
    const int first_child = forest_.cell(handle).first_child;
    for (int child = 0; child < 8; ++child) {
      std::array<std::int64_t, 4> inside;
      bool contained = true;
      for (int i = 0; i < 4 && contained; ++i) {
        std::int64_t twice = 0;
        for (int j = 0; j < 4; ++j) twice += child_maps_[child][i][j] * at[j];
        inside[i] = twice / 2;
        contained = twice >= 0;
      }
      if (contained) descend_tetrahedron(node, first_child + child, inside, equations);
    }
  }

  const RefinementForest& forest_;
  const Mesh& mesh_;
  std::vector<int> cell_of_;  // leaf of this mesh by handle, -1 otherwise
  std::vector<LocalPoint> points_;
  std::array<std::array<std::array<int, 4>, 4>, 8> child_maps_{};
};

/// Leaf corners that meet at a node that does not hang, of a hexahedral mesh.
int full_corner_count(const BaseTopology& topology, const NodeIdentity& identity) {
  const int index = entity_index(identity);
  switch (entity_dimension(identity)) {
    case 0:
      return topology.node_cell_start[index + 1] - topology.node_cell_start[index];
    case 1:
      return 2 * (topology.edge_cell_start[index + 1] - topology.edge_cell_start[index]);
    case 2:
      return topology.face_cells[index][1].cell < 0 ? 4 : 8;
    default:
      return 8;
  }
}

std::vector<Equation> collect_equations(const RefinementForest& forest, const Mesh& mesh, LeafSearch& search) {
  std::vector<Equation> equations;
  std::vector<int> meeting;  // hexahedra: nodes with all their corners need no search
  if (mesh.shape == CellShape::hexahedron) {
    meeting.assign(mesh.node_count(), 0);
    for (const auto& cell : mesh.cells)
      for (const int node : cell) ++meeting[node];
  }
  for (int node = 0; node < mesh.node_count(); ++node) {
    const auto& identity = mesh.identities[node];
    if (entity_dimension(identity) == 0) continue;
    if (!meeting.empty() && meeting[node] == full_corner_count(forest.topology(), identity)) continue;
    search.equations_of(node, equations);
  }
  // Edges of the base before its faces before its cells: an equation names nodes of its own entity's closure only, so
  // what a face demands of itself is known before the cells behind it are asked.
  std::stable_sort(equations.begin(), equations.end(), [](const Equation& a, const Equation& b) {
    return std::tuple(a.dimension, -a.size) < std::tuple(b.dimension, -b.size);
  });
  return equations;
}

/// Gauss elimination of the equations, node by node.
class Elimination {
 public:
  Elimination(const RefinementForest& forest, const Mesh& mesh)
      : forest_(forest),
        mesh_(mesh),
        search_(forest, mesh),
        row_of_(mesh.node_count(), -1),
        chain_(mesh.node_count(), 0) {
    for (const Equation& equation : collect_equations(forest, mesh, search_)) eliminate(equation);
    for (int k = static_cast<int>(rows_.size()) - 1; k >= 0; --k) resolve(rows_[k]);
  }

  using Row = std::vector<std::pair<int, double>>;  // value of the node from others
  const Row* row(int node) const { return row_of_[node] < 0 ? nullptr : &rows_[row_of_[node]]; }
  int longest_chain() const { return longest_chain_; }

 private:
  struct Term {
    int node;
    double value;
    double magnitude;  // sum of the absolute contributions: what the value has to be compared with
  };

  void add(int node, double value) {
    for (Term& term : terms_)
      if (term.node == node) {
        term.value += value;
        term.magnitude += std::abs(value);
        return;
      }
    terms_.push_back({node, value, std::abs(value)});
  }
  /// Adds value × u_node with nodes that have a row replaced by it.
  void substitute(int node, double value) {
    if (row_of_[node] < 0) {
      add(node, value);
    } else {
      for (const auto& [other, weight] : rows_[row_of_[node]]) substitute(other, value * weight);
    }
  }

  /// What the equation says of nodes without a row: Σ terms = 0.
  void collect_terms(const Equation& equation) {
    terms_.clear();
    for (int k = 0; k < equation.count; ++k) substitute(equation.corner[k], equation.weight[k]);
    substitute(equation.node, -1.0);
    // Contributions that cancel do so to a few units of round-off; weights themselves may be tiny but do not cancel.
    std::erase_if(terms_, [](const Term& term) { return std::abs(term.value) <= 1e-12 * term.magnitude; });
  }

  void eliminate(const Equation& equation) {
    int chain = 0;
    for (int k = 0; k < equation.count; ++k) chain = std::max(chain, chain_[equation.corner[k]]);
    for (;;) {
      collect_terms(equation);
      if (terms_.empty()) return;  // follows from earlier equations
      const int pivot = choose_pivot(equation.node);
      if (pivot == equation.node || has_closed_row(pivot)) {
        add_row(pivot, chain + 1);
        return;
      }
      // The leaves leave one bend to two faces of the body at once, and a support of one face would have to be felt
      // on the other. The bend is given up, which keeps the field conforming, and the equation asked again.
      eliminate(search_.unbent(pivot));
    }
  }

  void add_row(int pivot, int chain) {
    Row row;
    double divisor = 0.0;
    for (const Term& term : terms_)
      if (term.node == pivot) divisor = -term.value;
    for (const Term& term : terms_)
      if (term.node != pivot) row.emplace_back(term.node, term.value / divisor);
    chain_[pivot] = chain;
    longest_chain_ = std::max(longest_chain_, chain);
    row_of_[pivot] = static_cast<int>(rows_.size());
    rows_.push_back(std::move(row));
  }

  /// The equation's own node where it is still free; its row then names nodes of its base entity's closure only. Else
  /// rather a node inside the body, then one of the base entity of higher dimension, and of these the one with the
  /// largest coefficient: smaller ones would multiply round-off and give weights that extrapolate, negative ones among
  /// them. Of coefficients that are equal but for round-off the node of smaller cells: a coarse corner stays free.
  int choose_pivot(int own) {
    double largest = 0.0;
    for (const Term& term : terms_) {
      if (term.node == own) return own;
      largest = std::max(largest, std::abs(term.value));
    }
    std::pair<bool, int> kind(false, -1);
    for (const Term& term : terms_)
      if (std::abs(term.value) >= 0.01 * largest) kind = std::max(kind, kind_of(term.node));
    largest = 0.0;
    for (const Term& term : terms_)
      if (kind_of(term.node) == kind) largest = std::max(largest, std::abs(term.value));
    if (coarsest_.empty()) find_coarsest_cells();
    int pivot = -1;
    for (const Term& term : terms_)
      if (kind_of(term.node) == kind && std::abs(term.value) >= (1.0 - 1e-9) * largest &&
          (pivot < 0 || rank(term.node) > rank(pivot)))
        pivot = term.node;
    return pivot;
  }
  /// Larger: rather eliminated, whatever the coefficients.
  std::pair<bool, int> kind_of(int node) const {
    return {!mesh_.on_boundary[node], entity_dimension(mesh_.identities[node])};
  }
  /// The same of equal coefficients.
  std::pair<double, int> rank(int node) const { return {-coarsest_[node], node}; }

  /// Whether the terms, as the row of a node on the boundary or in a region, name nodes of its face or edge of the base
  /// only.
  bool has_closed_row(int pivot) {
    const NodeIdentity& identity = mesh_.identities[pivot];
    // Tetrahedra know one template, whose faces always fit: nothing is ever left to couple. An equation of a base
    // cell's inside names nodes of that cell only.
    if (mesh_.shape == CellShape::tetrahedron || entity_dimension(identity) == 3) return true;
    if (!mesh_.on_boundary[pivot] && !in_a_region(identity)) return true;
    return std::all_of(terms_.begin(), terms_.end(),
                       [&](const Term& term) { return in_closure(mesh_.identities[term.node], identity); });
  }
  /// Base nodes of a vertex, edge or face; -1 in unused entries.
  std::array<int, 4> base_nodes_of(const NodeIdentity& identity) const {
    std::array<int, 4> nodes = {-1, -1, -1, -1};
    const BaseTopology& topology = forest_.topology();
    const int index = entity_index(identity);
    if (entity_dimension(identity) == 0) nodes[0] = index;
    if (entity_dimension(identity) == 1) std::copy_n(topology.edges[index].begin(), 2, nodes.begin());
    if (entity_dimension(identity) == 2) nodes = topology.faces[index];
    return nodes;
  }
  bool in_a_region(const NodeIdentity& identity) const {
    const std::array<int, 4> nodes = base_nodes_of(identity);
    return std::ranges::any_of(forest_.base().regions, [&](const auto& region) {
      return std::ranges::all_of(nodes, [&](int node) {
        return node < 0 || std::binary_search(region.second.begin(), region.second.end(), node);
      });
    });
  }
  bool in_closure(const NodeIdentity& inner, const NodeIdentity& outer) const {
    if (inner.entity == outer.entity) return true;
    if (entity_dimension(inner) >= entity_dimension(outer)) return false;
    const std::array<int, 4> inner_nodes = base_nodes_of(inner), outer_nodes = base_nodes_of(outer);
    return std::all_of(inner_nodes.begin(), inner_nodes.end(), [&](int node) {
      return node < 0 || std::find(outer_nodes.begin(), outer_nodes.end(), node) != outer_nodes.end();
    });
  }

  /// Share of the base cell of the largest leaf that has the node as a corner.
  void find_coarsest_cells() {
    coarsest_.assign(mesh_.node_count(), 0.0);
    for (int cell = 0; cell < mesh_.cell_count(); ++cell) {
      const double size = share_of_base_cell(forest_.cell(mesh_.forest_cell[cell]));
      for (int c = 0; c < corner_count(mesh_.shape); ++c) {
        double& coarsest = coarsest_[mesh_.cells[cell][c]];
        coarsest = std::max(coarsest, size);
      }
    }
  }

  /// Replaces nodes that got a row later by that row; those rows are resolved already.
  void resolve(Row& row) {
    if (std::none_of(row.begin(), row.end(), [&](const auto& term) { return row_of_[term.first] >= 0; })) return;
    terms_.clear();
    for (const auto& [node, weight] : row) substitute(node, weight);
    row.clear();
    for (const Term& term : terms_)
      if (std::abs(term.value) > 1e-12 * term.magnitude) row.emplace_back(term.node, term.value);
  }

  const RefinementForest& forest_;
  const Mesh& mesh_;
  LeafSearch search_;
  std::vector<int> row_of_;
  std::vector<int> chain_;
  std::vector<Row> rows_;
  std::vector<Term> terms_;
  std::vector<double> coarsest_;
  int longest_chain_ = 0;
};

}  // namespace

HangingNodes find_hanging_nodes(const RefinementForest& forest, const Mesh& mesh) {
  const Elimination elimination(forest, mesh);
  HangingNodes hanging;
  hanging.longest_chain = elimination.longest_chain();
  hanging.reduced_of.assign(mesh.node_count(), -1);
  for (int node = 0; node < mesh.node_count(); ++node) {
    if (elimination.row(node)) continue;
    hanging.reduced_of[node] = hanging.reduced_count();
    hanging.node_of.push_back(node);
  }
  hanging.row_start.reserve(mesh.node_count() + 1);
  hanging.row_start.push_back(0);
  std::vector<std::pair<int, double>> sorted;
  for (int node = 0; node < mesh.node_count(); ++node) {
    if (const auto* row = elimination.row(node)) {
      sorted.clear();
      for (const auto& [master, weight] : *row) sorted.emplace_back(hanging.reduced_of[master], weight);
      std::sort(sorted.begin(), sorted.end());
      for (const auto& [master, weight] : sorted) {
        hanging.master.push_back(master);
        hanging.weight.push_back(weight);
      }
    } else {
      hanging.master.push_back(hanging.reduced_of[node]);
      hanging.weight.push_back(1.0);
    }
    hanging.row_start.push_back(static_cast<int>(hanging.master.size()));
  }
  return hanging;
}

}  // namespace finegauge
