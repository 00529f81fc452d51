#pragma once

#include <complex>
#include <functional>
#include <string>
#include <vector>

#include "core/tissue_step.hpp"
#include "verification/studies/manufactured_static.hpp"
#include "verification/support/convergence.hpp"
#include "verification/support/evidence.hpp"
#include "verification/support/manufactured_solution.hpp"

// Motion u(X, t) = f(X) g(t) of linear tissue that is held all around: supports follow by their course, and the body
// force ρ f (g'' + α g') - div σ(f) (g + β g') is integrated once per factor of time and added up anew for every step,
// in TissueMesh::loads: the loads of a TissueProblem are constant.
//
// The mass is lumped by rows. In the weak form that is the mean of each product at the corners in place of its
// integral, off by h² ∇f·∇v / 6: of the order of the trilinear cells' own error, and of the other sign than that
// of the consistent mass. It takes no order away, on meshes with hanging nodes neither; waves run slower by (k h)²/24.

namespace finegauge {

/// Re(size e^(rate t)): each of its derivatives is one factor more, and exact.
struct TimeCourse {
  std::complex<double> size, rate;  ///< [1], [1/s]

  double operator()(double t, int derivative = 0) const;
};

struct MovingCase {
  std::string name;  ///< words joined by underscores
  ManufacturedSolution field;
  TimeCourse course{{0.8, 0.3}, {-0.3, 2.0}};
  CubeMesh mesh;
  Material material;               ///< E = 1e3, nu = 0.3; linear
  double density = 1000.0;         ///< with E a wave runs the cube's edge in about one second
  double mass_damping = 0.0;       ///< α [1/s]
  double stiffness_damping = 0.0;  ///< β [s]
  double duration = 1.0;           ///< [s]
  bool lumped_inertia = false;     ///< the force of inertia by the lumped mass and not by integration
};

/// Trilinear in space, with all eight terms among its components: cells of a regular mesh represent it, and at inner
/// nodes its integral with the node's function is its value there times the node's mass. The only error left is that of
/// time.
ManufacturedSolution trilinear_solution();

/// The end of a motion.
struct MovedBody {
  TissueMesh mesh;
  TissueState state;
  double largest_equilibrium_error = 0.0;  ///< of all steps
};
/// Called after each step.
using StepObserver = std::function<void(int steps_done, const TissueMesh&, const TissueState&)>;
/// Throws std::runtime_error when a step fails.
MovedBody run_manufactured_motion(const MovingCase& the_case, int n, int steps, const StepObserver& observe = {});

/// Errors at the end on one mesh for numbers of steps that double.
struct TimeRow {
  int steps = 0;
  double tau = 0.0;          ///< [s]
  double error = 0.0;        ///< of the displacement, mass norm over the nodes, relative
  double predicted = 0.0;    ///< the term of first order in τ, see first_order_error
  double space_error = 0.0;  ///< what extrapolation to τ = 0 leaves, from this row and the one before; relative
};
std::vector<TimeRow> time_rows(const MovingCase& the_case, int n, int coarsest_steps, int grids);

/// The error's factor of τ at the end, mass norm [√kg m]. Backward Euler differs from M u'' + C u' + K u = F by
/// -τ (M u''' + ½ C u'') and starts with a velocity that is late by half a step, so its error is τ e with
///   M e'' + C e' + K e = M u''' + ½ C u'',  e(0) = 0,  e'(0) = ½ u''(0),  e = 0 where the body is held.
/// Solved mode by mode, by Runge and Kutta's method in steps that are not those of the motion.
double first_order_error(const MovingCase& the_case, int n);

/// One grid of a motion with τ proportional to h². Root mean squares over eight instants, relative to those of the
/// exact solution: what the start on a mesh leaves ringing has another phase at each.
struct SpaceRow {
  int n = 0, steps = 0, dofs = 0, hanging_nodes = 0;
  double displacement_error = 0.0, velocity_error = 0.0;  ///< L2
  double energy_error = 0.0;                              ///< of the elastic energy norm
  double energy_over_leading = 0.0;                       ///< over leading_energy_error; zero where cells are no boxes
  double equilibrium_error = 0.0;
};
SpaceRow space_row(const MovingCase& the_case, int n, int steps);

struct SpaceTable {
  std::string name;
  std::vector<SpaceRow> rows;  ///< coarsest first

  ErrorSeries displacement() const, velocity() const, energy() const;
};
/// On the coarsest grid with the given number of steps.
SpaceTable space_table(const MovingCase& the_case, const std::vector<int>& grids, int coarsest_steps);

/// What the inertia's force by the lumped mass in place of its integral does to the displacement, over the same
/// instants, on one mesh.
struct LumpingRow {
  int n = 0;
  double shift = 0.0;  ///< L2, relative to the exact solution
};
std::vector<LumpingRow> lumping_shifts(const MovingCase& the_case, const std::vector<int>& grids, int coarsest_steps);

/// Standing waves along a bar that can only shorten and lengthen, of half a wave on its length of 1: the lumped mass's
/// frequency has a closed form.
struct StandingWaveRow {
  int cells = 0;
  double frequency = 0.0;       ///< of the discrete body over the exact one
  double closed_form = 0.0;     ///< sin(k h/2) / (k h/2)
  double shape_residual = 0.0;  ///< ‖K x - ω² M x‖ / ‖K x‖ in free directions, x the sine at the nodes
};
std::vector<StandingWaveRow> standing_waves(const std::vector<int>& cells);

/// The motions whose error is followed in space.
std::vector<MovingCase> moving_cases();

Evidence manufactured_dynamics_evidence(const EvidenceOptions& options);

}  // namespace finegauge
