#pragma once

#include <string>
#include <vector>

#include "core/tissue_step.hpp"
#include "verification/support/convergence.hpp"

namespace finegauge {

/// A clamped bar of two cells, one of them refined 2x3x3, in linear tissue, started in one of its eigenmodes: the
/// mode's amplitude is a linear oscillator that every step moves as backward Euler says.
struct OscillatorCase {
  int mode = 0;                    ///< from the slowest
  double omega_tau = 1.0;          ///< ω τ, undamped
  double mass_damping = 0.0;       ///< α / ω, Rayleigh
  double stiffness_damping = 0.0;  ///< β ω
  int steps = 1;
};
struct OscillatorRow {
  OscillatorCase the_case;
  double omega = 0.0;                                 ///< [rad/s]
  double amplitude_factor = 0.0, energy_ratio = 0.0;  ///< per step, mean over the steps
  double phase = 0.0;                                 ///< per step [rad], undamped only
  double damping_ratio = 0.0;                         ///< ζ of the damped oscillation that has the step's eigenvalues
  double largest_error = 0.0;  ///< over the steps, against the closed form of backward Euler, relative to the start
  double other_modes = 0.0;    ///< what left the mode, relative to the start
  int hanging_nodes = 0;
};
OscillatorRow run_oscillator(const OscillatorCase& the_case);

/// Error of a mode's displacement after 1.3 periods against the exact cosine, for numbers of steps that double.
ErrorSeries oscillator_temporal_errors(int coarsest_steps, int grids);

/// What many steps without load do to energy and momenta, from random displacements and velocities. Linear tissue is
/// clamped at one end; corotational tissue is free and spins.
struct EnergyRow {
  Kinematics kinematics = Kinematics::linear;
  double tau = 0.0;  ///< [s]
  int steps = 0;
  double largest_growth = 0.0;  ///< of one step, over the energy at the start; negative where it always fell
  double summed_growth = 0.0;   ///< of all steps that grew
  double final_energy = 0.0;    ///< over the energy at the start
  double momentum_drift = 0.0;  ///< relative; of a free body round-off
  double angular_drift = 0.0;   ///< relative, about the origin; reported, not bounded
  int hanging_nodes = 0;
};
EnergyRow run_unloaded_motion(Kinematics kinematics, double tau, int steps);
std::string energy_table(const std::vector<EnergyRow>& rows);

/// One step of a cantilever that swings down under gravity, from a state in mid-swing (its end has turned far), solved
/// once and by Newton.
struct SwingRow {
  double tau = 0.0;           ///< [s]
  double single_error = 0.0;  ///< equilibrium_error of the single linear solve
  int newton_iterations = 0;  ///< to newton_residual 1e-9, mixed
  double newton_error = 0.0;
  bool converged = false;
  int plain_iterations = 0;  ///< without mixing; 0: none, it did not converge in 100
};
struct Swing {
  double end_turned = 0.0;  ///< direction of the bar's end against its rest direction [rad]
  std::vector<SwingRow> rows;
};
Swing run_swing(const std::vector<double>& taus);
std::string swing_table(const Swing& swing);

}  // namespace finegauge
