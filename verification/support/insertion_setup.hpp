#pragma once

#include <array>
#include <vector>

#include "core/insertion_frame.hpp"

namespace finegauge {

/// What one metre, kilogram and second are in the units that a case is computed in.
struct UnitSystem {
  double length = 1.0, mass = 1.0, time = 1.0;

  double force() const { return mass * length / (time * time); }
  double pressure() const { return mass / (length * time * time); }
};

/// A straight needle that enters a block through x = 0 along x. The block is clamped on x_max; all in SI, turned into
/// `units` by insertion_case.
struct InsertionSetup {
  Eigen::Vector3d size{0.04, 0.02, 0.02};  ///< of the block [m]
  std::array<int, 3> cells{9, 4, 4};
  std::optional<RemovedBlock> removed;
  double youngs_modulus = 1e7, poisson_ratio = 0.4, density = 1000.0;
  Kinematics kinematics = Kinematics::corotational;
  std::vector<std::string> clamped{"x_max"};
  double stiffness_damping = 1e-3;  ///< [s]
  NeedleProperties needle{5e7, 0.3, 1e-3, 1000.0};
  double needle_length = 0.032;  ///< [m]
  int elements = 16;
  Eigen::Vector3d entry{0.0, 0.01, 0.01};  ///< where the axis meets the block [m]
  double start_distance = 5e-4;            ///< of the tip before the block [m]
  ContactRules contact{.puncture_strength = 5.0,
                       .cut_strength = 5.0,
                       .cut_advance = 2e-3,
                       .friction_in = 0.5,
                       .friction_out = 0.5,
                       .surface_friction = 0.8,
                       .clamping = 300.0,
                       .coupling_radius = 1e-3};
  std::vector<Stroke> strokes{{{0.012, 0.0, 0.0}, 0.6}};
  double time_step = 5e-3;  ///< [s]
  std::optional<FrameAdaptRules> adapt;
  InteractionOptions interaction;
  TissueStepOptions step;
  StepSolverOptions solver;
  bool estimate_error = false;
  UnitSystem units;
};

/// A linear block of coarse cells and residuals of round-off: puncture, cuts, and a hold until nothing moves, after 500
/// frames. Whatever slid has stopped where the forces balance.
InsertionSetup held_insertion();

struct InsertionCase {
  InsertionProblem problem;
  RefinementForest forest;
};
InsertionCase insertion_case(const InsertionSetup& setup);

/// Frames from the start until the time is over; `insertion` is left in the last state.
struct InsertionRun {
  std::vector<InsertionReport> frames;
  Insertion insertion;

  int unconverged() const;
  std::vector<ContactEvent> events(ContactEventKind kind) const;
};
InsertionRun run_insertion(const InsertionSetup& setup, int frames);

}  // namespace finegauge
