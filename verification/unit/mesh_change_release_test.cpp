#include "core/mesh_change_release.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "core/adapt/apply_refinements.hpp"
#include "core/space/transfer.hpp"
#include "core/tissue_frame.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/refinement_history.hpp"
#include "verification/support/tissue_samples.hpp"

using namespace finegauge;

namespace {

/// A beam, 4 × 1 × 1 m, clamped on x_min and pulled down at its end.
MotionProblem bending_problem(Kinematics kinematics) {
  MotionProblem problem;
  problem.tissue.material.youngs_modulus = 1e5;
  problem.tissue.material.poisson_ratio = 0.3;
  problem.tissue.material.kinematics = kinematics;
  problem.tissue.supports = {{"x_min", {}, {}, {}}};
  problem.tissue.loads = {{"x_max", LoadKind::total_by_area, {0.0, 0.0, -200.0}}};
  problem.estimate_error = false;
  problem.solver.linear.relative_residual = 1e-10;
  return problem;
}

RefinementForest beam() {
  BoxMeshOptions box;
  box.cells = {4, 1, 1};
  box.size = {4.0, 1.0, 1.0};
  return RefinementForest(box_mesh(box));
}

/// The mean downward displacement of the loaded face's corners [m].
double deflection(const Tissue& tissue) {
  const Mesh& mesh = tissue.mesh.d.mesh;
  double sum = 0.0;
  int count = 0;
  for (int node = 0; node < mesh.node_count(); ++node)
    if (mesh.nodes(0, node) == 4.0) {
      const Eigen::Vector3d X = mesh.nodes.col(node);
      const bool corner = (X.y() == 0.0 || X.y() == 1.0) && (X.z() == 0.0 || X.z() == 1.0);
      if (!corner) continue;
      sum -= tissue.state.u(2, node);
      ++count;
    }
  REQUIRE(count == 4);
  return sum / count;
}

/// Changes the mesh of the tissue as a frame would that ended with `before`.
void change_mesh(const MotionProblem& problem, int release, const std::function<void(RefinementForest&)>& change,
                 const Eigen::Matrix3Xd& start_velocity, Tissue& tissue, EnergyLedger& energy) {
  change(tissue.forest);
  TissueMesh mesh = build_tissue_mesh(tissue.forest, problem.tissue);
  TransferLedger ledger;
  TissueState state = transfer_state(tissue.mesh, tissue.state, mesh, &ledger);
  const Eigen::VectorXd none;
  if (release > 1)
    release_change(problem.tissue, tissue.mesh, tissue.state, state, {start_velocity, none}, problem.time_step, release,
                   mesh, tissue.release);
  tissue.state = std::move(state);
  tissue.mesh = std::move(mesh);
  tissue.mesh_changed = true;
  energy.dissipated -= ledger.elastic_change + ledger.kinetic_change;
}

void refine_all(RefinementForest& forest) { refine_uniformly(forest); }
void coarsen_all(RefinementForest& forest) {
  for (const int family : families(forest)) forest.coarsen(family);
}

}  // namespace

TEST_CASE("in long steps the body goes from the old mesh's equilibrium to the new one's in equal parts",
          "[release][tissue]") {
  const bool refine = GENERATE(true, false);
  const int N = GENERATE(2, 7);
  CAPTURE(refine, N);
  MotionProblem problem = bending_problem(Kinematics::linear);
  problem.time_step = 1e4;  // the slowest period is a second: every step ends at rest
  RefinementForest forest = beam();
  if (!refine) refine_all(forest);
  Tissue tissue = start_tissue(std::move(forest), problem);
  EnergyLedger energy;
  REQUIRE(advance_frame(problem, tissue, energy).converged);
  const double before = deflection(tissue);
  change_mesh(problem, N, refine ? refine_all : coarsen_all, Eigen::Matrix3Xd::Zero(3, tissue.state.v.cols()), tissue,
              energy);
  std::vector<double> path{before};
  for (int k = 1; k <= N + 1; ++k) {
    const FrameReport report = advance_frame(problem, tissue, energy);
    REQUIRE(report.converged);
    CHECK(report.releasing == (k < N ? 1 : 0));
    path.push_back(deflection(tissue));
  }
  const double after = path.back(), change = after - before;
  CHECK((refine ? change : -change) > 0.05 * before);  // locking of two cells over the height: the finer is softer
  for (int k = 1; k <= N; ++k) CHECK_THAT(path[k] - path[k - 1], WithinAbs(change / N, 1e-5 * std::abs(change)));
  CHECK_THAT(path[N + 1] - path[N], WithinAbs(0.0, 1e-5 * std::abs(change)));
  CHECK(tissue.release.empty());
  // Loads and equilibrium are those of a body that was never anything else.
  MotionProblem plain = problem;
  RefinementForest same = beam();
  if (refine) refine_all(same);
  Tissue other = start_tissue(std::move(same), plain);
  EnergyLedger other_energy;
  static_cast<void>(advance_frame(plain, other, other_energy));
  CHECK(same_bits(tissue.mesh.loads, other.mesh.loads));
  CHECK_THAT(after, WithinRel(deflection(other), 1e-7));
}

TEST_CASE("after a change the body goes on with the accelerations that it had", "[release][tissue]") {
  // A beam that has just been let go: all of its motion is acceleration.
  const bool refine = GENERATE(true, false);
  CAPTURE(refine);
  MotionProblem problem = bending_problem(Kinematics::corotational);
  problem.time_step = 1e-3;
  RefinementForest forest = beam();
  if (!refine) refine_all(forest);
  Tissue tissue = start_tissue(std::move(forest), problem);
  EnergyLedger energy;
  Eigen::Matrix3Xd v;
  for (int k = 0; k < 40; ++k) {
    v = tissue.state.v;
    REQUIRE(advance_frame(problem, tissue, energy).converged);
  }
  REQUIRE((tissue.state.v - v).norm() > 0.0);
  // The jump of the accelerations, over the accelerations, in the next step.
  const auto jump = [&](int release) {
    Tissue copy{.forest = tissue.forest,
                .mesh = tissue.mesh,
                .state = tissue.state,
                .estimate = {},
                .history = {},
                .release = {},
                .system = {},
                .solver = StepSolver(problem.solver)};
    copy.time = tissue.time;
    copy.frame = tissue.frame;
    EnergyLedger unused;
    change_mesh(problem, release, refine ? refine_all : coarsen_all, v, copy, unused);
    const Eigen::Matrix3Xd old = transfer(tissue.mesh.d.mesh, tissue.state.v - v, copy.mesh.d.mesh);
    const Eigen::Matrix3Xd start = copy.state.v;
    static_cast<void>(advance_frame(problem, copy, unused));
    return (copy.state.v - start - old).norm() / old.norm();
  };
  const double at_once = jump(0), released = jump(1000000);
  CAPTURE(at_once, released);
  CHECK(at_once > 0.3);
  CHECK(released < 0.2);  // what one step of 1 ms changes anyway
  CHECK(released < 0.3 * at_once);
}

TEST_CASE("the loads' work closes the energy balance, over refinement, coarsening and overlapping releases",
          "[release][tissue][energy]") {
  MotionProblem problem = bending_problem(Kinematics::linear);
  problem.time_step = 5e-3;
  problem.tissue.stiffness_damping = 1e-3;
  Tissue tissue = start_tissue(beam(), problem);
  EnergyLedger energy;
  double largest = 0.0, largest_release = 0.0;
  int overlapping = 0;
  for (int k = 0; k < 60; ++k) {
    const Eigen::Matrix3Xd v = tissue.state.v;
    const FrameReport report = advance_frame(problem, tissue, energy);
    overlapping += report.releasing > 1;
    largest = std::max(largest, report.energy.kinetic + report.energy.elastic);
    largest_release = std::max(largest_release, std::abs(report.energy.release));
    CHECK_THAT(report.energy.closure, WithinAbs(0.0, 1e-9 * largest));
    if (k == 10) change_mesh(problem, 8, refine_all, v, tissue, energy);
    if (k == 13)
      change_mesh(
          problem, 8, [](RefinementForest& f) { f.refine(leaves(f).front(), {}); }, v, tissue, energy);
    if (k == 16) change_mesh(problem, 8, coarsen_all, v, tissue, energy);
    if (k == 17) change_mesh(problem, 8, coarsen_all, v, tissue, energy);
  }
  CHECK(overlapping >= 8);
  CHECK(largest_release > 1e-3 * largest);  // without it the balance would not close
  CHECK(tissue.release.empty());
}

TEST_CASE("forces on another mesh do the work that they did", "[release][transfer]") {
  const auto shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  const unsigned seed = GENERATE(1u, 2u, 3u);
  CAPTURE(int(shape), seed);
  std::mt19937 generator(seed);
  RandomBody body;
  body.shape = shape;
  RefinementForest forest = random_body(body, generator);
  const Discretization coarse = discretize(forest, {}, {});
  for (const int leaf : leaves(forest))
    if (generator() % 3 == 0) forest.refine(leaf, {});
  const Discretization fine = discretize(forest, {}, {});
  REQUIRE(fine.dof_count() > coarse.dof_count());
  REQUIRE(fine.hanging.hanging_count() > 0);
  const auto random = [&](int rows) {
    return Eigen::VectorXd::NullaryExpr(rows, [&](auto) { return random_number(generator); }).eval();
  };
  const auto sum = [](const Eigen::VectorXd& f) { return f.reshaped(3, f.size() / 3).rowwise().sum().eval(); };

  // To the coarse mesh: the work on every coarse field.
  Eigen::MatrixXd f(fine.dof_count(), 2);
  f << random(fine.dof_count()), random(fine.dof_count());
  const Eigen::MatrixXd down = transfer_forces(fine, f, coarse);
  const Eigen::VectorXd c = random(coarse.dof_count());
  const Eigen::VectorXd c_fine = gather(fine.hanging, transfer(coarse.mesh, expand(coarse.hanging, c), fine.mesh));
  for (int k = 0; k < 2; ++k) {
    CHECK_THAT(down.col(k).dot(c), WithinAbs(f.col(k).dot(c_fine), 1e-12 * f.col(k).norm() * c_fine.norm()));
    CHECK((sum(down.col(k)) - sum(f.col(k))).norm() <= 1e-12 * f.col(k).lpNorm<1>());
  }
  // To the fine mesh: the work on every fine field's values at the old nodes, so that of coarse fields too.
  const Eigen::VectorXd g = random(coarse.dof_count());
  const Eigen::VectorXd up = transfer_forces(coarse, g, fine).col(0);
  CHECK_THAT(up.dot(c_fine), WithinAbs(g.dot(c), 1e-12 * g.norm() * c.norm()));
  const Eigen::VectorXd w = random(fine.dof_count());
  const Eigen::VectorXd w_at_old = gather(coarse.hanging, transfer(fine.mesh, expand(fine.hanging, w), coarse.mesh));
  CHECK_THAT(up.dot(w), WithinAbs(g.dot(w_at_old), 1e-12 * g.norm() * w.norm()));
  CHECK((sum(up) - sum(g)).norm() <= 1e-12 * g.lpNorm<1>());
}
