#include <Eigen/Geometry>

#include "core/elasticity/cell_geometry.hpp"
#include "core/mesh/refinement_forest.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/sample_cells.hpp"

using namespace finegauge;

namespace {

BaseMesh perturbed(BaseMesh mesh, double distortion, unsigned seed) {
  std::mt19937 generator(seed);
  for (int node = 0; node < mesh.nodes.cols(); ++node) mesh.nodes.col(node) += distortion * random_vector(generator);
  return mesh;
}

/// Largest relative difference between the entries and the cells' own geometry and stiffness.
double entry_error(const Mesh& mesh, const RestShapes& shapes) {
  double error = 0.0;
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    const CellGeometry geometry = cell_geometry(mesh.shape, corner_values(mesh, cell, mesh.nodes));
    const CellMatrix K = cell_stiffness(mesh.shape, geometry, shapes.material());
    RestShapes::Entry scratch;
    const RestShapes::CellView entry = shapes.entry(mesh, cell, scratch);
    CellGeometry geometry_scratch;
    const CellGeometry& alone = shapes.geometry(mesh, cell, geometry_scratch);
    error = std::max(error, (entry.stiffness - K).norm() / K.norm());
    error = std::max(error, std::abs(entry.geometry.volume - geometry.volume) / geometry.volume);
    error = std::max(error, (alone.gradients[0] - geometry.gradients[0]).norm() / geometry.gradients[0].norm());
  }
  return error;
}

}  // namespace

TEST_CASE("translates share one shape, at any place and size", "[shapes]") {
  const double size = GENERATE(1.0, 0.1, 7.0 / 3.0, 1e-5, 1e5);
  const double origin = GENERATE(0.0, 1.0, -0.7);
  CAPTURE(size, origin);
  BoxMeshOptions options;
  options.size.setConstant(size);
  options.origin.setConstant(origin * size);
  options.cells = {3, 5, 7};
  const Mesh mesh = RefinementForest(box_mesh(options)).leaf_mesh();
  const RestShapes shapes(mesh, Material{});
  CHECK(shapes.shared_count() == 1);
  CHECK_THAT(entry_error(mesh, shapes), WithinAbs(0.0, 1e-12));  // 2^-42 is 2e-13
}

TEST_CASE("the six tetrahedra of a lattice cell are the shapes of all", "[shapes]") {
  BoxMeshOptions options;
  options.cells = {3, 3, 3};
  options.shape = CellShape::tetrahedron;
  const Mesh mesh = RefinementForest(box_mesh(options)).leaf_mesh();
  const RestShapes shapes(mesh, Material{});
  CHECK(shapes.shared_count() == 6);
  CHECK_THAT(entry_error(mesh, shapes), WithinAbs(0.0, 1e-12));
}

TEST_CASE("each size of a refined box is one more shape", "[shapes]") {
  BoxMeshOptions options;
  options.cells = {3, 3, 3};
  RefinementForest forest(box_mesh(options));
  forest.refine(0, {{2, 2, 2}});
  forest.refine(5, {{1, 3, 1}});
  const Mesh mesh = forest.leaf_mesh();
  const RestShapes shapes(mesh, Material{});
  CHECK(shapes.shared_count() == 3);
  CHECK_THAT(entry_error(mesh, shapes), WithinAbs(0.0, 1e-12));
}

TEST_CASE("cells of their own shape are computed on use and not kept", "[shapes]") {
  BoxMeshOptions options;
  options.cells = {3, 3, 3};
  const Mesh mesh = RefinementForest(perturbed(box_mesh(options), 0.05, 31)).leaf_mesh();
  const RestShapes shapes(mesh, Material{});
  CHECK(shapes.shared_count() == 0);
  CHECK(entry_error(mesh, shapes) == 0.0);
}

TEST_CASE("shapes that differ by more than round-off are kept apart", "[shapes]") {
  BoxMeshOptions options;
  options.cells = {2, 1, 1};
  BaseMesh base = box_mesh(options);
  base.nodes.col(0).x() -= 1e-10;
  const Mesh mesh = RefinementForest(base).leaf_mesh();
  CHECK(RestShapes(mesh, Material{}).shared_count() == 0);
}
