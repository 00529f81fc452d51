#include "core/tissue_frame.hpp"

#include <algorithm>
#include <utility>

namespace finegauge {

Tissue start_tissue(RefinementForest forest, const MotionProblem& problem) {
  TissueMesh mesh = build_tissue_mesh(forest, problem.tissue);
  const Eigen::Matrix3Xd zero = Eigen::Matrix3Xd::Zero(3, mesh.d.mesh.node_count());
  return {.forest = std::move(forest),
          .mesh = std::move(mesh),
          .state = {zero, zero},
          .estimate = {},
          .history = {},
          .release = {},
          .system = {},
          .solver = StepSolver(problem.solver)};
}

FrameReport begin_report(const Tissue& tissue) {
  FrameReport report;
  report.frame = tissue.frame + 1;
  report.dofs = tissue.mesh.d.dof_count();
  report.cells = tissue.mesh.d.mesh.cell_count();
  report.hanging_nodes = tissue.mesh.d.hanging.hanging_count();
  report.releasing = static_cast<int>(tissue.release.frames_left.size());
  return report;
}

void add_tissue_work(const MotionProblem& problem, const Tissue& tissue, const TissueState& before,
                     const Eigen::VectorXd& constraint_impulse, EnergyLedger& energy) {
  const double tau = problem.time_step, start = (tissue.frame - 1) * tau;
  const TissueWork work =
      tissue_work(tissue.mesh, problem.tissue, before, tissue.state, constraint_impulse, tau, start);
  energy.work += work.loads + work.supports + work.springs;
  if (tissue.releasing()) energy.release += released_work(tissue.release, tissue.mesh, tissue.state.v, tau);
  energy.dissipated += work.damping + work.numerical;
}

void close(EnergyLedger& energy) { energy.closure = energy.kinetic + energy.elastic - energy.work + energy.dissipated; }

FrameReport advance_frame(const MotionProblem& problem, Tissue& tissue, EnergyLedger& energy) {
  if (tissue.releasing()) fade(tissue.release, tissue.mesh);
  FrameReport report = begin_report(tissue);
  Stopwatch watch(problem.stage_clock);
  const TissueState before = tissue.state;
  const double tau = problem.time_step;
  const LinearSolve solve = [&](const BlockMatrix<double>& A, const Eigen::VectorXd& b, Eigen::VectorXd& x) {
    report.times.assemble_ms += watch.lap();
    tissue.solver.set_matrix(A, !std::exchange(tissue.mesh_changed, false));
    const SolveReport solved = tissue.solver.solve(b, x);
    report.times.solve_ms += watch.lap();
    return solved;
  };
  const TissueStepReport step =
      step_tissue(tissue.mesh, problem.tissue, tissue.time, tau, problem.step, solve, tissue.system, tissue.state);
  report.converged = step.converged;
  report.residual = step.residual;
  report.newton_iterations = step.newton_iterations;
  report.solver_iterations = step.linear_iterations;
  report.equilibrium_error = step.equilibrium_error;
  ++tissue.frame;
  tissue.time = tissue.frame * tau;
  report.time = tissue.time;
  const Eigen::VectorXd no_impulse;
  add_tissue_work(problem, tissue, before, no_impulse, energy);
  report.times.update_ms += watch.lap();

  EndedStep ended{before.v, no_impulse};
  ended.time = (tissue.frame - 1) * tau;
  follow_solution(problem, ended, tissue, energy, report);
  watch.lap();
  const TissueEnergy stored = tissue_energy(tissue.mesh, tissue.state, tissue.time);
  energy.kinetic = stored.kinetic;
  energy.elastic = stored.elastic;
  close(energy);
  report.energy = energy;
  report.times.update_ms += watch.lap();
  return report;
}

void follow_solution(const MotionProblem& problem, const EndedStep& step, Tissue& tissue, EnergyLedger& energy,
                     FrameReport& report) {
  if (step.forces_jump && tissue.releasing()) end_release(tissue.release, tissue.mesh);
  if (!problem.estimate_error && !problem.adapt) return;
  Stopwatch watch(problem.stage_clock);
  tissue.estimate = estimate_error(tissue.mesh.d, tissue.state.u, problem.estimator);
  const ErrorEstimate& estimate = tissue.estimate;
  report.eta = estimate.relative;
  report.eta_local_max = estimate.energy_norm > 0.0 ? estimate.eta.maxCoeff() / estimate.energy_norm : 0.0;
  report.times.estimate_ms += watch.lap();
  if (!problem.adapt) return;
  FrameAdaptRules rules = *problem.adapt;
  const double energy_now = estimate.energy_norm * estimate.energy_norm;
  tissue.largest_energy = std::max(tissue.largest_energy, energy_now);
  rules.energy_floor = std::max(rules.energy_floor, energy_at_rest * tissue.largest_energy);
  report.at_rest = energy_now < rules.energy_floor;
  report.tolerance_ratio = tolerance_ratio(estimate, rules);
  report.tolerance_met = asks_for_tolerance(rules) && report.tolerance_ratio <= 1.0;
  const Eigen::VectorXd von_mises = cell_von_mises(tissue.mesh.d, tissue.state.u);
  const FrameMarks marks = mark_frame(tissue.forest, tissue.mesh.d.mesh, estimate, von_mises, tissue.frame,
                                      tissue.mesh.d.dof_count(), rules, tissue.history);
  report.limit = marks.limit;
  report.times.mark_ms += watch.lap();
  if (marks.empty()) return;
  const int toggles = tissue.history.toggles;
  const FrameChange change = adapt_forest(tissue.mesh.d.mesh, marks, tissue.frame, tissue.forest, tissue.history);
  report.refined = change.refined;
  report.coarsened = change.coarsened;
  report.toggles = tissue.history.toggles - toggles;
  TissueMesh mesh = build_tissue_mesh(tissue.forest, problem.tissue);
  report.times.topology_ms += watch.lap();
  TransferLedger ledger;
  TissueState state = transfer_state(tissue.mesh, tissue.state, mesh, &ledger, tissue.time);
  if (rules.release > 1 && !step.forces_jump)
    release_change(problem.tissue, tissue.mesh, tissue.state, state, step, problem.time_step, rules.release, mesh,
                   tissue.release);
  tissue.state = std::move(state);
  energy.dissipated -= ledger.elastic_change + ledger.kinetic_change;
  tissue.mesh = std::move(mesh);
  tissue.mesh_changed = true;
  report.times.transfer_ms += watch.lap();
}

std::vector<double> state_values(const Tissue& tissue) {
  std::vector<double> values(tissue.state.u.data(), tissue.state.u.data() + tissue.state.u.size());
  values.insert(values.end(), tissue.state.v.data(), tissue.state.v.data() + tissue.state.v.size());
  const MeshChangeRelease& release = tissue.release;
  values.insert(values.end(), release.pending.data(), release.pending.data() + release.pending.size());
  values.insert(values.end(), release.frames_left.begin(), release.frames_left.end());
  return values;
}

}  // namespace finegauge
