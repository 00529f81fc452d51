#include "core/space/springs.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

#include "core/solve/multigrid.hpp"
#include "core/static_step.hpp"
#include "core/tissue_forces.hpp"
#include "core/tissue_frame.hpp"
#include "core/tissue_step.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/deformed_body.hpp"
#include "verification/support/tissue_samples.hpp"

using namespace finegauge;

namespace {

Eigen::Vector3d bent(const Eigen::Vector3d& X) { return {0.03, 0.02 * X.y(), 0.01 - 0.01 * X.x()}; }

/// Springs at random points of random leaves, two in three of them on faces, edges or corners.
SpringSupport random_springs(const Mesh& mesh, int count, std::mt19937& generator) {
  SpringSupport support{"bed", {}, bent, swing};
  for (int p = 0; p < count; ++p)
    support.points.push_back(
        {material_point(mesh, random_leaf_point(mesh, generator)), 200.0 * (2.0 + random_number(generator))});
  return support;
}

/// A spring at the centre of every cell, together `stiffness`, each in proportion to its cell's volume: they pull at
/// the nodes as their masses do, so that a body in uniform motion stays in one.
SpringSupport bed_of_springs(const RefinementForest& forest, double stiffness) {
  const Discretization d = discretize(forest, Material{}, {});
  SpringSupport support{"bed", {}, {}, {}};
  CellGeometry scratch;
  double volume = 0.0;
  for (int cell = 0; cell < d.mesh.cell_count(); ++cell) volume += d.shapes.geometry(d.mesh, cell, scratch).volume;
  for (int cell = 0; cell < d.mesh.cell_count(); ++cell)
    support.points.push_back({material_point(d.mesh, {cell, Eigen::Vector3d::Constant(0.5)}),
                              stiffness * d.shapes.geometry(d.mesh, cell, scratch).volume / volume});
  return support;
}

RefinementForest box_with_hanging_nodes() {
  BoxMeshOptions options;
  options.cells = {2, 2, 1};
  options.size = {0.2, 0.1, 0.1};
  RefinementForest forest(box_mesh(options));
  forest.refine(0, {{2, 2, 2}});
  forest.refine(3, {{3, 3, 3}});
  return forest;
}

/// Σ k N_a N_b I over the springs at all nodes, the leaf found by descending the forest.
Eigen::MatrixXd dense_springs(const RefinementForest& forest, const Mesh& mesh, const SpringSupport& support) {
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(3 * mesh.node_count(), 3 * mesh.node_count());
  for (const SpringPoint& spring : support.points) {
    const LeafPoint leaf = find_leaf(forest, mesh, spring.at);
    const auto N = shape_functions(mesh.shape, leaf.xi);
    for (int a = 0; a < corner_count(mesh.shape); ++a)
      for (int b = 0; b < corner_count(mesh.shape); ++b)
        for (int k = 0; k < 3; ++k)
          K(3 * mesh.cells[leaf.cell][a] + k, 3 * mesh.cells[leaf.cell][b] + k) += spring.stiffness * N[a] * N[b];
  }
  return K;
}

/// What std::invalid_argument says; empty where nothing is thrown.
template <class Action>
std::string message_of(const Action& action) {
  try {
    action();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("point springs add k N_a N_b to the stiffness, hanging cells too, and do not turn", "[springs][hanging]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const auto kinematics = GENERATE(Kinematics::linear, Kinematics::corotational);
  CAPTURE(int(shape), int(kinematics));
  std::mt19937 generator(5);
  const RefinementForest forest = random_body({.shape = shape}, generator);
  const Mesh mesh = forest.leaf_mesh();
  const SpringSupport support = random_springs(mesh, 40, generator);
  const Material material = soft_problem(kinematics).material;
  const Discretization d = discretize(forest, mesh, material, {}, {support}), bare = discretize(forest, material, {});
  int in_hanging_cells = 0;
  for (const Springs::Point& point : d.springs.points)
    in_hanging_cells += std::binary_search(d.scatter.hanging.begin(), d.scatter.hanging.end(), point.cell);
  REQUIRE(in_hanging_cells > 5);
  REQUIRE(in_hanging_cells < 40);

  const Eigen::Matrix3Xd u = bent_and_turned(mesh, d.hanging, 0.1, 1.0);
  const Eigen::MatrixXd springs = dense_springs(forest, mesh, support);
  const Eigen::SparseMatrix<double> T = interpolation_matrix(d.hanging);
  const Eigen::MatrixXd added =
      Eigen::MatrixXd(to_sparse(assemble_stiffness(d, u))) - Eigen::MatrixXd(to_sparse(assemble_stiffness(bare, u)));
  const Eigen::MatrixXd expected = T.transpose() * springs * T;
  const double K = to_sparse(assemble_stiffness(bare, u)).norm();
  CHECK((added - expected).norm() <= 1e-14 * (K + expected.norm()));  // what adding to the body's own rounds off
  CHECK(expected.norm() > 1e-3 * K);
  // Where leaves share a point they share its displacement, but not its nodes: only reduced do they agree.
  const Eigen::MatrixXd nodal = T.transpose() * (nodal_stiffness(d, u) - nodal_stiffness(bare, u)) * T;
  CHECK((nodal - expected).norm() <= 1e-14 * (K + expected.norm()));

  const Eigen::VectorXd force = expected * gather(d.hanging, u);
  const Eigen::VectorXd f = reduce_forces(d.hanging, internal_forces(d, u));
  CHECK((f - reduce_forces(d.hanging, internal_forces(bare, u)) - force).norm() <= 1e-13 * f.norm());
  const Eigen::Matrix3Xd w = random_field(d, 1.0, generator);
  const TissueForces with = tissue_forces(d, u, w), without = tissue_forces(bare, u, w);
  CHECK((with.internal - without.internal - force).norm() <= 1e-12 * with.internal.norm());
  CHECK((with.stiff - without.stiff - T.transpose() * (springs * w.reshaped())).norm() <= 1e-12 * with.stiff.norm());
  // The energy of the body at large does not count them.
  CHECK(strain_energy_product(d, u) == strain_energy_product(bare, u));
  const double stored = spring_energy(d.springs, d.mesh, u, 0.0);  // swing(0) = 0: anchors at rest
  CHECK_THAT(stored, WithinRel(0.5 * u.reshaped().dot(springs * u.reshaped()), 1e-12));
}

TEST_CASE("a block on springs swings as backward Euler has it: each step by 1/sqrt(1 + (ωτ)²)",
          "[springs][tissue_step]") {
  const auto kinematics = GENERATE(Kinematics::linear, Kinematics::corotational);
  const RefinementForest forest = box_with_hanging_nodes();
  TissueProblem problem = soft_problem(kinematics);
  const double stiffness = 50.0, volume = 0.2 * 0.1 * 0.1, mass = problem.density * volume;
  problem.springs = {bed_of_springs(forest, stiffness)};
  const TissueMesh mesh = build_tissue_mesh(forest, problem);
  REQUIRE(mesh.d.hanging.hanging_count() > 0);
  const double omega = std::sqrt(stiffness / mass), tau = 0.02;  // ωτ = 0.1, a period of 63 steps
  TissueState state = state_at_rest(mesh);
  const Eigen::Vector3d start(1e-3, -2e-3, 0.5e-3);
  state.u.colwise() = start;
  const double energy = tissue_energy(mesh, state).sum();
  CHECK_THAT(energy, WithinRel(0.5 * stiffness * start.squaredNorm(), 1e-12));
  TissueSystem system;
  FactorCache factors;
  const double factor = 1.0 / std::sqrt(1.0 + omega * omega * tau * tau), angle = std::atan(omega * tau);
  for (int step = 1; step <= 150; ++step) {
    REQUIRE(
        step_tissue(mesh, problem, (step - 1) * tau, tau, {}, direct_linear_solve(factors), system, state).converged);
    const double amplitude = std::pow(factor, step);
    const Eigen::Vector3d u = amplitude * std::cos(step * angle) * start;
    const Eigen::Vector3d v = -omega * amplitude * std::sin(step * angle) * start;
    // Round-off acts through the stiffness of the block, some 1e3 N/m over springs of 50 N/m.
    REQUIRE((state.u.colwise() - u).cwiseAbs().maxCoeff() <= 1e-11 * start.norm());
    REQUIRE((state.v.colwise() - v).cwiseAbs().maxCoeff() <= 1e-11 * omega * start.norm());
    REQUIRE_THAT(tissue_energy(mesh, state).sum(), WithinRel(energy * amplitude * amplitude, 1e-10));
  }
}

TEST_CASE("the energy ledger closes with springs whose anchors move", "[springs][tissue_step][energy]") {
  std::mt19937 generator(15);
  TissueProblem problem = soft_problem();
  problem.mass_damping = 0.5;
  problem.stiffness_damping = 2e-3;
  problem.gravity = {0.0, -9.81, 0.0};
  const RefinementForest forest = random_body({}, generator);
  problem.springs = {random_springs(forest.leaf_mesh(), 30, generator)};
  const TissueMesh mesh = build_tissue_mesh(forest, problem);
  REQUIRE(mesh.d.hanging.hanging_count() > 0);
  TissueState state = state_at_rest(mesh);
  TissueSystem system;
  FactorCache factors;
  const double tau = 0.01;
  double springs = 0.0, damping = 0.0, numerical = 0.0, throughput = 0.0;
  for (int step = 0; step < 100; ++step) {
    const double time = step * tau;
    const TissueState before = state;
    REQUIRE(step_tissue(mesh, problem, time, tau, {}, direct_linear_solve(factors), system, state).equilibrium_error <
            1e-11);
    const Eigen::VectorXd v = gather(mesh.d.hanging, before.v);
    REQUIRE(out_of_balance(mesh, problem, state, v, {}, tau, time).error() < 1e-11);
    const TissueWork work = tissue_work(mesh, problem, before, state, {}, tau, time);
    const double after = tissue_energy(mesh, state, time + tau).sum();
    const double change = after - tissue_energy(mesh, before, time).sum();
    const double size = std::abs(work.loads) + std::abs(work.springs) + work.damping + work.numerical + after;
    REQUIRE(std::abs(change - work.sum()) <= 1e-12 * size);
    REQUIRE(work.damping >= 0.0);
    REQUIRE(work.numerical >= 0.0);
    springs += std::abs(work.springs);
    damping += work.damping;
    numerical += work.numerical;
    throughput += size;
  }
  for (const double part : {springs, damping, numerical}) CHECK(part > 1e-4 * throughput);
  CHECK_THROWS_AS(tissue_energy(mesh, state), std::invalid_argument);  // moving anchors and no time
}

TEST_CASE("a body that goes with its anchors feels neither springs nor their damping", "[springs][tissue_step]") {
  const RefinementForest forest = box_with_hanging_nodes();
  TissueProblem problem = soft_problem(Kinematics::corotational);
  problem.stiffness_damping = 0.01;
  const Eigen::Vector3d velocity(0.1, -0.2, 0.05);
  problem.springs = {bed_of_springs(forest, 50.0)};
  problem.springs[0].displacement = [&](const Eigen::Vector3d&) { return velocity; };
  problem.springs[0].course = [](double t) { return t; };
  const TissueMesh mesh = build_tissue_mesh(forest, problem);
  TissueState state = state_at_rest(mesh);
  state.v.colwise() = velocity;
  TissueSystem system;
  FactorCache factors;
  const double tau = 0.01;
  for (int step = 0; step < 50; ++step)
    REQUIRE(step_tissue(mesh, problem, step * tau, tau, {}, direct_linear_solve(factors), system, state).converged);
  CHECK((state.u.colwise() - 50 * tau * velocity).norm() <= 1e-11 * state.u.norm());
  CHECK((state.v.colwise() - velocity).norm() <= 1e-11 * state.v.norm());
  // Left behind, it is pulled along.
  TissueState late = state_at_rest(mesh);
  REQUIRE(step_tissue(mesh, problem, 0.0, tau, {}, direct_linear_solve(factors), system, late).converged);
  const double k = 50.0, m = 2.0, beta = problem.stiffness_damping;
  const double share = tau * k * (tau + beta) / (m + tau * beta * k + tau * tau * k);
  CHECK((late.v.colwise() - share * velocity).norm() <= 1e-11 * late.v.norm());
}

TEST_CASE("refinement and coarsening leave what springs feel as the field has it", "[springs][transfer]") {
  std::mt19937 generator(21);
  TissueProblem problem = soft_problem();
  RefinementForest forest = random_body({.refinements = 3, .max_depth = 1}, generator);
  problem.springs = {random_springs(forest.leaf_mesh(), 40, generator)};
  const TissueMesh coarse = build_tissue_mesh(forest, problem);
  const TissueState state{random_field(coarse.d, 0.02, generator), random_field(coarse.d, 0.5, generator)};
  std::vector<int> refined;
  for (const int leaf : leaves(forest))
    if (generator() % 2 == 0) {
      forest.refine(leaf, {{2, 2, 2}});
      refined.push_back(leaf);
    }
  const TissueMesh fine = build_tissue_mesh(forest, problem);
  int moved = 0;
  for (std::size_t p = 0; p < fine.d.springs.points.size(); ++p)
    moved += fine.d.springs.points[p].cell != coarse.d.springs.points[p].cell;
  REQUIRE(moved > 10);
  TransferLedger ledger;
  const double time = 0.07;
  const TissueState on_fine = transfer_state(coarse, state, fine, &ledger, time);
  const double before = spring_energy(coarse.d.springs, coarse.d.mesh, state.u, time);
  CHECK(before > 0.0);
  CHECK_THAT(spring_energy(fine.d.springs, fine.d.mesh, on_fine.u, time), WithinRel(before, 1e-12));
  // The body's own energy changes, since finer cells integrate it better.
  const double body = 0.5 * (strain_energy_product(fine.d, on_fine.u) - strain_energy_product(coarse.d, state.u));
  CHECK_THAT(ledger.elastic_change - body, WithinAbs(0.0, 1e-12 * tissue_energy(coarse, state, time).elastic));
  // Back on the coarse mesh: the springs are where they were, to the last bit, and so is the displacement.
  for (const int parent : refined) forest.coarsen(parent);
  const TissueMesh again = build_tissue_mesh(forest, problem);
  const TissueState back = transfer_state(fine, on_fine, again, &ledger, time);
  CHECK(same_bits(back.u, state.u));
  CHECK(spring_energy(again.d.springs, again.d.mesh, back.u, time) == before);
  // The springs of another mesh of the forest, found from those of this one.
  const Springs moved_over = springs_on(fine.d.springs, coarse.d.mesh);
  REQUIRE(moved_over.matrices.size() == coarse.d.springs.matrices.size());
  for (std::size_t m = 0; m < moved_over.matrices.size(); ++m)
    CHECK(moved_over.matrices[m] == coarse.d.springs.matrices[m]);
}

TEST_CASE("frames of an adaptive body on moving springs: the ledger closes, changes of mesh are released",
          "[springs][tissue_frame][energy]") {
  BoxMeshOptions options;
  options.cells = {4, 3, 3};
  options.size = {0.2, 0.15, 0.15};
  MotionProblem problem;
  problem.tissue = soft_problem();
  problem.tissue.stiffness_damping = 2e-3;
  problem.tissue.gravity = {0.0, 0.0, -9.81};
  RefinementForest forest(box_mesh(options));
  SpringSupport support{
      "diaphragm", {}, [](const Eigen::Vector3d&) { return Eigen::Vector3d(0.01, 0.0, 0.02); }, swing};
  for (const double x : {0.01, 0.07, 0.13})
    for (const double y : {0.02, 0.12})
      support.points.push_back({*locate_at_rest(forest.base(), {x, y, 0.149}), 300.0});
  problem.tissue.springs = {support};
  problem.solver.linear.relative_residual = 1e-13;
  problem.adapt = FrameAdaptRules{};
  problem.adapt->dwell = 3;
  problem.adapt->release = GENERATE(1, 4);
  CAPTURE(problem.adapt->release);
  Tissue tissue = start_tissue(std::move(forest), problem);
  EnergyLedger energy;
  int refined = 0;
  double throughput = 0.0;
  for (int frame = 0; frame < 60; ++frame) {
    const FrameReport report = advance_frame(problem, tissue, energy);
    REQUIRE(report.converged);
    REQUIRE(report.equilibrium_error < 1e-9);
    refined += report.refined;
    throughput = std::max({throughput, std::abs(energy.work), energy.kinetic + energy.elastic});
  }
  REQUIRE(refined > 10);
  CAPTURE(energy.closure, throughput);
  CHECK(throughput > 0.01);
  CHECK(std::abs(energy.closure) <= 1e-9 * throughput);
}

TEST_CASE("what a change of mesh releases counts what anchors pull", "[springs][tissue_frame]") {
  // At rest under anchors that pull: refinement leaves over what the fine mesh's springs and cells ask for, no more.
  RefinementForest forest = box_with_hanging_nodes();
  TissueProblem problem = soft_problem();
  std::mt19937 generator(22);
  problem.springs = {random_springs(forest.leaf_mesh(), 20, generator)};
  problem.springs[0].course = [](double t) { return std::min(t, 1.0); };
  const TissueMesh coarse = build_tissue_mesh(forest, problem);
  TissueState state = state_at_rest(coarse);
  TissueSystem system;
  FactorCache factors;
  const double tau = 1e6;
  for (int step = 0; step < 2; ++step)
    REQUIRE(step_tissue(coarse, problem, tau * step, tau, {}, direct_linear_solve(factors), system, state).converged);
  for (const int leaf : leaves(forest)) forest.refine(leaf, {{2, 2, 2}});
  TissueMesh fine = build_tissue_mesh(forest, problem);
  const double time = 2.0 * tau;
  const TissueState after = transfer_state(coarse, state, fine, nullptr, time);
  MeshChangeRelease release;
  const Eigen::VectorXd none;
  EndedStep ended{state.v, none};
  ended.time = time - tau;
  release_change(problem, coarse, state, after, ended, tau, 4, fine, release);
  REQUIRE(release.pending.cols() == 1);
  const Eigen::Matrix3Xd pull = anchor_forces(fine.d.springs, fine.d.mesh, anchors_at(fine.d.springs, time));
  const Eigen::VectorXd expected = reduce_forces(fine.d.hanging, internal_forces(fine.d, after.u) - pull);
  CHECK(expected.norm() > 1e-3);
  CHECK((release.pending.col(0) - expected).norm() <= 1e-9 * expected.norm());
}

TEST_CASE("springs hold a body: static equilibrium, by multigrid as by dense algebra", "[springs][static]") {
  const auto kinematics = GENERATE(Kinematics::linear, Kinematics::corotational);
  BoxMeshOptions options;
  options.cells = {2, 2, 2};
  RefinementForest forest(box_mesh(options));
  for (int level = 0; level < 2; ++level)
    for (const int leaf : leaves(forest)) forest.refine(leaf, {{2, 2, 2}});
  StaticProblem problem;
  problem.material = soft_problem(kinematics).material;
  problem.loads = {{"x_max", LoadKind::total_by_area, {0.0, 0.0, 1.0}}};
  SpringSupport support{"bed", {}, [](const Eigen::Vector3d&) { return Eigen::Vector3d(0.01, 0.0, 0.0); }, {}};
  for (const double x : {0.11, 0.9})
    for (const double y : {0.07, 0.77}) support.points.push_back({*locate_at_rest(forest.base(), {x, y, 0.2}), 400.0});
  problem.springs = {support};
  problem.solver.method = LinearMethod::multigrid;
  problem.solver.linear.relative_residual = 1e-11;
  problem.solver.newton_residual = 1e-10;
  FactorCache factors;
  const StaticSolution solution = solve_static(forest, problem, nullptr, factors);
  REQUIRE(solution.equilibrium.converged);
  REQUIRE(solution.multigrid_levels == 3);
  const Discretization& d = solution.discretization;
  CAPTURE(solution.equilibrium.linear_iterations, solution.equilibrium.newton_iterations);
  CHECK(solution.equilibrium.linear_iterations <= 25 * solution.equilibrium.newton_iterations);
  // The springs carry the load, all of it: Σ k (u - a) = f.
  Eigen::Vector3d carried = Eigen::Vector3d::Zero();
  for (const Springs::Point& point : d.springs.points)
    carried += point.stiffness *
               (interpolate(d.mesh, solution.equilibrium.u, {point.cell, point.xi}) - Eigen::Vector3d(0.01, 0.0, 0.0));
  CHECK((carried - Eigen::Vector3d(0.0, 0.0, 1.0)).norm() <= 1e-8);
  CHECK(solution.equilibrium.energy == strain_energy_product(d, solution.equilibrium.u));
  if (kinematics == Kinematics::corotational) return;
  const Eigen::MatrixXd K = Eigen::MatrixXd(nodal_stiffness(discretize(forest, problem.material, {}), {})) +
                            dense_springs(forest, d.mesh, support);
  Eigen::VectorXd f = nodal_loads(forest.base(), d.mesh, problem.loads).reshaped();
  for (const Springs::Point& point : d.springs.points)
    for (int c = 0; c < 8; ++c) f[3 * d.mesh.cells[point.cell][c]] += 0.01 * point.stiffness * point.N[c];
  const Eigen::VectorXd u = K.ldlt().solve(f);
  CHECK((solution.equilibrium.u.reshaped() - u).norm() <= 1e-8 * u.norm());
}

TEST_CASE("rigid motions that springs leave free are counted", "[springs][supports]") {
  BoxMeshOptions options;
  options.cells = {2, 1, 1};
  RefinementForest forest(box_mesh(options));
  forest.refine(0, {{2, 2, 2}});
  const auto free_with = [&](int points, const std::vector<SupportCondition>& supports) {
    SpringSupport support{"bed", {}, {}, {}};
    const std::array<Eigen::Vector3d, 4> at = {{{0.1, 0.2, 0.3},
                                                {0.3, 0.4, 0.5},
                                                {0.9, 1.0, 1.1},
                                                {0.4, 0.1, 0.9}}};  // the third on the line of the two first
    for (int p = 0; p < points; ++p) support.points.push_back({*locate_at_rest(forest.base(), 0.5 * at[p]), 1.0});
    const Discretization d = discretize(forest, forest.leaf_mesh(), Material{}, supports, {support});
    const auto bodies = free_rigid_motions(forest.topology(), d.mesh, d.hanging, d.supports, d.springs);
    REQUIRE(bodies.size() == 1);
    CHECK(bodies[0].cells == d.mesh.cell_count());
    return bodies[0].free_motions;
  };
  CHECK(free_with(0, {}) == 6);
  CHECK(free_with(1, {}) == 3);
  CHECK(free_with(2, {}) == 1);
  CHECK(free_with(3, {}) == 1);
  CHECK(free_with(4, {}) == 0);
  CHECK(free_with(0, {{"x_min", Eigen::Vector3d(1, 0, 0), {}}}) == 3);
  CHECK(free_with(1, {{"x_min", Eigen::Vector3d(1, 0, 0), {}}}) == 1);
  CHECK(free_with(2, {{"x_min", Eigen::Vector3d(1, 0, 0), {}}}) == 0);
}

TEST_CASE("springs that cannot be are refused by name, value and range", "[springs]") {
  const RefinementForest forest(box_mesh({}));
  const auto refused = [&](const SpringPoint& point, const std::string& what) {
    const SpringSupport support{"bed", {point}, {}, {}};
    const std::string message =
        message_of([&] { (void)discretize(forest, forest.leaf_mesh(), Material{}, {}, {support}); });
    CAPTURE(message, what);
    CHECK(message.find("'bed'") != std::string::npos);
    CHECK(message.find(what) != std::string::npos);
  };
  const Eigen::Vector3d middle = Eigen::Vector3d::Constant(0.5);
  refused({{1, middle}, 1.0}, "base cell 1");
  refused({{-1, middle}, 1.0}, "base cell -1");
  refused({{0, {0.5, 1.5, 0.5}}, 1.0}, "outside");
  refused({{0, {0.5, std::nan(""), 0.5}}, 1.0}, "outside");
  refused({{0, middle}, 0.0}, "> 0");
  refused({{0, middle}, std::nan("")}, "> 0");
  const SpringSupport moving{"bed", {{{0, middle}, 1.0}}, {}, [](double) { return std::nan(""); }};
  const Discretization d = discretize(forest, forest.leaf_mesh(), Material{}, {}, {moving});
  CHECK(message_of([&] { (void)anchors_at(d.springs, 0.0); }).find("not finite") != std::string::npos);
}

TEST_CASE("springs in units scaled by powers of two give the same bits", "[springs][tissue_step]") {
  std::mt19937 generator(18);
  const RefinementForest forest = random_body({.refinements = 3}, generator);
  BaseMesh larger = forest.base();
  larger.nodes *= 4.0;
  std::mt19937 order(1);
  const RefinementForest scaled = replay(larger, recipe_of(forest), order);
  TissueProblem problem = soft_problem(Kinematics::corotational);
  problem.stiffness_damping = 1.0 / 256;
  problem.springs = {random_springs(forest.leaf_mesh(), 20, generator)};
  TissueProblem other = problem;  // lengths × 4, times × 2, densities × 1: moduli × 4, springs × 16
  other.material.youngs_modulus *= 4.0;
  other.stiffness_damping *= 2.0;
  for (SpringPoint& point : other.springs[0].points) point.stiffness *= 16.0;
  other.springs[0].displacement = [](const Eigen::Vector3d& X) { return Eigen::Vector3d(4.0 * bent(0.25 * X)); };
  other.springs[0].course = [](double t) { return swing(0.5 * t); };
  const TissueMesh mesh = build_tissue_mesh(forest, problem), twice = build_tissue_mesh(scaled, other);
  TissueState state{random_field(mesh.d, 0.01, generator), random_field(mesh.d, 0.1, generator)};
  TissueState large{4.0 * state.u, 2.0 * state.v};
  TissueSystem system;
  FactorCache factors;
  for (int step = 0; step < 5; ++step) {
    (void)step_tissue(mesh, problem, step / 64.0, 1.0 / 64, {}, direct_linear_solve(factors), system, state);
    (void)step_tissue(twice, other, step / 32.0, 1.0 / 32, {}, direct_linear_solve(factors), system, large);
  }
  CHECK(same_bits(large.u, 4.0 * state.u));
  CHECK(same_bits(large.v, 2.0 * state.v));
}
