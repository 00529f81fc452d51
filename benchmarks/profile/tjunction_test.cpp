#include <algorithm>
#include <cmath>
#include <vector>

#include "benchmarks/profile/chain_lengths.hpp"
#include "benchmarks/profile/marking_patterns.hpp"
#include "benchmarks/profile/profile_tjunctions.hpp"
#include "benchmarks/profile/sparse_factor.hpp"
#include "benchmarks/profile/tjunction_ledger.hpp"
#include "benchmarks/profile/unreduced.hpp"
#include "core/solve/direct_solver.hpp"
#include "core/space/assembly.hpp"
#include "verification/support/catch.hpp"

using namespace finegauge;

namespace {

RefinementForest box(std::array<int, 3> cells) {
  BoxMeshOptions options;
  options.cells = cells;
  return RefinementForest(box_mesh(options));
}

Discretization clamped(const RefinementForest& forest) {
  Material material;
  material.youngs_modulus = 1e3, material.poisson_ratio = 0.3;
  material.kinematics = Kinematics::corotational;
  return discretize(forest, material, cube_supports());
}

}  // namespace

TEST_CASE("one refined cell in a block of eight: hanging nodes, masters and rows by hand", "[tjunctions]") {
  RefinementForest forest = box({2, 2, 2});
  forest.refine(0, {});
  const TjunctionCounts counts = count_tjunctions(forest, clamped(forest));
  // 19 new nodes. The cell's three inner faces hang: their centres, and 9 of the 12 edges, since three edges meet at
  // the block's corner and belong to no other cell.
  CHECK(counts.cells == 7 + 8);
  CHECK(counts.nodes == 27 + 19);
  CHECK(counts.hanging_nodes == 3 + 9);
  CHECK(counts.dofs == 3 * (46 - 12));
  CHECK(counts.hanging_cells == 7);     // all children but the one at the block's corner
  CHECK(counts.rows_touched == 3 * 7);  // all corners of the cell but that one
  CHECK(counts.chain_lengths == std::vector<int>{34, 12});
  CHECK(counts.longest_chain == 1);
}

TEST_CASE("one cell refined inside another: chains of two levels by hand", "[tjunctions]") {
  RefinementForest forest = box({2, 1, 1});
  forest.refine(0, {});
  const int child = forest.cell(0).first_child + 1;  // at x = 1/2 to 1, at the coarse cell and at the box's edge
  forest.refine(child, {});
  const Discretization d = clamped(forest);
  const TjunctionCounts counts = count_tjunctions(forest, d);
  // On the coarse cell hang 5 nodes of the first refinement and 5 of the second; on the child's sibling at x = 1/2
  // another 5. Of the two other siblings' faces the centres and three edges are new, and each has a master that hangs.
  CHECK(counts.nodes == 12 + 19 + 19);
  CHECK(counts.hanging_nodes == 20);
  CHECK(counts.chain_lengths == std::vector<int>{30, 15, 5});
  CHECK(counts.longest_chain == 2);
}

TEST_CASE("a cube of refined cells has the hanging nodes of its surface", "[tjunctions]") {
  // Fine nodes of the surface, 24 m² + 2, without the coarse ones, 6 m² + 2.
  for (const auto& [n, m] : {std::pair{4, 2}, std::pair{5, 3}, std::pair{6, 4}}) {
    const double share = std::pow(static_cast<double>(m) / n, 3);
    const RefinementForest forest = refined_forest({n, MarkingPattern::block, share, {}, 1, 1});
    const TjunctionCounts counts = count_tjunctions(forest, clamped(forest));
    CHECK(counts.hanging_nodes == 18 * m * m);
    CHECK(counts.nodes ==
          (n + 1) * (n + 1) * (n + 1) + (2 * m + 1) * (2 * m + 1) * (2 * m + 1) - (m + 1) * (m + 1) * (m + 1));
  }
}

TEST_CASE("chains found from the leaves are as long as those of T", "[tjunctions]") {
  for (const MarkingPattern pattern : marking_patterns)
    for (const RefinementTemplate& refinement : {RefinementTemplate{{2, 2, 2}}, RefinementTemplate{{2, 3, 3}}})
      for (const int levels : {1, 2, 3}) {
        CAPTURE(to_string(pattern), to_string(refinement), levels);
        const RefinementForest forest = refined_forest({3, pattern, 0.25, refinement, levels, 7});
        const Mesh mesh = forest.leaf_mesh();
        const HangingNodes hanging = find_hanging_nodes(forest, mesh);
        const std::vector<int> histogram = chain_histogram(chain_lengths(forest, mesh, hanging));
        CHECK(histogram[0] == hanging.reduced_count());
        CHECK(static_cast<int>(histogram.size()) - 1 == hanging.longest_chain);
      }
}

TEST_CASE("a pattern refines the share that is asked for, where it is asked for", "[tjunctions]") {
  for (const MarkingPattern pattern : marking_patterns) {
    const RefinementForest forest = refined_forest({6, pattern, 0.125, {}, 1, 3});
    int refined = 0;
    for (int cell = 0; cell < 216; ++cell) refined += !forest.is_leaf(cell);
    CHECK(refined == 27);
    CHECK(forest.leaf_count() == 216 + 27 * 7);
  }
  // Eight of the 64 cells: the block in the middle.
  const RefinementForest block = refined_forest({4, MarkingPattern::block, 0.125, {}, 1, 1});
  for (int cell = 0; cell < 64; ++cell) {
    const int x = cell % 4, y = cell / 4 % 4, z = cell / 16;
    const bool inner = x > 0 && x < 3 && y > 0 && y < 3 && z > 0 && z < 3;
    CHECK(block.is_leaf(cell) != inner);
  }
  const auto draw = [](unsigned seed) { return refined_forest({4, MarkingPattern::scattered, 0.2, {}, 1, seed}); };
  const auto same = [](const RefinementForest& a, const RefinementForest& b) {
    for (int cell = 0; cell < 64; ++cell)
      if (a.is_leaf(cell) != b.is_leaf(cell)) return false;
    return true;
  };
  CHECK(same(draw(1), draw(1)));
  CHECK_FALSE(same(draw(1), draw(2)));
  CHECK_THROWS_AS(refined_forest({4, MarkingPattern::block, 0.0, {}, 1, 1}), std::invalid_argument);
}

TEST_CASE("three ways to handle hanging nodes give one displacement", "[tjunctions]") {
  const RefinementForest forest = refined_forest({3, MarkingPattern::scattered, 0.3, {{2, 3, 3}}, 2, 1});
  const Discretization d = clamped(forest);
  REQUIRE(d.hanging.longest_chain == 2);
  Eigen::Matrix3Xd at(3, d.mesh.node_count());  // a body that is bent: rotations are not the identity
  for (Eigen::Index node = 0; node < at.cols(); ++node) {
    const Eigen::Vector3d X = d.mesh.nodes.col(node);
    at.col(node) = Eigen::Vector3d(0.0, 0.3 * (1.0 - X.x()) * (1.0 - X.x()), 0.1 * X.y());
  }
  const Eigen::Matrix3Xd conforming = expand(d.hanging, gather(d.hanging, at));
  const Eigen::Matrix3Xd loads = nodal_loads(forest.base(), d.mesh, cube_loads());
  const std::vector<HandlingCost> costs = compare_handlings(
      d, conforming, loads, {std::begin(tjunction_handlings), std::end(tjunction_handlings)}, {1, true, 1e-10, 50000});
  REQUIRE(costs.size() == 4);
  const HandlingCost &elementwise = costs[0], &product = costs[1], &multiplier = costs[2], &ignored = costs[3];
  for (const HandlingCost& cost : costs) CHECK(cost.solved);
  CHECK(elementwise.u.norm() > 0.0);
  CHECK(product.difference < 1e-11);
  CHECK(multiplier.difference < 1e-11);
  CHECK(ignored.difference > 1e-3);  // otherwise the others prove nothing

  // The independent solution: the core's own reduced system.
  BlockMatrix<double> A = assemble_stiffness(d, conforming);
  apply_supports(d.supports, A);
  Eigen::VectorXd b = reduce_forces(d.hanging, loads);
  project(d.supports, b);
  const DirectSolver solver(A);
  REQUIRE(solver.factored());
  CHECK((expand(d.hanging, solver.solve(b)) - elementwise.u).norm() < 1e-11 * elementwise.u.norm());
  CHECK(elementwise.factor_nonzeros == solver.factor_nonzeros());

  // Sizes by their definitions.
  const int nodes = d.mesh.node_count(), hanging = d.hanging.hanging_count();
  CHECK(elementwise.unknowns == 3 * (nodes - hanging));
  CHECK(product.unknowns == elementwise.unknowns);
  CHECK(multiplier.unknowns == 3 * (nodes + hanging));
  CHECK(ignored.unknowns == 3 * nodes);
  CHECK(product.matrix_nonzeros == elementwise.matrix_nonzeros);
  CHECK(product.factor_nonzeros == elementwise.factor_nonzeros);
  CHECK(std::abs(product.iterations - elementwise.iterations) <= 2 + elementwise.iterations / 50);
}

TEST_CASE("without hanging nodes the matrix of all nodes is the reduced one", "[tjunctions]") {
  const RefinementForest forest = box({2, 3, 2});
  const Discretization d = clamped(forest), free = unreduced(d);
  CHECK(free.pattern.column == d.pattern.column);
  CHECK(free.pattern.row_start == d.pattern.row_start);
  CHECK(free.scatter.positions == d.scatter.positions);
  const Eigen::Matrix3Xd rest = Eigen::Matrix3Xd::Zero(3, d.mesh.node_count());
  CHECK(assemble_stiffness(free, rest).values == assemble_stiffness(d, rest).values);
}

TEST_CASE("a factor's counts are those of a dense matrix where the matrix is dense", "[tjunctions]") {
  // One cell: 24 unknowns, all coupled. L has 24 · 25 / 2 nonzeros; column k of them takes k² flops.
  const Discretization d = clamped(box({1, 1, 1}));
  BlockMatrix<double> A = assemble_stiffness(d, Eigen::Matrix3Xd::Zero(3, 8));
  for (int i = 0; i < 8; ++i) A.block(d.pattern.diagonal[i]).diagonal().array() += 1e3;
  SparseFactor factor(to_sparse(A), SparseFactor::Kind::positive_definite);
  factor.analyze();
  CHECK(factor.factor_nonzeros() == 300.0);
  CHECK(factor.factor_flops() == 4900.0);
  REQUIRE(factor.factorize());
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(24, -1.0, 2.0), b = to_sparse(A) * x;
  CHECK((factor.solve(b) - x).norm() < 1e-12 * x.norm());
}

TEST_CASE("the conforming mesh of a run is as fine as its finest cells", "[tjunctions]") {
  RefinementForest forest = box({2, 1, 1});
  forest.refine(1, {{2, 3, 3}});
  forest.refine(forest.cell(1).first_child, {});
  const RefinementForest uniform = uniformly_refined_like(forest);
  CHECK(uniform.leaf_count() == 2 * 18 * 8);
  CHECK(find_hanging_nodes(uniform, uniform.leaf_mesh()).hanging_count() == 0);
}
