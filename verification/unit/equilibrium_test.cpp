#include "core/equilibrium.hpp"

#include <cmath>
#include <numbers>

#include "verification/support/catch.hpp"
#include "verification/support/refinement_history.hpp"
#include "verification/support/sample_cells.hpp"
#include "verification/support/scrambled_mesh.hpp"

using namespace finegauge;

namespace {

Material soft(Kinematics kinematics) {
  Material material;
  material.youngs_modulus = 1e6;
  material.poisson_ratio = 0.3;
  material.dilatation = Dilatation::mean;
  material.kinematics = kinematics;
  return material;
}

/// A cantilever of 0.5 m by 0.05 m by 0.05 m, clamped where x = 0.
BaseMesh beam(std::array<int, 3> cells, CellShape shape = CellShape::hexahedron) {
  BoxMeshOptions options;
  options.size = {0.5, 0.05, 0.05};
  options.cells = cells;
  options.shape = shape;
  return box_mesh(options);
}

struct Problem {
  RefinementForest forest;
  Discretization d;
  MeshHierarchy hierarchy;
  Eigen::Matrix3Xd loads;

  Problem(RefinementForest refined, const Material& material, const std::vector<SupportCondition>& supports,
          const std::vector<SurfaceLoad>& surface_loads)
      : forest(std::move(refined)),
        d(discretize(forest, material, supports)),
        hierarchy(build_hierarchy(forest, d, supports, {40, 0.9})),
        loads(nodal_loads(forest.base(), d.mesh, surface_loads)) {}

  Eigen::Matrix3Xd rest() const { return Eigen::Matrix3Xd::Zero(3, d.mesh.node_count()); }
  Equilibrium solve(const Eigen::Matrix3Xd& start, const EquilibriumOptions& options = {}) const {
    return solve_equilibrium(d, hierarchy, loads, start, options);
  }
};

const std::vector<SupportCondition> clamped_left = {{"x_min", {}, {}}};
std::vector<SurfaceLoad> end_force(const Eigen::Vector3d& force) { return {{"x_max", LoadKind::total_by_area, force}}; }

/// Mean displacement of the nodes on the end face of an unrotated beam, weighted equally.
Eigen::Vector3d end_displacement(const Problem& problem, const Eigen::Matrix3Xd& u) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (int node = 0; node < problem.d.mesh.node_count(); ++node)
    if (problem.d.mesh.nodes(0, node) > 0.5 - 1e-9) {
      sum += u.col(node);
      ++count;
    }
  return sum / count;
}

/// End of the inextensible elastica under a dead force across it, load = F L² / (E I): deflection and shortening over
/// L. Shooting for theta'' = -load cos theta, theta(0) = 0, theta'(1) = 0, by bisection on theta'(0).
struct Elastica {
  double deflection, shortening;
};
Elastica elastica(double load) {
  struct End {
    double curvature;
    Elastica place;
  };
  const auto shoot = [&](double curvature) {
    constexpr int steps = 2000;
    constexpr double h = 1.0 / steps;
    double theta = 0.0, w = 0.0, x = 0.0;
    for (int k = 0; k < steps; ++k) {  // leapfrog, second order
      const double middle = theta + 0.5 * h * curvature;
      w += h * std::sin(middle);
      x += h * std::cos(middle);
      curvature -= h * load * std::cos(middle);
      theta = middle + 0.5 * h * curvature;
    }
    return End{curvature, {w, 1.0 - x}};
  };
  double low = 0.0, high = load;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (shoot(middle).curvature < 0.0 ? low : high) = middle;
  }
  return shoot(low).place;
}

}  // namespace

TEST_CASE("the elastica that cantilevers are held against is the known one", "[equilibrium]") {
  // Batista 2016: F L² / (E I) = 1.
  CHECK_THAT(elastica(1.0).deflection, WithinAbs(0.3017207738, 1e-6));
  CHECK_THAT(elastica(1.0).shortening, WithinAbs(0.0564332363, 1e-6));
}

TEST_CASE("a cantilever bends by a large angle as the elastica does", "[equilibrium][corotational]") {
  const double force = GENERATE(4.0, 8.0, 16.0);
  CAPTURE(force);
  const Problem problem(RefinementForest(beam({40, 2, 2})), soft(Kinematics::corotational), clamped_left,
                        end_force({0.0, 0.0, -force}));
  const Equilibrium found = problem.solve(problem.rest());
  CHECK(found.converged);
  CHECK(found.relative_residual <= 1e-8);
  CHECK(found.newton_iterations <= 40);
  CHECK(found.newton_iterations >= 4);
  const Elastica exact = elastica(force * 0.25 / (1e6 * std::pow(0.05, 4) / 12.0));
  const Eigen::Vector3d end = end_displacement(problem, found.u) / 0.5;
  // Two cells through the depth: bending is off by a few percent; shear and stretch, left out by the elastica, by less.
  CHECK_THAT(-end.z(), WithinRel(exact.deflection, 0.04));
  CHECK_THAT(-end.x(), WithinRel(exact.shortening, 0.08));
  CHECK_THAT(end.y(), WithinAbs(0.0, 1e-6));
  if (force == 8.0) CHECK(exact.deflection > 0.65);  // as large as that
  // The solution is one: from another start the same.
  const Problem half(RefinementForest(beam({40, 2, 2})), soft(Kinematics::corotational), clamped_left,
                     end_force({0.0, 0.0, -0.5 * force}));
  const Equilibrium again = problem.solve(half.solve(half.rest()).u);
  CHECK(again.converged);
  CHECK((again.u - found.u).norm() <= 1e-5 * found.u.norm());
}

TEST_CASE("large bending converges on hanging meshes, tetrahedra, and with either solver",
          "[equilibrium][corotational]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const auto method = GENERATE(LinearMethod::direct, LinearMethod::multigrid);
  RefinementForest forest(beam({10, 1, 1}, shape));
  for (int cell = 0; cell < static_cast<int>(forest.base().cells.size()) / 2; ++cell) forest.refine(cell, {{2, 2, 2}});
  const Problem problem(std::move(forest), soft(Kinematics::corotational), clamped_left, end_force({0.0, 2.0, -8.0}));
  REQUIRE(problem.d.hanging.hanging_count() > 0);
  REQUIRE_FALSE(problem.hierarchy.coarse.empty());
  EquilibriumOptions options;
  options.method = method;
  const Equilibrium found = problem.solve(problem.rest(), options);
  CHECK(found.converged);
  CHECK(found.newton_iterations <= 40);
  CHECK(end_displacement(problem, found.u).norm() > 0.1);
}

TEST_CASE("a superposed rotation of the clamped end and the load turns the solution", "[equilibrium][objectivity]") {
  const double angle = GENERATE(10.0, 90.0, 180.0) * std::numbers::pi / 180.0;
  const int axis = GENERATE(0, 1, 2, 3);
  CAPTURE(angle, axis);
  std::mt19937 generator(static_cast<unsigned>(axis));
  const Eigen::Matrix3d Q = axis < 3 ? Eigen::AngleAxisd(angle, Eigen::Vector3d::Unit(axis)).toRotationMatrix()
                                     : turn_about_random_axis(angle, generator);
  RefinementForest forest(beam({10, 1, 1}));
  forest.refine(0, {{2, 2, 2}});
  const Eigen::Vector3d force(0.1, 0.5, -4.0);
  const Problem straight(forest, soft(Kinematics::corotational), clamped_left, end_force(force));
  const std::vector<SupportCondition> turned_clamp = {
      {"x_min", {}, [Q](const Eigen::Vector3d& X) { return Eigen::Vector3d(Q * X - X); }}};
  const Problem turned(forest, soft(Kinematics::corotational), turned_clamp, end_force(Q * force));
  EquilibriumOptions options;
  options.newton_residual = 1e-12;
  options.newton_iterations = 100;
  const Equilibrium reference = straight.solve(straight.rest(), options);
  const Eigen::Matrix3Xd& X = straight.d.mesh.nodes;
  const Equilibrium found = turned.solve(Q * X - X, options);
  REQUIRE(reference.converged);
  REQUIRE(found.converged);
  CHECK(reference.u.cwiseAbs().maxCoeff() > 0.1);
  const Eigen::Matrix3Xd expected = Q * (X + reference.u) - X;
  CHECK((found.u - expected).norm() <= 1e-8 * reference.u.norm());
  CHECK_THAT(found.energy, WithinRel(reference.energy, 1e-9));
}

TEST_CASE("a clamped end turned by a right angle carries an unloaded body along", "[equilibrium][objectivity]") {
  const double angle = GENERATE(10.0, 45.0, 90.0) * std::numbers::pi / 180.0;
  CAPTURE(angle);
  const Eigen::Matrix3d Q = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY()).toRotationMatrix();
  const std::vector<SupportCondition> turned_clamp = {
      {"x_min", {}, [Q](const Eigen::Vector3d& X) { return Eigen::Vector3d(Q * X - X); }}};
  const Problem problem(RefinementForest(beam({10, 1, 1})), soft(Kinematics::corotational), turned_clamp, {});
  EquilibriumOptions options;
  options.newton_iterations = 100;
  const Equilibrium found = problem.solve(problem.rest(), options);
  CHECK(found.converged);
  const Eigen::Matrix3Xd& X = problem.d.mesh.nodes;
  CHECK((found.u - (Q * X - X)).norm() <= 1e-6 * found.u.norm());
  // From there again: without any force nothing but round-off is left, and that counts as converged.
  const Equilibrium again = problem.solve(Q * X - X, options);
  CHECK(again.converged);
  CHECK(again.newton_iterations <= 1);
}

TEST_CASE("an iteration that does not converge says so", "[equilibrium]") {
  const Problem problem(RefinementForest(beam({10, 1, 1})), soft(Kinematics::corotational), clamped_left,
                        end_force({0.0, 0.0, -8.0}));
  EquilibriumOptions options;
  options.newton_iterations = GENERATE(1, 3);
  const Equilibrium found = problem.solve(problem.rest(), options);
  CHECK_FALSE(found.converged);
  CHECK(found.newton_iterations == options.newton_iterations);
  CHECK(found.relative_residual > 1e-8);
  CHECK(found.u.allFinite());
}

TEST_CASE("a linear solve that runs out of iterations says so", "[equilibrium]") {
  const auto kinematics = GENERATE(Kinematics::linear, Kinematics::corotational);
  RefinementForest forest(beam({10, 1, 1}));
  for (const int leaf : leaves(forest)) forest.refine(leaf, {{2, 2, 2}});
  const Problem problem(std::move(forest), soft(kinematics), clamped_left, end_force({0.0, 0.0, -1.0}));
  EquilibriumOptions options;
  options.method = LinearMethod::multigrid;
  options.linear.iterations = 2;
  const Equilibrium found = problem.solve(problem.rest(), options);
  CHECK_FALSE(found.converged);
  CHECK(found.linear_iterations == 2);
}

TEST_CASE("a direct solve that round-off keeps from the residual asked for says so", "[equilibrium]") {
  const Problem problem(RefinementForest(beam({40, 2, 2})), soft(Kinematics::linear), clamped_left,
                        end_force({0.0, 0.0, -1.0}));
  EquilibriumOptions options;
  options.method = LinearMethod::direct;
  options.linear.relative_residual = 1e-9;
  const Equilibrium found = problem.solve(problem.rest(), options);
  CHECK(found.converged);
  CHECK(found.relative_residual <= 1e-9);
  options.linear.relative_residual = 1e-15;  // round-off allows some 1e-12
  const Equilibrium impossible = problem.solve(problem.rest(), options);
  CHECK_FALSE(impossible.converged);
  CHECK(impossible.relative_residual > 1e-15);
  CHECK(impossible.relative_residual < 1e-9);
  CHECK((impossible.u - found.u).norm() <= 1e-6 * found.u.norm());
}

TEST_CASE("a body whose stresses are in units that are powers of two apart moves by the same bits", "[equilibrium]") {
  const auto method = GENERATE(LinearMethod::direct, LinearMethod::multigrid);
  const auto kinematics = GENERATE(Kinematics::linear, Kinematics::corotational);
  // Moduli and loads by 2^stress; odd ones too, whose root is no power of two.
  const auto solve = [&](int stress) {
    RefinementForest forest(beam({10, 2, 2}));
    for (int cell = 0; cell < 20; ++cell) forest.refine(cell, {{2, 2, 2}});
    Material material = soft(kinematics);
    material.youngs_modulus = std::ldexp(material.youngs_modulus, stress);
    const Eigen::Vector3d force = std::ldexp(1.0, stress) * Eigen::Vector3d(0.1, 0.5, -2.0);
    const Problem problem(std::move(forest), material, clamped_left, end_force(force));
    REQUIRE(problem.d.hanging.hanging_count() > 0);
    EquilibriumOptions options;
    options.method = method;
    const Equilibrium found = problem.solve(problem.rest(), options);
    CHECK(found.converged);
    return found.u;
  };
  const Eigen::Matrix3Xd u = solve(0);
  CHECK(u.cwiseAbs().maxCoeff() > 0.01);
  const bool same = solve(21) == u, small = solve(-15) == u, even = solve(8) == u;  // not in CHECK: it would print u
  CHECK(same);
  CHECK(small);
  CHECK(even);
}

TEST_CASE("the cache keeps the factor of the base mesh, and none of a mesh that will change", "[equilibrium]") {
  EquilibriumOptions options;
  options.method = LinearMethod::direct;
  const auto load = end_force({0.0, 0.0, -0.1});
  const Problem base(RefinementForest(beam({10, 1, 1})), soft(Kinematics::linear), clamped_left, load);
  REQUIRE(base.hierarchy.coarse.empty());
  RefinementForest forest(beam({10, 1, 1}));
  for (const int leaf : leaves(forest)) forest.refine(leaf, {{2, 2, 2}});
  const Problem fine(std::move(forest), soft(Kinematics::linear), clamped_left, load);
  REQUIRE_FALSE(fine.hierarchy.coarse.empty());
  const auto matrix_of = [](const Problem& problem) {
    BlockMatrix<double> A = assemble_stiffness(problem.d, problem.rest());
    apply_supports(problem.d.supports, A);
    return A;
  };
  FactorCache factors;
  CHECK(solve_equilibrium(base.d, base.hierarchy, base.loads, base.rest(), options, &factors).converged);
  const auto kept = factors.factor(matrix_of(base));
  CHECK(kept.use_count() == 2);  // the cache's and this one
  CHECK(solve_equilibrium(fine.d, fine.hierarchy, fine.loads, fine.rest(), options, &factors).converged);
  CHECK(factors.factor(matrix_of(base)) == kept);
}

TEST_CASE("the solution of a linear body does not depend on the start", "[equilibrium]") {
  const auto method = GENERATE(LinearMethod::direct, LinearMethod::multigrid);
  std::mt19937 generator(3);
  RefinementForest forest(beam({10, 1, 1}));
  for (int cell = 0; cell < 5; ++cell) forest.refine(cell, {{2, 2, 2}});
  const std::vector<SupportCondition> supports = {
      {"x_min", {}, [](const Eigen::Vector3d& X) { return Eigen::Vector3d(0.01 * X.z(), 0.0, 0.002); }}};
  const Problem problem(std::move(forest), soft(Kinematics::linear), supports, end_force({0.1, 0.2, -0.3}));
  EquilibriumOptions options;
  options.method = method;
  options.linear = {1e-12, 500};
  const Equilibrium reference = problem.solve(problem.rest(), options);
  REQUIRE(reference.converged);
  CHECK(reference.newton_iterations == 1);
  Eigen::VectorXd reduced(problem.d.dof_count());
  for (double& value : reduced) value = 0.05 * random_number(generator);
  const Equilibrium found = problem.solve(expand(problem.d.hanging, reduced), options);
  CHECK(found.converged);
  CHECK((found.u - reference.u).norm() <= 1e-8 * reference.u.norm());
  CHECK_THAT(found.energy, WithinRel(reference.energy, 1e-8));
  // A start that is the solution costs nothing to speak of.
  const Equilibrium again = problem.solve(reference.u, options);
  CHECK(again.converged);
  CHECK(again.linear_iterations <= 2);
}

TEST_CASE("twice the stored energy is the work of the loads on a linear body", "[equilibrium]") {
  const Problem problem(RefinementForest(beam({10, 2, 2})), soft(Kinematics::linear), clamped_left,
                        end_force({0.1, 0.2, -0.3}));
  const Equilibrium found = problem.solve(problem.rest());
  CHECK(found.converged);
  CHECK(found.energy > 0.0);
  CHECK_THAT(found.energy, WithinRel(problem.loads.cwiseProduct(found.u).sum(), 1e-10));
  CHECK_THAT(found.energy, WithinRel(strain_energy_product(problem.d, found.u), 1e-10));
}

TEST_CASE("small loads bend a corotational body as a linear one", "[equilibrium][corotational]") {
  const auto load = end_force({0.0, 0.0, -1e-5});
  const Problem linear(RefinementForest(beam({10, 2, 2})), soft(Kinematics::linear), clamped_left, load);
  const Problem corotational(RefinementForest(beam({10, 2, 2})), soft(Kinematics::corotational), clamped_left, load);
  const Equilibrium a = linear.solve(linear.rest()), b = corotational.solve(corotational.rest());
  CHECK(b.converged);
  // The turn of the end is 2e-6.
  CHECK((a.u - b.u).norm() <= 1e-5 * a.u.norm());
  CHECK((a.u - b.u).norm() > 0.0);
}

TEST_CASE("an inclined support plane is the turned problem", "[equilibrium][support]") {
  const auto kinematics = GENERATE(Kinematics::linear, Kinematics::corotational);
  std::mt19937 generator(5);
  const Eigen::Matrix3d Q = turn_about_random_axis(0.7, generator);
  const BaseMesh base = beam({6, 2, 2});
  BaseMesh turned_base = base;
  turned_base.nodes = Q * base.nodes;
  const auto refined = [](const BaseMesh& mesh) {
    RefinementForest forest(mesh);
    forest.refine(0, {{2, 3, 2}});
    forest.refine(7, {{2, 2, 2}});
    return forest;
  };
  const auto rollers = [](const Eigen::Matrix3d& R) {
    const auto none = std::function<Eigen::Vector3d(const Eigen::Vector3d&)>{};
    const Eigen::Vector3d lift = R * Eigen::Vector3d(0.0, 0.0, 1e-3);
    return std::vector<SupportCondition>{
        {"x_min", Eigen::Vector3d(R.col(0)), none},
        {"y_min", Eigen::Vector3d(R.col(1)), none},
        {"z_min", Eigen::Vector3d(R.col(2)), [lift](const Eigen::Vector3d&) { return lift; }}};
  };
  const Eigen::Vector3d pull(3.0, 1.0, -2.0);
  const Problem straight(refined(base), soft(kinematics), rollers(Eigen::Matrix3d::Identity()), end_force(pull));
  const Problem turned(refined(turned_base), soft(kinematics), rollers(Q), end_force(Q * pull));
  REQUIRE(straight.d.hanging.hanging_count() > 0);
  EquilibriumOptions options;
  options.linear.relative_residual = 1e-13;
  options.newton_residual = 1e-11;
  options.method = LinearMethod::direct;
  const Equilibrium a = straight.solve(straight.rest(), options), b = turned.solve(turned.rest(), options);
  REQUIRE(a.converged);
  REQUIRE(b.converged);
  CHECK(a.u.norm() > 1e-3);
  CHECK((b.u - Q * a.u).norm() <= 1e-9 * a.u.norm());
}

TEST_CASE("incompressible bodies and bodies without coarser meshes are solved directly", "[equilibrium]") {
  RefinementForest refined(beam({10, 1, 1}));
  for (const int leaf : leaves(refined)) refined.refine(leaf, {{2, 2, 2}});
  Material material = soft(Kinematics::linear);
  const Problem fine(refined, material, clamped_left, {});
  const Problem coarse(RefinementForest(beam({10, 1, 1})), material, clamped_left, {});
  material.poisson_ratio = 0.499;
  const Problem incompressible(refined, material, clamped_left, {});
  const auto chosen = [](const Problem& p) { return choose_method(p.d, p.hierarchy, LinearMethod::automatic); };
  CHECK(chosen(fine) == LinearMethod::multigrid);
  CHECK(chosen(coarse) == LinearMethod::direct);
  CHECK(chosen(incompressible) == LinearMethod::direct);
  CHECK(choose_method(coarse.d, coarse.hierarchy, LinearMethod::multigrid) == LinearMethod::multigrid);
}

TEST_CASE("loads below the round-off of the positions still move a corotational body", "[equilibrium][corotational]") {
  BoxMeshOptions box;
  box.cells = {2, 2, 2};
  const RefinementForest forest(box_mesh(box));
  Material material{2e11, 0.3};
  const std::vector<SupportCondition> supports = {{"x_min", {}, {}}};
  const auto solve = [&](Kinematics kinematics) {
    material.kinematics = kinematics;
    const Discretization d = discretize(forest, material, supports);
    const Eigen::Matrix3Xd loads =
        nodal_loads(forest.base(), d.mesh, {{"x_max", LoadKind::traction, Eigen::Vector3d(1e-4, 0.0, 0.0)}});
    return solve_equilibrium(d, {}, loads, Eigen::Matrix3Xd::Zero(3, d.mesh.node_count()), {});
  };
  const Equilibrium linear = solve(Kinematics::linear), corotational = solve(Kinematics::corotational);
  REQUIRE(linear.u.norm() > 0.0);
  REQUIRE(corotational.converged);
  CHECK(corotational.newton_iterations >= 1);
  // The positions resolve 1e-16 of a displacement of 5e-16: the answer's size is right, its digits are not there.
  CHECK((corotational.u - linear.u).norm() < 0.5 * linear.u.norm());
}

TEST_CASE("without loads any start ends at rest", "[equilibrium]") {
  BoxMeshOptions box;
  box.cells = {4, 2, 2};
  RefinementForest forest(box_mesh(box));
  forest.refine(3, {{2, 2, 2}});
  const std::vector<SupportCondition> supports = {{"x_min", {}, {}}};
  const Discretization d = discretize(forest, {1e3, 0.3}, supports);
  const MeshHierarchy hierarchy = build_hierarchy(forest, d, supports, {.smallest = 1, .reduction = 0.9});
  const Eigen::Matrix3Xd none = Eigen::Matrix3Xd::Zero(3, d.mesh.node_count());
  EquilibriumOptions options;
  options.method = GENERATE(LinearMethod::direct, LinearMethod::multigrid);
  const Equilibrium rest = solve_equilibrium(d, hierarchy, none, d.mesh.nodes, options);
  CHECK(rest.converged);
  CHECK(rest.u.norm() == 0.0);
}

TEST_CASE("the usual residual leaves no strain uncertain, ten nested thirds down", "[equilibrium][multigrid]") {
  // The block of the atlas's axis of depth: pulled along x on three sliding planes, exact on every mesh. The smallest
  // leaf's nodes carry 3^-20 of the load, and its energy is 3^-30 of the body's.
  const int levels = GENERATE(0, 3, 6, 10);
  CAPTURE(levels);
  BoxMeshOptions options;
  options.size = {2.0, 2.0, 2.0};
  options.cells = {2, 2, 2};
  RefinementForest forest(box_mesh(options));
  for (int level = 0, leaf = 0; level < levels; ++level) {
    forest.refine(leaf, {{3, 3, 3}});
    leaf = forest.cell(leaf).first_child + 26;
  }
  Material material = soft(Kinematics::linear);
  const Eigen::Vector3d strain = Eigen::Vector3d(1.0, -0.3, -0.3) * 1e-3;
  std::vector<SupportCondition> sliding;
  for (int axis = 0; axis < 3; ++axis)
    sliding.push_back({std::array{"x_min", "y_min", "z_min"}[static_cast<std::size_t>(axis)],
                       Eigen::Vector3d(Eigen::Vector3d::Unit(axis)),
                       {}});
  const Problem problem(std::move(forest), material, sliding, {{"x_max", LoadKind::traction, {1e3, 0.0, 0.0}}});
  EquilibriumOptions usual;
  usual.method = levels == 0 ? LinearMethod::direct : LinearMethod::multigrid;
  const Equilibrium solved = problem.solve(problem.rest(), usual);
  REQUIRE(solved.converged);
  const Mesh& mesh = problem.d.mesh;
  const Eigen::Matrix3Xd error = solved.u - strain.asDiagonal() * mesh.nodes;
  double largest = 0.0;
  for (const auto& cell : mesh.cells)
    for (const int corner : {1, 2, 4})
      largest = std::max(largest, (error.col(cell[corner]) - error.col(cell[0])).norm() /
                                      (mesh.nodes.col(cell[corner]) - mesh.nodes.col(cell[0])).norm());
  CHECK(largest <= 1e-3 * strain.norm());
  CHECK(solved.linear_iterations < 60);
}
