#pragma once

namespace finegauge {

/// Which share of the squares of the true error plain recovery shows in the cells of the ladder's crack in tetrahedra
/// that lie farther from its tip than 0.3 of its length: of the nodal values of the exact field, and of the solution,
/// which the tip pollutes everywhere (Babuška, Strouboulis, Mathur, Upadhyay 1994).
struct SquaresShown {
  double of_interpolant, of_solution;
};
SquaresShown squares_shown_far_from_tip();

}  // namespace finegauge
