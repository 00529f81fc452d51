#pragma once

#include <optional>
#include <vector>

#include "core/adapt/error_estimate.hpp"
#include "core/adapt/frame_adaptivity.hpp"
#include "core/mesh/refinement_forest.hpp"
#include "core/mesh_change_release.hpp"
#include "core/solve/step_solver.hpp"
#include "core/stopwatch.hpp"
#include "core/tissue_step.hpp"

namespace finegauge {

/// A body that moves in time on a mesh that may follow it.
struct MotionProblem {
  TissueProblem tissue;
  double time_step = 1e-2;  ///< τ [s]
  TissueStepOptions step;
  StepSolverOptions solver;
  bool estimate_error = true;  ///< every frame; needed by `adapt`
  Estimator estimator = Estimator::spr;
  std::optional<FrameAdaptRules> adapt;
  StageClock stage_clock = {};  ///< what FrameTimes are read from
};

/// The body and its mesh between two frames.
struct Tissue {
  RefinementForest forest;
  TissueMesh mesh;
  TissueState state;
  ErrorEstimate estimate;  ///< of the last frame, on the mesh that it was solved on
  FrameAdaptHistory history;
  MeshChangeRelease release;  ///< of changes of the mesh that are still spread over frames
  TissueSystem system;        ///< buffers
  StepSolver solver;
  double largest_energy = 0.0;  ///< ∫ ε:σ so far [J]
  bool mesh_changed = true;     ///< since the solver last saw a matrix
  double time = 0.0;            ///< [s]
  int frame = 0;

  /// To be asked before anything of `release` is called: a scene without adaptivity runs none of it.
  bool releasing() const { return !release.frames_left.empty(); }
};
/// At rest, undeformed but for supports that hold displacements at time zero from the first step on.
Tissue start_tissue(RefinementForest forest, const MotionProblem& problem);

/// Milliseconds of wall time of a frame's stages (MotionProblem::stage_clock).
struct FrameTimes {
  double assemble_ms = 0.0;  ///< rotations, forces, A, b of the tissue
  double needle_ms = 0.0;    ///< the same of the needle, and its factor
  double contact_ms = 0.0;   ///< location, rows, transitions
  double solve_ms = 0.0;
  double update_ms = 0.0;  ///< state, energies, equilibrium error
  double estimate_ms = 0.0, mark_ms = 0.0, topology_ms = 0.0, transfer_ms = 0.0;
  double total() const {
    return assemble_ms + needle_ms + contact_ms + solve_ms + update_ms + estimate_ms + mark_ms + topology_ms +
           transfer_ms;
  }
};

/// Energies since the start [J]: kinetic + elastic = work - dissipated + closure.
struct EnergyLedger {
  double kinetic = 0.0, elastic = 0.0;
  double work = 0.0;        ///< by loads, gravity, moving supports, the needle's base, and `release`
  double release = 0.0;     ///< the part of `work` by the loads that spread changes of the mesh over frames
  double dissipated = 0.0;  ///< by damping, friction, cutting, the time integration, and lost in coarsening
  double closure = 0.0;     ///< what the balance leaves over: zero for linear problems, but for round-off
};

/// What a frame tells of itself.
struct FrameReport {
  int frame = 0;
  double time = 0.0;                           ///< at its end [s]
  int dofs = 0, cells = 0, hanging_nodes = 0;  ///< of the mesh that the frame was solved on
  bool converged = true;                       ///< all solves of the frame
  double residual = 0.0;                       ///< relative, of the linear system
  double violation = 0.0;                      ///< of constraints, over the fastest speed of the base
  double equilibrium_error = 0.0;              ///< what one linear solve leaves of the implicit step
  int solver_iterations = 0, uzawa_iterations = 0, newton_iterations = 0;
  std::optional<double> eta, eta_local_max;
  bool at_rest = false;                 ///< less energy than the floor: no tolerance is asked
  bool tolerance_met = false;           ///< each that is asked
  double tolerance_ratio = 0.0;         ///< adapt/frame_adaptivity.hpp: above 1 it is missed, by this factor
  AdaptLimit limit = AdaptLimit::none;  ///< of a frame that is marked: why no more cells are refined
  int refined = 0, coarsened = 0;
  int toggles = 0;    ///< of `refined` and `coarsened`: changes taken back within FrameAdaptHistory::toggle_window
  int releasing = 0;  ///< changes of the mesh whose loads acted in the frame
  EnergyLedger energy;
  FrameTimes times;
};

/// One frame: system > solve > update > estimate > mark > adapt > transfer. `energy` goes on from frame to frame.
FrameReport advance_frame(const MotionProblem& problem, Tissue& tissue, EnergyLedger& energy);

/// A report of the mesh as it is.
FrameReport begin_report(const Tissue& tissue);
/// What loads, supports, damping and the time integration did in the step that led from `before` to the present state.
void add_tissue_work(const MotionProblem& problem, const Tissue& tissue, const TissueState& before,
                     const Eigen::VectorXd& constraint_impulse, EnergyLedger& energy);
/// closure = kinetic + elastic - work + dissipated.
void close(EnergyLedger& energy);

/// Share of the largest energy so far below which a body counts as at rest, beside FrameAdaptRules::energy_floor: η is
/// a ratio, and what is left of a motion that decays has an error of its own size. After an exit the energy falls by a
/// decade or two in each frame: 1e-5 or 1e-11 move the last coarsening by two frames, and change nothing before it.
inline constexpr double energy_at_rest = 1e-8;

/// The second half of every frame, with a needle or without: estimate, mark, adapt, transfer. Fills the report's fields
/// of these stages and adds to the ledger what coarsening loses. `step` is the one that led to the present state.
void follow_solution(const MotionProblem& problem, const EndedStep& step, Tissue& tissue, EnergyLedger& energy,
                     FrameReport& report);

/// All numbers that decide what happens next, in a fixed order, for state hashes: nodal u and v, loads that
/// spread changes of the mesh.
std::vector<double> state_values(const Tissue& tissue);

}  // namespace finegauge
