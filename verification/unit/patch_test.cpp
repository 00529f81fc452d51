#include "core/elasticity/cell_response.hpp"
#include "core/equilibrium.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/refinement_history.hpp"
#include "verification/support/sample_cells.hpp"
#include "verification/support/scrambled_mesh.hpp"

using namespace finegauge;

namespace {

/// The field of MacNeal & Harder (1985), solid patch test: all strains 1e-3, engineering shears too.
Eigen::Vector3d linear_field(const Eigen::Vector3d& X) {
  return 0.5e-3 *
         Eigen::Vector3d(2.0 * X.x() + X.y() + X.z(), X.x() + 2.0 * X.y() + X.z(), X.x() + X.y() + 2.0 * X.z());
}

Material patch_material(Dilatation dilatation) {
  Material material;
  material.youngs_modulus = 1e6;
  material.poisson_ratio = 0.25;
  material.dilatation = dilatation;
  return material;
}

std::vector<SupportCondition> linear_on_all_surfaces(const BaseMesh& base) {
  std::vector<SupportCondition> supports;
  for (const auto& [name, faces] : base.surfaces) supports.push_back({name, {}, linear_field});
  return supports;
}

struct PatchResult {
  bool converged;
  int hanging, free_nodes, levels;
  double displacement_error, stress_error;  ///< relative, the largest of all nodes and quadrature points
};

PatchResult run_patch(const RefinementForest& forest, Dilatation dilatation, LinearMethod method) {
  const auto supports = linear_on_all_surfaces(forest.base());
  const Discretization d = discretize(forest, patch_material(dilatation), supports);
  const MeshHierarchy hierarchy = build_hierarchy(forest, d, supports, {10, 0.99});
  const Eigen::Matrix3Xd none = Eigen::Matrix3Xd::Zero(3, d.mesh.node_count());
  EquilibriumOptions options;
  options.method = method;
  // Of the force that the prescribed displacements alone would cause, which in small cells is a hundred times what the
  // strain causes: one digit more than for a load.
  options.linear = {1e-13, 500};
  const Equilibrium equilibrium = solve_equilibrium(d, hierarchy, none, none, options);
  PatchResult result{equilibrium.converged,
                     d.hanging.hanging_count(),
                     d.hanging.reduced_count() - static_cast<int>(d.supports.reduced.size()),
                     static_cast<int>(hierarchy.coarse.size()),
                     0.0,
                     0.0};
  double largest = 0.0;
  for (int node = 0; node < d.mesh.node_count(); ++node) {
    const Eigen::Vector3d exact = linear_field(d.mesh.nodes.col(node));
    largest = std::max(largest, exact.norm());
    result.displacement_error = std::max(result.displacement_error, (equilibrium.u.col(node) - exact).norm());
  }
  result.displacement_error /= largest;
  const Voigt exact = (Voigt() << 2000.0, 2000.0, 2000.0, 400.0, 400.0, 400.0).finished();
  RestShapes::Entry scratch;
  for (int cell = 0; cell < d.mesh.cell_count(); ++cell) {
    const auto stress =
        quadrature_stress(d.mesh.shape, d.shapes.entry(d.mesh, cell, scratch).geometry, d.shapes.material(),
                          Eigen::Matrix3d::Identity(), corner_values(d.mesh, cell, equilibrium.u));
    for (int q = 0; q < quadrature_count(d.mesh.shape); ++q)
      result.stress_error = std::max(result.stress_error, (stress.col(q) - exact).cwiseAbs().maxCoeff() / 2000.0);
  }
  return result;
}

void check_patch(const PatchResult& result, LinearMethod method) {
  CHECK(result.converged);
  CHECK(result.hanging > 0);
  CHECK(result.free_nodes > 0);
  if (method == LinearMethod::multigrid) CHECK(result.levels > 0);
  CHECK_THAT(result.displacement_error, WithinAbs(0.0, 1e-10));
  CHECK_THAT(result.stress_error, WithinAbs(0.0, 1e-10));
}

/// Cells of MacNeal and Harder's patch whose Jacobian is negative at a corner.
std::vector<int> cells_with_negative_corner(const BaseMesh& mesh) {
  std::vector<int> found;
  for (int cell = 0; cell < static_cast<int>(mesh.cells.size()); ++cell) {
    bool negative = false;
    for (int c = 0; c < 8; ++c) {
      const auto dN = shape_gradients(mesh.shape, Eigen::Vector3d(c & 1, (c >> 1) & 1, (c >> 2) & 1));
      Eigen::Matrix3d J = Eigen::Matrix3d::Zero();
      for (int a = 0; a < 8; ++a) J += mesh.nodes.col(mesh.cells[cell][a]) * dN.col(a).transpose();
      negative = negative || J.determinant() < 0.0;
    }
    if (negative) found.push_back(cell);
  }
  return found;
}

const auto methods = {LinearMethod::direct, LinearMethod::multigrid};

}  // namespace

TEST_CASE("MacNeal and Harder's patch of seven cells has constant stress", "[patch]") {
  const auto dilatation = GENERATE(Dilatation::standard, Dilatation::mean);
  const BaseMesh base = macneal_harder_patch();
  REQUIRE(validate(base).empty());
  const PatchResult result = run_patch(RefinementForest(base), dilatation, LinearMethod::direct);
  CHECK(result.converged);
  CHECK(result.free_nodes == 8);
  CHECK_THAT(result.displacement_error, WithinAbs(0.0, 1e-12));
  CHECK_THAT(result.stress_error, WithinAbs(0.0, 1e-12));
}

TEST_CASE("the patch's cell with a negative corner stays exact, though three levels down a weight is negative",
          "[patch][hanging]") {
  // Weights are signed, so that integrals over the leaves add up to the body's; while the inverted corner is small
  // against its neighbours the matrix stays positive definite.
  const auto dilatation = GENERATE(Dilatation::standard, Dilatation::mean);
  RefinementForest forest(macneal_harder_patch());
  const int negative = cells_with_negative_corner(forest.base()).at(0);
  std::vector<int> cells = {negative};
  for (int level = 0; level < 3; ++level) {
    for (const int cell : cells) forest.refine(cell, {{2, 2, 2}});
    cells.clear();
    for (const int leaf : leaves(forest))
      if (forest.cell(leaf).base == negative) cells.push_back(leaf);
  }
  REQUIRE(cells.size() == 512);
  const Mesh mesh = forest.leaf_mesh();
  int negative_weights = 0;
  for (int cell = 0; cell < mesh.cell_count(); ++cell)
    for (const double weight : cell_geometry(mesh.shape, corner_values(mesh, cell, mesh.nodes)).weights)
      negative_weights += weight < 0.0;
  CHECK(negative_weights > 0);
  for (const LinearMethod method : methods) check_patch(run_patch(forest, dilatation, method), method);
}

TEST_CASE("a constant stress is exact across hanging nodes of every template", "[patch][hanging]") {
  const auto templates = all_templates();
  const auto k = GENERATE(range(0, 63));
  std::mt19937 generator(static_cast<unsigned>(k));
  const auto& refinement = templates[k];
  CAPTURE(to_string(refinement));
  RefinementForest forest(scrambled(macneal_harder_patch(), generator));
  forest.refine(0, refinement);
  // A neighbour by another template, and one of the first cell's children again.
  forest.refine(1 + k % 6, templates[(11 * k + 5) % templates.size()]);
  forest.refine(forest.cell(0).first_child, templates[(5 * k + 17) % templates.size()]);
  for (const LinearMethod method : methods)
    check_patch(run_patch(forest, k % 2 ? Dilatation::mean : Dilatation::standard, method), method);
}

TEST_CASE("a constant stress is exact in random mixtures nested three levels", "[patch][hanging]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const auto seed = GENERATE(range(1u, 6u));
  const auto dilatation = GENERATE(Dilatation::standard, Dilatation::mean);
  CAPTURE(static_cast<int>(shape), seed);
  std::mt19937 generator(seed);
  BoxMeshOptions options;
  options.cells = shape == CellShape::hexahedron ? std::array{3, 2, 2} : std::array{2, 2, 2};
  options.shape = shape;
  RefinementForest forest(scrambled(distorted_box(options, 0.2, generator), generator));
  const auto templates = all_templates(shape);
  int leaf = 0;
  for (int level = 0; level < 3; ++level) {
    const auto& refinement = templates[generator() % templates.size()];
    forest.refine(leaf, refinement);
    leaf = forest.cell(leaf).first_child + static_cast<int>(generator() % refinement.child_count());
  }
  refine_randomly(forest, {templates, 12, 3, 600}, generator);
  for (const LinearMethod method : methods) check_patch(run_patch(forest, dilatation, method), method);
}
