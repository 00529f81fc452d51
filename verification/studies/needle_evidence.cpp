#include "verification/studies/needle_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "core/space/assembly.hpp"
#include "verification/studies/beam_benchmarks.hpp"
#include "verification/studies/line_force.hpp"
#include "verification/support/insertion_setup.hpp"

namespace finegauge {

namespace {

using Eigen::Vector3d;

/// Figures beside their targets; each is a claim on the difference.
class Comparison {
 public:
  Comparison(std::string title, Evidence& evidence) : evidence_(evidence), at_(evidence.tables.size()) {
    evidence.tables.push_back({std::move(title), {"figure", "found", "target", "relative difference"}, {}});
  }
  /// `tolerance` is relative to the target.
  void add(const std::string& figure, double found, double target, double tolerance, std::string reason) {
    const double difference = found / target - 1.0;
    evidence_.tables[at_].rows.push_back({figure, found, target, difference});
    evidence_.claim(figure + "_difference", difference, -tolerance, tolerance, std::move(reason));
  }

 private:
  Evidence& evidence_;
  std::size_t at_;
};

double largest_component(const Vector3d& difference) { return difference.cwiseAbs().maxCoeff(); }

// Problem by problem. Bounds are those of beam_benchmarks_test.cpp and line_force_test.cpp, whose reasons they repeat.

void show_cantilevers(Evidence& evidence) {
  EvidenceTable table{"A cantilever's tip, against P L^3 / 3 EI + P L / k GA",
                      {"length / radius", "elements", "error of one solve", "error of the equilibrium"},
                      {}};
  double linear = 0.0, largest = 0.0, smallest_of_one = std::numeric_limits<double>::infinity();
  for (const double slenderness : {2.0, 10.0, 100.0, 1e4})
    for (const int elements : {1, 4, 32}) {
      const TimoshenkoRow row = timoshenko_cantilever(slenderness, elements);
      table.rows.push_back({slenderness, double(elements), row.linear, row.equilibrium});
      linear = std::max(linear, row.linear / (1e-16 * 50.0 * std::pow(elements, 4) + 1e-15));
      largest = std::max(largest, row.equilibrium);
      if (elements == 1) smallest_of_one = std::min(smallest_of_one, row.equilibrium);
    }
  evidence.tables.push_back(std::move(table));
  evidence.claim("cantilever_linear_error_over_round_off", linear, 0.0, 1.0,
                 "exact for end loads: round-off times the condition of a chain, 50 elements^4");
  evidence.claim("cantilever_equilibrium_error", largest, 0.0, 3e-12,
                 "the equilibrium's own nonlinearity, (deflection / length)^2 = 1e-12");
  evidence.claim("cantilever_equilibrium_error_of_one_element", smallest_of_one, 3e-13, 3e-12,
                 "the same: below a third of it would be luck");
}

void show_roll_up(Evidence& evidence) {
  EvidenceTable table{"A cantilever rolled up by a tip moment t EI / L, against the circle (Simo & Vu-Quoc 1986)",
                      {"t / 2 pi", "elements", "in the plane", "error of the tip / L", "error of the angle [rad]"},
                      {}};
  double closed = 0.0, two_turns = 0.0;
  const auto show = [&](double t, int elements, int steps, bool planar) {
    const RollUpRow row = roll_up(t, elements, steps, planar);
    table.rows.push_back(
        {t / (2.0 * std::numbers::pi), double(elements), planar ? "yes" : "no", row.tip_error, row.angle_error});
    return row;
  };
  for (const bool planar : {true, false})
    for (const int elements : {3, 8, 64}) {
      const RollUpRow row = show(2.0 * std::numbers::pi, elements, 9, planar);
      closed = std::max({closed, row.tip_error, row.angle_error});
    }
  const RollUpRow twice = show(4.0 * std::numbers::pi, 16, 19, true);
  two_turns = std::max(twice.tip_error, twice.angle_error);
  constexpr double t = 3.0;
  ErrorSeries series{"tip", {}, {}};
  for (const int n : {16, 32, 64}) {
    series.h.push_back(1.0 / n);
    series.error.push_back(show(t, n, 9, true).tip_error);
  }
  evidence.tables.push_back(std::move(table));
  evidence.claim("roll_up_closed_circle_error", closed, 0.0, 1e-10,
                 "a polygon of any number of equal sides and angles closes: the residual's tolerance 1e-11 remains");
  evidence.claim("roll_up_two_turns_error", two_turns, 0.0, 1e-10,
                 "the same after two turns: rotations leave no trace");
  evidence.claim("roll_up_order", last_order(series), 1.95, 2.05, "chords for an arc: second order");
  const double tip_distance = 2.0 * std::abs(std::sin(0.5 * t)) / t;
  evidence.claim("roll_up_error_over_theory", series.error.back() / (t * t / 64.0 / 64.0 / 24.0 * tip_distance),
                 1.0 - 1e-3, 1.0 + 1e-3,
                 "64 chords with the circle's angles have its radius times 1 + (t / 64)^2 / 24 + O(4): the constant");
}

void show_elastica(Evidence& evidence) {
  const ElasticaTip published = exact_elastica(1.0);
  {
    Comparison figures("The elastica's elliptic integrals at P L^2 / EI = 1, against printed digits", evidence);
    figures.add("elastica_w", published.w, 0.3017207738, 5e-10, "ten printed digits (Batista 2016)");
    figures.add("elastica_u", published.u, 0.0564332363, 2e-9, "ten decimals");
    figures.add("elastica_angle", published.angle, 0.4613519, 2e-7, "seven decimals");
  }
  Comparison figures("A cantilever under a dead load, beams extrapolated from 32 and 64 elements, against the elastica",
                     evidence);
  for (const double load : {1.0, 10.0}) {
    const std::string name = load == 1.0 ? "elastica_load_1_" : "elastica_load_10_";
    const ElasticaTip exact = exact_elastica(load), coarse = beam_elastica(load, 32, 10),
                      fine = beam_elastica(load, 64, 10);
    const std::string reason = "the next term, h^4, and EA = 1e8 EI / L^2, which shortens by 1e-8 of the load: 3e-7 L";
    const auto show = [&](const char* what, double ElasticaTip::*part) {
      figures.add(name + what, (4.0 * fine.*part - coarse.*part) / 3.0, exact.*part, 3e-7 / exact.*part, reason);
      const double order = std::log2((coarse.*part - exact.*part) / (fine.*part - exact.*part));
      // The shortening's error changes its sign near ten with eight elements: it needs finer ones.
      const double band = load > 5.0 && what[0] == 'u' ? 0.1 : 0.05;
      evidence.claim(name + what + "_order", order, 2.0 - band, 2.0 + band, "straight elements on a curve");
    };
    show("w", &ElasticaTip::w);
    show("u", &ElasticaTip::u);
    show("angle", &ElasticaTip::angle);
  }
}

void show_bend(Evidence& evidence) {
  const Vector3d exact(15.684689, 47.150096, 53.475478), square(15.557676, 46.891586, 53.607986),
      arc(29.2893218813452, 70.7106781186547, 0.0);
  EvidenceTable table{"The 45 degree bend (Bathe & Bolourchi 1979) under 600: displacement of the tip",
                      {"from", "x", "y", "z", "distance of the tip from the reference"},
                      {}};
  const auto show = [&](const std::string& from, const Vector3d& tip) {
    const Vector3d u = tip - arc;
    table.rows.push_back({from, u.x(), u.y(), u.z(), (tip - exact).norm()});
  };
  ErrorSeries series{"tip", {}, {}};
  std::vector<Vector3d> tips;
  for (const int chords : {16, 32, 64}) {
    tips.push_back(bend_45({.chords = chords}).position);
    series.h.push_back(1.0 / chords);
    series.error.push_back((tips.back() - exact).norm());
    show(std::to_string(chords) + " elements", tips.back());
  }
  const Vector3d extrapolated = (4.0 * tips[2] - tips[1]) / 3.0;
  show("extrapolated", extrapolated);
  show("reference: the true arc, converged, two independent solvers", exact);
  show("published: Bathe & Bolourchi 1979, 8 elements", arc + Vector3d(-13.4, -23.5, 53.4));
  show("published: BeamDyn 2015", arc + Vector3d(-13.5, -23.7, 53.4));
  const auto with_square = [](int chords) {
    return bend_45({.chords = chords, .torsion_constant = 0.140577}).position;
  };
  const Vector3d square_extrapolated = (4.0 * with_square(64) - with_square(32)) / 3.0;
  show("extrapolated, J of the square itself", square_extrapolated);
  evidence.tables.push_back(std::move(table));
  evidence.claim("bend_16_elements_relative_error", (tips[0] - exact).cwiseQuotient(exact).cwiseAbs().maxCoeff(), 0.0,
                 1e-3, "polygon and beam each leave some 0.02 of 50");
  evidence.claim("bend_order", last_order(series), 1.95, 2.05, "chords for an arc: second order");
  evidence.claim("bend_extrapolated_error", largest_component(extrapolated - exact), 0.0, 1e-5,
                 "the reference's six decimals and the next term, h^4");
  evidence.claim("bend_square_torsion_error", largest_component(square_extrapolated - square), 0.0, 3e-5,
                 "the same; J = 0.140577 has six decimals, and moves the tip by 0.32");
  // Published displacements are those of coarse meshes, printed with three digits.
  const Vector3d bathe(-13.4, -23.5, 53.4), found = extrapolated - arc;
  evidence.claim("bend_against_bathe", (found - bathe).norm() / bathe.norm(), 0.0, 5e-3,
                 "eight elements and three digits: five tenths of a percent of the way");
  // The way to the load leaves no trace.
  const Vector3d eight = bend_45({.steps = 8}).position;
  evidence.claim("bend_path_8_and_10_steps", (bend_45({.steps = 10}).position - eight).norm(), 0.0, 1e-9,
                 "the residual's tolerance, 1e-11 of 600, times a compliance of 0.1");
  evidence.claim("bend_path_8_and_2_steps", (bend_45({.steps = 2}).position - eight).norm(), 0.0, 1e-9, "the same");
}

void show_lee(Evidence& evidence) {
  Comparison figures("Lee's frame at its first limit load, extrapolated from 20 and 40 elements a leg", evidence);
  for (const bool shear : {false, true}) {
    const LeeLimit coarse = lee_frame(shear, 10), middle = lee_frame(shear, 20), fine = lee_frame(shear, 40);
    const double load = shear ? 1.854453 : 1.855673, vertical = shear ? 48.754 : 48.735,
                 horizontal = shear ? 26.878 : 26.880;
    const std::string name = shear ? "lee_with_shear_" : "lee_without_shear_";
    figures.add(name + "load", (4.0 * fine.load - middle.load) / 3.0, load, 1e-5 / load,
                "the target's six decimals and h^4; shear is 1.2e-3");
    figures.add(name + "vertical", (4.0 * fine.vertical - middle.vertical) / 3.0, vertical, 5e-3 / vertical,
                "the target's three decimals; the place of a maximum, by a parabola");
    figures.add(name + "horizontal", (4.0 * fine.horizontal - middle.horizontal) / 3.0, horizontal, 5e-3 / horizontal,
                "the same");
    evidence.claim(name + "order", std::log2((coarse.load - load) / (middle.load - load)), 1.95, 2.05,
                   "straight elements");
    evidence.claim(name + "pivots_lost", fine.pivots_after - fine.pivots_before, 1.0, 1.0,
                   "at a limit point the tangent loses one direction");
  }
}

constexpr NeedleProperties phantom{.youngs_modulus = 5e7};
constexpr double phantom_length = 0.032;  // [m]

/// c of c EI / L².
double euler_factor(NeedleTip tip) {
  constexpr double pi = std::numbers::pi, first_root = 4.493409457909064;  // of tan x = x
  return tip == NeedleTip::free ? 0.25 * pi * pi : tip == NeedleTip::pinned ? first_root * first_root : 4.0 * pi * pi;
}

/// P from P s = P (1 - P / EA).
double uncompressed(double compressed) {
  const double EA = round_section(phantom).EA;
  return 2.0 * compressed / (1.0 + std::sqrt(1.0 - 4.0 * compressed / EA));
}

std::string to_string(NeedleTip tip) {
  return tip == NeedleTip::free ? "free" : tip == NeedleTip::pinned ? "pinned" : "fixed";
}

void show_buckling(Evidence& evidence, bool full) {
  EvidenceTable table{"The phantom needle pressed along itself: load at which the straight needle turns unstable [N]",
                      {"tip", "16 elements", "chain of 16", "extrapolated", "with shear and compression", "Euler's"},
                      {}};
  const BeamSection section = round_section(phantom);
  for (const NeedleTip tip : {NeedleTip::free, NeedleTip::pinned, NeedleTip::fixed}) {
    const BucklingRow row = needle_buckling(tip, full ? std::vector{16, 32, 64, 128, 256} : std::vector{16, 32, 64});
    const std::string name = "buckling_" + to_string(tip);
    const bool pinned = tip == NeedleTip::pinned;
    const double chain = pinned ? 0.0 : exact_buckling_load_of_chain(tip, row.elements.front());
    table.rows.push_back({to_string(tip), row.found.front(), pinned ? TableValue("-") : TableValue(chain),
                          row.extrapolated, row.exact, row.euler});
    const double printed = tip == NeedleTip::free ? 0.0946 : pinned ? 0.774 : 1.514;
    evidence.claim(name + "_euler_over_printed", row.euler / printed, 1.0 - 1e-3, 1.0 + 1e-3,
                   "the closed form, printed with three or four digits");
    if (!pinned) {
      evidence.claim(name + "_chain_difference", row.found.front() / chain - 1.0, -1e-8, 1e-8,
                     "the chain's own closed form: pivots below round-off, 1e-16 times 16^4, count as lost");
      const double told_apart = std::pow(row.exact / section.GA_2, 2) * (1.0 - 2.0 * section.GA_2 / section.EA);
      evidence.claim(name + "_haringx_apart", (haringx_buckling_load(tip) / row.extrapolated - 1.0) / told_apart, 0.9,
                     1.1, "the other classical formula is larger, by (P / GA)^2 (1 - 2 GA / EA) and the next order");
    }
    // What extrapolation leaves of P (1 + κ²/12 + κ⁴/360), with a tenth for shear.
    const double kappa = std::sqrt(row.euler / section.EI_2) * phantom_length / row.elements.back();
    evidence.claim(name + "_difference", row.extrapolated / row.exact - 1.0, -1.1 * std::pow(kappa, 4) / 90.0 - 1e-8,
                   1e-8, "the chain's next term, (x / n)^4 / 90 after extrapolation, and round-off as above");
    ErrorSeries series{name, {}, {}};
    for (std::size_t k = 0; k < row.found.size(); ++k) {
      series.h.push_back(1.0 / row.elements[k]);
      series.error.push_back(std::abs(row.found[k] - row.exact));
    }
    evidence.claim(name + "_order", last_order(series), 1.95, 2.05, "second order in the elements' length");
    // The force that keeps a pinned tip in place shears, too: tan x = x (1 - q) moves x² by 2 q.
    const double sheared = pinned ? 1.0 + 2.0 / euler_factor(tip) : 1.0;
    evidence.claim(name + "_below_euler",
                   (1.0 - row.exact / row.euler) / (row.euler * (sheared / section.GA_2 - 1.0 / section.EA)), 0.95, 1.0,
                   "what shear takes less what compression gives, P (1 / GA - 1 / EA), to its square");
    evidence.claim(name + "_directions_lost", row.lost, 2.0, 2.0, "a round needle buckles in both planes at once");
  }
  evidence.tables.push_back(std::move(table));
}

void show_turning(Evidence& evidence) {
  EvidenceTable table{"A loaded cantilever whose base makes three full turns",
                      {"base", "largest / least energy", "energy after a turn", "tip after a turn",
                       "third differences at a turn / elsewhere"},
                      {}};
  for (const bool own_axis : {true, false}) {
    TurningBase options;
    options.about_own_axis = own_axis;
    const std::vector<TurningRow> rows = turning_base(options);
    const int turn = options.steps_per_turn, count = static_cast<int>(rows.size());
    double least = rows[0].energy, most = rows[0].energy, energy = 0.0, tip = 0.0, mirror = 0.0;
    for (const TurningRow& row : rows) {
      least = std::min(least, row.energy);
      most = std::max(most, row.energy);
    }
    for (int k = 0; k + turn < count; ++k) {
      energy = std::max(energy, std::abs(rows[k + turn].energy - rows[k].energy));
      tip = std::max(tip, (rows[k + turn].tip - rows[k].tip).norm());
    }
    for (int at = turn; at + 3 < count; at += turn)
      for (int k = 1; k <= 3; ++k) mirror = std::max(mirror, std::abs(rows[at + k].energy - rows[at - k].energy));
    const auto third = [&](int k) {
      return std::abs(rows[k + 2].energy - 3.0 * rows[k + 1].energy + 3.0 * rows[k].energy - rows[k - 1].energy);
    };
    double away = 0.0, across = 0.0;
    for (int k = 1; k + 2 < count; ++k) {
      double& where = std::min(k % turn, turn - k % turn) <= 2 ? across : away;
      where = std::max(where, third(k));
    }
    const std::string name = own_axis ? "spin" : "wheel";
    table.rows.push_back(
        {own_axis ? "spins about its axis" : "wheels across it", most / least, energy, tip, across / away});
    evidence.claim(name + "_energy_range", most / least, 1.5, 1e5, "the angle matters, or the rest shows nothing");
    evidence.claim(name + "_energy_after_a_turn", energy, 0.0, 1e-10, "no memory: the residual's tolerance, 1e-11");
    evidence.claim(name + "_tip_after_a_turn", tip, 0.0, 1e-10, "the same");
    evidence.claim(name + "_kink_at_a_turn", across / away, 0.0, 1.2,
                   "a kink would be a third difference larger than any elsewhere by 1 / step^2 = 15");
    if (own_axis)
      evidence.claim(name + "_mirror", mirror, 0.0, 1e-10, "a spinning beam is its own mirror image about a full turn");
  }
  evidence.tables.push_back(std::move(table));
}

/// `evidence` also takes the rows to read.
std::vector<LineForceRow> line_force_rows(const std::string& title, const LineForceOptions& options,
                                          Evidence& evidence) {
  std::vector<LineForceRow> rows = line_force_table(options);
  EvidenceTable table{title, {"h [m]", "cells", "hanging", "G u / f at the force", "rise", "G u / f at 1/2 m"}, {}};
  for (const LineForceRow& row : rows)
    table.rows.push_back(
        {row.h, double(row.cells), double(row.hanging_nodes), row.displacement, row.rise, row.at_distance});
  evidence.tables.push_back(std::move(table));
  return rows;
}

void show_line_force(Evidence& evidence, bool full) {
  const int levels = full ? 10 : 6;
  const auto point = line_force_rows("A force on a line, at a point of the plane: ln 2 / 2 pi = 0.110318 per halving",
                                     {.levels = levels}, evidence);
  double worst = 0.0;
  for (std::size_t level = point.size() - 4; level < point.size(); ++level)
    worst = std::max(worst, std::abs(point[level].rise / line_force_rise - 1.0));
  evidence.claim("line_force_rise_difference", worst, 0.0, 0.01,
                 "ln 2 / 2 pi per halving, less the square of the refined zone's fineness, 6 cells");
  evidence.claim("line_force_rise_settles", point.back().rise - point[point.size() - 2].rise, -1e-4, 1e-4,
                 "each level adds the same ring of cells; what changes is the coarse mesh's part, by 4 a level");
  evidence.claim("line_force_elsewhere", point.back().at_distance / line_displacement_at(0.5) - 1.0, -2e-3, 2e-3,
                 "1.4 % with cells of 1/4 m there, a quarter per halving, and they are 1/16 m");

  constexpr double radius = 0.1;
  const int ring_levels = full ? 8 : 6;
  const auto ring = line_force_rows("The same spread over a circle of 0.1 m: limit ln(R / r) / 2 pi",
                                    {.radius = radius, .ring_points = 256, .levels = ring_levels}, evidence);
  evidence.claim("spread_line_force_rise", ring.back().rise / line_force_rise, -0.01, 0.01,
                 "a limit: no rise is left in cells of less than a tenth of the radius");
  const double fineness = ring.back().h / radius;
  evidence.claim(
      "spread_line_force_limit", ring.back().displacement / spread_line_displacement(radius) - 1.0, -0.1 * fineness,
      0.1 * fineness,
      "the circle's mean is exact by the mean value property; a line load in cells is off by their share of r");
  evidence.claim("spread_line_force_elsewhere", ring.back().at_distance / line_displacement_at(0.5) - 1.0, -2e-3, 2e-3,
                 "far from the force its spreading makes no difference");
}

void show_balance(Evidence& evidence) {
  EvidenceTable table{"A needle held in a soft block after puncture and cuts: axial force three ways [N]",
                      {"needle", "contact points", "off its line [m]", "on the needle by contact", "by its base",
                       "on the block by its clamp"},
                      {}};
  for (const bool bent : {false, true}) {
    const ForceBalance balance = needle_force_balance(bent ? -0.004 : 0.0);
    const std::string name = bent ? "balance_bent_" : "balance_straight_";
    // The force that a frame reports is that along the needle, point by point, not that on the base's axis.
    table.rows.push_back({bent ? "bent" : "straight", double(balance.points), balance.bend,
                          bent ? TableValue("-") : TableValue(balance.contact), balance.base, balance.clamp});
    evidence.claim(name + "base_force", balance.base, 0.5, 20.0, "there is a force");
    evidence.claim(name + "points", balance.points, 3.0, 100.0, "of tip and shaft");
    evidence.claim(name + "kinetic_share", balance.kinetic_share, 0.0, 1e-12, "equilibrium");
    evidence.claim(name + "clamp_over_base", balance.clamp / balance.base - 1.0, -1e-10, 1e-10,
                   "action and reaction through contact and tissue: the solver's 1e-12 times the condition of a step");
    if (bent) {
      evidence.claim(name + "off_its_line", balance.bend, 1e-5, 1e-3, "bent by the block");
      continue;
    }
    evidence.claim(name + "base_over_contact", balance.base / balance.contact - 1.0, -1e-10, 1e-10,
                   "what pushes the base is what resists along the needle; no inertia is left");
    evidence.claim(name + "momentum_error", balance.momentum_error, 0.0, 1e-10,
                   "in motion, every frame: base minus contact is the change of the needle's momentum, to round-off");
    evidence.claim(name + "inertia", balance.largest_inertia, 1e-6, 10.0, "there was a change of momentum to balance");
  }
  evidence.tables.push_back(std::move(table));
}

}  // namespace

double exact_buckling_load(NeedleTip tip) {
  const BeamSection section = round_section(phantom);
  const double slenderness = section.GA_2 * phantom_length * phantom_length / section.EI_2;
  // q = P s / GA, x² = P s L² / EI (1 - q): x = π/2 and 2π, or tan x = x (1 - q) where a force across keeps the pinned
  // tip in place.
  double x = std::sqrt(euler_factor(tip));
  const auto q = [&](double root) { return root * root / (slenderness + root * root); };
  if (tip == NeedleTip::pinned) {
    double low = std::numbers::pi, high = x;
    for (int step = 0; step < 200; ++step) {
      x = 0.5 * (low + high);
      (std::tan(x) < x * (1.0 - q(x)) ? low : high) = x;
    }
  }
  return uncompressed(q(x) * section.GA_2);
}

double haringx_buckling_load(NeedleTip tip) {
  const BeamSection section = round_section(phantom);
  const double euler = euler_factor(tip) * section.EI_2 / (phantom_length * phantom_length);
  const double slope = 1.0 / section.GA_2 - 1.0 / section.EA;  // P (1 + slope P) = Euler's
  return 2.0 * euler / (1.0 + std::sqrt(1.0 + 4.0 * slope * euler));
}

double exact_buckling_load_of_chain(NeedleTip tip, int elements) {
  const BeamSection section = round_section(phantom);
  const double l = phantom_length / elements, cosine = std::cos(std::sqrt(euler_factor(tip)) / elements);
  const double Phi = 12.0 * section.EI_2 / (section.GA_2 * l * l), a = (4.0 + Phi) / (1.0 + Phi),
               b = (2.0 - Phi) / (1.0 + Phi);
  return uncompressed((a * a - b * b) * (1.0 - cosine) / (a + b * cosine) * section.EI_2 / (l * l));
}

BucklingRow needle_buckling(NeedleTip tip, const std::vector<int>& elements) {
  const BeamSection section = round_section(phantom);
  BucklingRow row;
  row.tip = tip;
  row.euler = euler_factor(tip) * section.EI_2 / (phantom_length * phantom_length);
  row.exact = exact_buckling_load(tip);
  row.elements = elements;
  for (const int n : elements) {
    const Needle needle = straight_needle(phantom, {0.0, 0.0, 0.0}, {phantom_length, 0.0, 0.0}, n);
    HeldDofs held(needle.node_count(), 0u);
    held.front() = hold_all;
    if (tip != NeedleTip::free) held.back() = 6u;
    if (tip == NeedleTip::fixed) held.back() |= hold_rotation;
    const auto pivots = [&](double load) {
      NeedleLoad along;
      along.reference = Eigen::VectorXd::Zero(needle.dof_count());
      along.reference[needle.dof_count() - 6] = -load;
      // The straight equilibrium is known to round-off, 1e-11 of the load: Newton's method need not pass the tangent
      // that is to be singular.
      NeedleEquilibriumOptions options;
      options.residual = 1e-9;
      NeedleState shortened = needle_at_rest(needle);
      shortened.positions *= 1.0 - load / section.EA;
      const NeedleEquilibrium result = solve_needle_equilibrium(needle, held, along, shortened, options);
      if (!result.converged) throw std::runtime_error("a needle pressed along itself has no equilibrium");
      return result.negative_pivots;
    };
    double stable = 0.5 * row.euler, unstable = 1.5 * row.euler;
    row.lost = pivots(unstable) - pivots(stable);
    while (unstable - stable > 1e-11 * row.euler) {
      const double load = 0.5 * (stable + unstable);
      (pivots(load) == 0 ? stable : unstable) = load;  // -1, singular to round-off, is the load itself
    }
    row.found.push_back(0.5 * (stable + unstable));
  }
  const std::size_t last = row.found.size() - 1;
  row.extrapolated = (4.0 * row.found[last] - row.found[last - 1]) / 3.0;
  return row;
}

ForceBalance needle_force_balance(double offset) {
  InsertionSetup setup = held_insertion();
  setup.entry.z() += offset;
  InsertionCase made = insertion_case(setup);
  Insertion insertion = start_insertion(std::move(made.forest), made.problem);
  const Needle& needle = made.problem.needle;
  const Eigen::VectorXd mass = needle_mass(needle);
  const auto momentum = [&] {
    double sum = 0.0;
    for (int node = 0; node < needle.node_count(); ++node)
      sum += mass[6 * node] * insertion.axis.dot(insertion.needle.velocities.col(node));
    return sum;
  };
  ForceBalance balance;
  InsertionReport end;
  double largest = 0.0, before = momentum();
  for (int frame = 0; frame < 500; ++frame) {
    end = advance_frame(made.problem, insertion);
    if (!end.frame.converged) throw std::runtime_error("force balance: a frame did not converge");
    const double now = momentum(), inertia = (now - before) / made.problem.motion.time_step;
    balance.momentum_error = std::max(balance.momentum_error, std::abs(end.base_force - end.force - inertia));
    balance.largest_inertia = std::max(balance.largest_inertia, std::abs(inertia));
    largest = std::max(largest, std::abs(end.force));
    before = now;
  }
  balance.momentum_error /= largest;
  balance.largest_inertia /= largest;
  balance.contact = end.force;
  balance.base = end.base_force;
  balance.points = end.contact_points;
  balance.kinetic_share = end.frame.energy.kinetic / end.frame.energy.elastic;
  balance.bend = (insertion.needle.positions - needle.rest_positions).bottomRows<2>().colwise().norm().maxCoeff();
  const Discretization& d = insertion.tissue.mesh.d;
  const Eigen::VectorXd internal = reduce_forces(d.hanging, internal_forces(d, insertion.tissue.state.u));
  for (const int node : d.supports.reduced) balance.clamp -= insertion.axis.dot(internal.segment<3>(3 * node));
  return balance;
}

Evidence needle_evidence(const EvidenceOptions& options) {
  static constexpr EvidencePart parts[] = {
      {"cantilevers", [](Evidence& e, bool) { show_cantilevers(e); }},
      {"rolled-up beams", [](Evidence& e, bool) { show_roll_up(e); }},
      {"the elastica", [](Evidence& e, bool) { show_elastica(e); }},
      {"the 45 degree bend", [](Evidence& e, bool) { show_bend(e); }},
      {"Lee's frame", [](Evidence& e, bool) { show_lee(e); }},
      {"buckling", show_buckling},
      {"turning bases", [](Evidence& e, bool) { show_turning(e); }},
      {"a force on a line", show_line_force},
      {"balance of forces", [](Evidence& e, bool) { show_balance(e); }},
  };
  return show_parts(parts, options);
}

}  // namespace finegauge
