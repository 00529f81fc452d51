#pragma once

#include <optional>
#include <vector>

#include "core/needle/interaction.hpp"
#include "core/needle/needle_contacts.hpp"
#include "core/needle/needle_drive.hpp"
#include "core/needle/needle_step.hpp"
#include "core/tissue_frame.hpp"

namespace finegauge {

/// A needle driven into a body.
struct InsertionProblem {
  MotionProblem motion;  ///< of the tissue
  Needle needle;
  NeedleDrive drive;
  ContactRules contact;
  InteractionOptions interaction;
};

struct Insertion {
  Tissue tissue;
  NeedleState needle;
  NeedleSystem needle_system;  ///< buffers
  NeedleContacts contacts;
  std::vector<SpreadPoint> places;           ///< buffer
  Eigen::Vector3d axis;                      ///< unit, from base to tip at rest
  std::optional<double> first_touch_travel;  ///< of the tip along the axis when it first pressed on the tissue [m]
  EnergyLedger energy;
};
/// Throws std::invalid_argument when the needle starts in the body, on its surface, or across it between two nodes.
Insertion start_insertion(RefinementForest forest, const InsertionProblem& problem);

struct InsertionReport {
  FrameReport frame;
  double tip_displacement = 0.0;  ///< travel of the tip along the axis since first touch [m]
  double insertion_depth = 0.0;   ///< inserted length [m]
  double force = 0.0;             ///< all axial needle-tissue interaction [N], positive against insertion
  double tip_force = 0.0, shaft_force = 0.0;
  double across_force = 0.0;       ///< share in `force` of what holds a bent needle across itself [N]
  double tip_lateral_force = 0.0;  ///< across the needle [N]
  double base_force = 0.0;         ///< what drives the base, along the axis [N], positive for pushing
  TipState tip_state = TipState::outside;
  int contact_points = 0;
  std::vector<ContactEvent> events;
};

/// One frame: systems of tissue and needle > contact rows > augmented Lagrangian > update > contact transitions >
/// estimate > mark > adapt > transfer.
InsertionReport advance_frame(const InsertionProblem& problem, Insertion& insertion);

/// All numbers that decide what happens next, in a fixed order, for state hashes: nodal u and v, the needle's state,
/// contact points and multipliers.
std::vector<double> state_values(const Insertion& insertion);

}  // namespace finegauge
