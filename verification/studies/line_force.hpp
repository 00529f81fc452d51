#pragma once

#include <string>
#include <vector>

namespace finegauge {

/// A force on a line: the needle that pulls the tissue along its axis.
///
/// The square [-1, 1]² m, one cell thick, u_z = 0 on its sides, u_x = u_y = 0 throughout: u_z solves -G Δu = f δ. The
/// load f [N/m] acts on the line x = y = 0, a node line, through the coupling of core/needle/tissue_coupling.hpp, and
/// the displacement is sampled through the same weights: energy per force. Cells are halved around the line only.
///
/// A point has no mesh limit: its displacement rises by f ln 2 / (2 π G) with every halving. A circle of radius r has
/// one, f ln(R/r) / (2 π G), exactly: R is the square's conformal radius at its centre, √2 m / (ϖ/2), ϖ/2 =
/// ∫₀¹ dw / √(1 - w⁴) (Pólya & Szegő 1951), and the mean of a harmonic function over a circle is its value at the
/// centre. A ring of n points is n points again: once cells are small beside the points' distance, an n-th of the rise
/// is back.
struct LineForceOptions {
  double radius = 0.0;  ///< of the ring [m]; 0: the point
  int ring_points = 8;  ///< of the ring
  int levels = 8;       ///< halvings
  double zone = 6.0;    ///< cells are halved whose centre is nearer to the ring than this times their size
};
struct LineForceRow {
  double h;   ///< size of the cells at the line [m]
  int cells;  ///< of the mesh
  int hanging_nodes;
  double displacement;  ///< G u / f where the force acts
  double rise;          ///< from the row before; 0 in the first
  double at_distance;   ///< G u / f at (1/2, 0), which the coupling does not change
};
std::vector<LineForceRow> line_force_table(const LineForceOptions& options);

inline constexpr double line_force_rise = 0.110317800075;  ///< ln 2 / (2 π)
/// G u / f of the circle's mean: ln(R/r) / (2 π).
double spread_line_displacement(double radius);
/// G u / f of the point at (x, 0), 0 < x < 1: Green's function of the square by separation of variables.
double line_displacement_at(double x);

std::string to_string(const std::vector<LineForceRow>& rows);

}  // namespace finegauge
