#include "core/space/assembly.hpp"

#include <Eigen/Eigenvalues>

#include "verification/support/catch.hpp"
#include "verification/support/refinement_history.hpp"
#include "verification/support/sample_cells.hpp"
#include "verification/support/scrambled_mesh.hpp"

using namespace finegauge;

namespace {

struct AssemblyCase {
  CellShape shape;
  Dilatation dilatation;
  Kinematics kinematics;
};
const std::array<AssemblyCase, 6> cases = {{
    {CellShape::hexahedron, Dilatation::standard, Kinematics::linear},
    {CellShape::hexahedron, Dilatation::mean, Kinematics::linear},
    {CellShape::hexahedron, Dilatation::standard, Kinematics::corotational},
    {CellShape::hexahedron, Dilatation::mean, Kinematics::corotational},
    {CellShape::tetrahedron, Dilatation::standard, Kinematics::linear},
    {CellShape::tetrahedron, Dilatation::standard, Kinematics::corotational},
}};

Discretization hanging_discretization(const AssemblyCase& c, int refinements, std::mt19937& generator,
                                      const std::vector<SupportCondition>& supports = {}) {
  BoxMeshOptions options;
  options.cells = c.shape == CellShape::hexahedron ? std::array{2, 2, 1} : std::array{1, 1, 1};
  options.shape = c.shape;
  RefinementForest forest(scrambled(distorted_box(options, 0.1, generator), generator));
  const auto templates = all_templates(c.shape);
  refine_randomly(forest, {templates, refinements, 3, 300}, generator);
  Material material;
  material.youngs_modulus = 10.0;
  material.poisson_ratio = 0.4;
  material.dilatation = c.dilatation;
  material.kinematics = c.kinematics;
  Discretization d = discretize(forest, material, supports);
  REQUIRE(d.hanging.hanging_count() > 0);
  return d;
}

Eigen::Matrix3Xd random_displacement(const Discretization& d, double size, std::mt19937& generator) {
  Eigen::VectorXd reduced(d.dof_count());
  for (double& value : reduced) value = size * random_number(generator);
  return expand(d.hanging, reduced);
}

}  // namespace

TEST_CASE("the assembled stiffness is the explicit product with T", "[assembly]") {
  const auto k = GENERATE(range(0, static_cast<int>(cases.size())));
  const auto seed = GENERATE(1u, 2u, 3u);
  CAPTURE(k, seed);
  std::mt19937 generator(seed);
  const Discretization d = hanging_discretization(cases[k], 8, generator);
  const Eigen::Matrix3Xd u = random_displacement(d, 0.2, generator);
  const BlockMatrix<double> A = assemble_stiffness(d, u);
  const Eigen::SparseMatrix<double> T = interpolation_matrix(d.hanging);
  const Eigen::SparseMatrix<double> oracle = T.transpose() * (nodal_stiffness(d, u) * T).eval();
  const Eigen::SparseMatrix<double> assembled = to_sparse(A);
  CHECK((assembled - oracle).norm() <= 1e-13 * oracle.norm());
  // The padding after the last block is never written.
  CHECK(std::all_of(A.values.end() - 4, A.values.end(), [](double value) { return value == 0.0; }));

  Eigen::VectorXd x(d.dof_count()), y;
  for (double& value : x) value = random_number(generator);
  multiply(A, x, y);
  CHECK((y - assembled * x).norm() <= 1e-14 * assembled.norm() * x.norm());
}

TEST_CASE("the frozen-rotation tangent turns with the cells", "[assembly]") {
  // At a rigid rotation Q every cell's stiffness is Q K Qᵀ, so the whole matrix is.
  const auto dilatation = GENERATE(Dilatation::standard, Dilatation::mean);
  std::mt19937 generator(4);
  const Discretization d =
      hanging_discretization({CellShape::hexahedron, dilatation, Kinematics::corotational}, 6, generator);
  const Eigen::Matrix3d Q = turn_about_random_axis(2.0, generator);
  const Eigen::Matrix3Xd turned = Q * d.mesh.nodes - d.mesh.nodes;
  const BlockMatrix<double> at_rest = assemble_stiffness(d, Eigen::Matrix3Xd::Zero(3, d.mesh.node_count()));
  const BlockMatrix<double> rotated = assemble_stiffness(d, turned);
  double error = 0.0, size = 0.0;
  for (int p = 0; p < d.pattern.block_count(); ++p) {
    error = std::max(error, (rotated.block(p) - Q * at_rest.block(p) * Q.transpose()).norm());
    size = std::max(size, at_rest.block(p).norm());
  }
  CHECK(error <= 1e-12 * size);
  // Which is a different matrix, and a rigid rotation has no force and no energy.
  CHECK((to_sparse(rotated) - to_sparse(at_rest)).norm() >= 0.1 * to_sparse(at_rest).norm());
  CHECK(internal_forces(d, turned).norm() <= 1e-12 * size);
  CHECK(std::abs(strain_energy_product(d, turned)) <= 1e-24 * size);
}

TEST_CASE("what T leaves free of forces are the six rigid motions", "[assembly][rigid]") {
  const auto k = GENERATE(range(0, static_cast<int>(cases.size())));
  if (cases[k].kinematics != Kinematics::linear) return;
  CAPTURE(k);
  std::mt19937 generator(5);
  const Discretization d = hanging_discretization(cases[k], 3, generator);
  REQUIRE(d.dof_count() < 1500);
  const Eigen::Matrix3Xd rest = Eigen::Matrix3Xd::Zero(3, d.mesh.node_count());
  const Eigen::MatrixXd A = Eigen::MatrixXd(to_sparse(assemble_stiffness(d, rest)));
  CHECK((A - A.transpose()).norm() <= 1e-14 * A.norm());
  const Eigen::VectorXd lambda =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(A, Eigen::EigenvaluesOnly).eigenvalues();
  const double largest = lambda[lambda.size() - 1];
  CHECK(lambda.head<6>().cwiseAbs().maxCoeff() <= 1e-12 * largest);
  CHECK(lambda[6] >= 1e-7 * largest);
  // And they are the rigid ones: a translation and a linearized rotation about each axis.
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::Matrix3Xd motion = Eigen::Matrix3Xd::Zero(3, d.mesh.node_count());
    motion.row(axis).setOnes();
    CHECK((A * gather(d.hanging, motion)).norm() <= 1e-12 * largest);
    for (int node = 0; node < d.mesh.node_count(); ++node)
      motion.col(node) = Eigen::Vector3d::Unit(axis).cross(d.mesh.nodes.col(node));
    CHECK((A * gather(d.hanging, motion)).norm() <= 1e-11 * largest);
  }
}

TEST_CASE("internal forces of a linear body are K u, and their work is the energy", "[assembly]") {
  const auto k = GENERATE(0, 1, 4);
  std::mt19937 generator(6);
  const Discretization d = hanging_discretization(cases[k], 6, generator);
  const Eigen::Matrix3Xd u = random_displacement(d, 0.2, generator);
  const Eigen::VectorXd Ku = nodal_stiffness(d, u) * u.reshaped();
  CHECK((internal_forces(d, u).reshaped() - Ku).norm() <= 1e-13 * Ku.norm());
  CHECK_THAT(strain_energy_product(d, u), WithinRel(Ku.dot(u.reshaped()), 1e-12));
}

TEST_CASE("the frozen-rotation tangent is the derivative of the forces with the rotations held", "[assembly]") {
  // Of a body at a rigid rotation the rotations' own change costs nothing: there the full derivative is the tangent.
  const auto k = GENERATE(2, 3, 5);
  CAPTURE(k);
  std::mt19937 generator(7);
  const Discretization d = hanging_discretization(cases[k], 6, generator);
  const Eigen::Matrix3d Q = turn_about_random_axis(1.2, generator);
  const Eigen::Matrix3Xd u = Q * d.mesh.nodes - d.mesh.nodes;
  const Eigen::Matrix3Xd direction = random_displacement(d, 1.0, generator);
  const double step = 1e-6;  // central differences: error step² ~ 1e-12 and round-off 1e-16 / step ~ 1e-10
  const Eigen::Matrix3Xd slope =
      (internal_forces(d, u + step * direction) - internal_forces(d, u - step * direction)) / (2.0 * step);
  const Eigen::VectorXd tangent = nodal_stiffness(d, u) * direction.reshaped();
  CHECK((slope.reshaped() - tangent).norm() <= 1e-6 * tangent.norm());
}

TEST_CASE("supports leave the free block alone and decouple what is held", "[assembly]") {
  std::mt19937 generator(8);
  const std::vector<SupportCondition> supports = {{"x_min", {}, {}}, {"z_max", Eigen::Vector3d(1.0, 2.0, 2.0), {}}};
  const Discretization d = hanging_discretization(cases[1], 6, generator, supports);
  const BlockMatrix<double> A = assemble_stiffness(d, Eigen::Matrix3Xd::Zero(3, d.mesh.node_count()));
  BlockMatrix<double> held = A;
  apply_supports(d.supports, held);
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(d.dof_count(), d.dof_count()), kappa = H;
  REQUIRE(d.supports.reduced.size() > 4);
  for (std::size_t s = 0; s < d.supports.reduced.size(); ++s) {
    const int i = d.supports.reduced[s];
    H.block<3, 3>(3 * i, 3 * i) = d.supports.held[s];
    kappa.block<3, 3>(3 * i, 3 * i) = A.block(d.pattern.diagonal[i]).trace() / 3.0 * d.supports.held[s];
  }
  const Eigen::MatrixXd Z = Eigen::MatrixXd::Identity(d.dof_count(), d.dof_count()) - H;
  const Eigen::MatrixXd oracle = Z * Eigen::MatrixXd(to_sparse(A)) * Z + kappa;
  CHECK((Eigen::MatrixXd(to_sparse(held)) - oracle).norm() <= 1e-14 * oracle.norm());
}
