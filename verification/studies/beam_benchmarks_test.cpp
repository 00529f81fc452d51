#include "verification/studies/beam_benchmarks.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "verification/support/catch.hpp"

using namespace finegauge;

// Straight elements whose energy is quadratic in their own frame: exact for end loads on small deflections, second
// order in the element's length on curved axes. Bands of 0.05 about order 2 on grids where the next term has faded.

TEST_CASE("a cantilever's tip deflects by bending and shear exactly, whatever its slenderness and elements",
          "[beams]") {
  const double slenderness = GENERATE(2.0, 10.0, 100.0, 1e4);
  const int elements = GENERATE(1, 4, 32);
  const TimoshenkoRow row = timoshenko_cantilever(slenderness, elements);
  CAPTURE(slenderness, elements, row.linear, row.equilibrium);
  // Round-off times the condition of a chain, some n⁴ = 1e6 at 32 elements: 1e-16 to 1e-10.
  CHECK(row.linear < 1e-16 * 50.0 * std::pow(elements, 4) + 1e-15);
  // The deflection's own nonlinearity is (1e-6)² of it, the same for every beam; below a third of it would be luck.
  CHECK(row.equilibrium < 3e-12);
  if (elements == 1) CHECK(row.equilibrium > 3e-13);
}

TEST_CASE("a moment of 2 pi EI / L rolls a beam up to a closed circle of any number of sides", "[beams]") {
  const int elements = GENERATE(3, 5, 8, 16, 64);
  const bool planar = GENERATE(true, false);
  const RollUpRow row = roll_up(2.0 * std::numbers::pi, elements, 9, planar);
  CAPTURE(elements, planar, row.iterations);
  CHECK(row.tip_error < 1e-10);  // a regular polygon closes; the rest is the residual's tolerance
  CHECK(row.angle_error < 1e-10);
}

TEST_CASE("two full turns of a beam pass without a trace of the first", "[beams]") {
  const RollUpRow row = roll_up(4.0 * std::numbers::pi, 16, 19);
  CHECK(row.tip_error < 1e-10);
  CHECK(row.angle_error < 1e-10);
}

TEST_CASE("a beam that is partly rolled up nears the circle with second order", "[beams]") {
  const double t = GENERATE(1.0, 3.0, 5.0);
  ErrorSeries series{"tip", {}, {}};
  for (const int n : {8, 16, 32, 64}) {
    const RollUpRow row = roll_up(t, n, 9);
    CHECK(row.angle_error < 1e-9);  // exact: each element carries the same moment
    series.h.push_back(1.0 / n);
    series.error.push_back(row.tip_error);
  }
  INFO(convergence_table({series}));
  CHECK_THAT(last_order(series), WithinAbs(2.0, 0.05));
  CHECK_THAT(fitted_order(series), WithinAbs(2.0, 0.05));
  // A polygon of chords h with the angles of a circle has the radius (h / 2) / sin(t h / 2), by (t h)² / 24 too large:
  // so far is the tip from the circle's as the circle's own tip from the root.
  const double tip_distance = 2.0 * std::abs(std::sin(0.5 * t)) / t;
  CHECK_THAT(series.error.back(), WithinRel(t * t / 64.0 / 64.0 / 24.0 * tip_distance, 1e-3));
}

TEST_CASE("the elastica's closed form has the published digits", "[beams]") {
  const ElasticaTip tip = exact_elastica(1.0);
  CHECK_THAT(tip.w, WithinAbs(0.3017207738, 1e-10));
  CHECK_THAT(tip.u, WithinAbs(0.0564332363, 1e-10));
  CHECK_THAT(tip.angle, WithinAbs(0.4613519, 1e-7));
  // Small loads: P L² / 3 EI and its square's shortening, 3 w² / 5.
  const ElasticaTip small = exact_elastica(1e-3);
  CHECK_THAT(small.w, WithinRel(1e-3 / 3.0, 1e-6));
  CHECK_THAT(small.u, WithinRel(0.6 * small.w * small.w, 1e-4));
}

TEST_CASE("a cantilever follows the elastica up to ten times EI / L² with second order", "[beams]") {
  const double load = GENERATE(0.25, 1.0, 2.0, 4.0, 7.0, 10.0);
  CAPTURE(load);
  const std::vector<ErrorSeries> series = elastica_convergence(load, {16, 32, 64}, 10);
  INFO(convergence_table(series));
  for (const ErrorSeries& s : series) {
    CAPTURE(s.quantity);
    // The shortening's error changes its sign near ten with eight elements: it needs finer ones.
    CHECK_THAT(last_order(s), WithinAbs(2.0, s.quantity == "shortening" && load > 5.0 ? 0.1 : 0.05));
    CHECK(s.error.back() < 5e-5);  // 3.7e-5 at ten: an angle per element of 2 / 64 squared / 24
  }
}

TEST_CASE("extrapolated to no length of elements the elastica is met to seven digits", "[beams]") {
  const double load = GENERATE(1.0, 10.0);
  const ElasticaTip exact = exact_elastica(load), coarse = beam_elastica(load, 32, 10),
                    fine = beam_elastica(load, 64, 10);
  // The next term is of order h⁴ and EA shortens by less than 1e-8 load.
  CHECK_THAT((4.0 * fine.w - coarse.w) / 3.0, WithinAbs(exact.w, 3e-7));
  CHECK_THAT((4.0 * fine.u - coarse.u) / 3.0, WithinAbs(exact.u, 3e-7));
  CHECK_THAT((4.0 * fine.angle - coarse.angle) / 3.0, WithinAbs(exact.angle, 3e-7));
}

namespace {

const Eigen::Vector3d bend_reference(15.684689, 47.150096, 53.475478);  // two independent solvers, converged, to 1e-6

}  // namespace

TEST_CASE("the 45 degree bend is met within 0.1 % by 16 elements and converges to the reference with second order",
          "[beams]") {
  ErrorSeries series{"tip", {}, {}};
  std::vector<Eigen::Vector3d> tips;
  for (const int chords : {16, 32, 64}) {
    tips.push_back(bend_45({.chords = chords}).position);
    series.h.push_back(1.0 / chords);
    series.error.push_back((tips.back() - bend_reference).norm());
  }
  INFO(convergence_table({series}));
  for (int axis = 0; axis < 3; ++axis) CHECK_THAT(tips[0][axis], WithinRel(bend_reference[axis], 1e-3));
  CHECK_THAT(last_order(series), WithinAbs(2.0, 0.05));
  for (int axis = 0; axis < 3; ++axis)
    CHECK_THAT((4.0 * tips[2][axis] - tips[1][axis]) / 3.0, WithinAbs(bend_reference[axis], 1e-5));
}

TEST_CASE("half of what 16 straight elements leave on the 45 degree bend is their geometry", "[beams]") {
  // The polygon of 16 sides with eight elements to each side: the beam is converged, the arc is not.
  const Eigen::Vector3d polygon = bend_45({.chords = 16, .elements_per_chord = 8}).position;
  const Eigen::Vector3d geometry = polygon - bend_reference;
  const Eigen::Vector3d beam = bend_45({.chords = 16}).position - polygon;
  CAPTURE(geometry.transpose(), beam.transpose());
  CHECK_THAT(geometry.norm(), WithinAbs(0.0167, 0.001));
  CHECK_THAT(beam.norm(), WithinAbs(0.0240, 0.001));
}

TEST_CASE("the square's own torsion constant moves the tip of the 45 degree bend as the reference says", "[beams]") {
  const auto tip = [](int chords) { return bend_45({.chords = chords, .torsion_constant = 0.140577}).position; };
  const Eigen::Vector3d extrapolated = (4.0 * tip(64) - tip(32)) / 3.0, expected(15.557676, 46.891586, 53.607986);
  for (int axis = 0; axis < 3; ++axis) CHECK_THAT(extrapolated[axis], WithinAbs(expected[axis], 3e-5));
  CHECK((expected - bend_reference).norm() > 0.3);
}

TEST_CASE("the way to the load leaves no trace: eight, ten or two steps end at one place", "[beams]") {
  const Eigen::Vector3d eight = bend_45({.steps = 8}).position;
  // The residual's tolerance, 1e-11 × 600, times a compliance of 0.1.
  CHECK((bend_45({.steps = 10}).position - eight).norm() < 1e-9);
  CHECK((bend_45({.steps = 2}).position - eight).norm() < 1e-9);
  CHECK((bend_45({.load = 300.0}).position - eight).norm() > 10.0);
}

TEST_CASE("Lee's frame reaches its first limit load", "[beams]") {
  const bool shear = GENERATE(false, true);
  const LeeLimit coarse = lee_frame(shear, 10), middle = lee_frame(shear, 20), fine = lee_frame(shear, 40);
  const double load = shear ? 1.854453 : 1.855673, vertical = shear ? 48.754 : 48.735,
               horizontal = shear ? 26.878 : 26.880;
  CAPTURE(shear, middle.load, middle.vertical, middle.horizontal);
  CHECK_THAT(middle.load, WithinRel(load, 5e-3));
  CHECK_THAT(middle.vertical, WithinRel(vertical, 5e-3));
  CHECK_THAT(middle.horizontal, WithinRel(horizontal, 5e-3));
  CHECK_THAT(std::log2((coarse.load - load) / (middle.load - load)), WithinAbs(2.0, 0.05));
  // Extrapolated it tells shear from none, 1.2e-3 apart, by a factor of a hundred.
  CHECK_THAT((4.0 * fine.load - middle.load) / 3.0, WithinAbs(load, 1e-5));
  CHECK_THAT((4.0 * fine.vertical - middle.vertical) / 3.0, WithinAbs(vertical, 5e-3));
  CHECK_THAT((4.0 * fine.horizontal - middle.horizontal) / 3.0, WithinAbs(horizontal, 5e-3));
  CHECK(fine.pivots_before == 0);
  CHECK(fine.pivots_after == 1);
}

TEST_CASE("a base that turns three times leaves no kink at a full turn, and no memory", "[beams]") {
  TurningBase options;
  options.about_own_axis = GENERATE(true, false);
  const std::vector<TurningRow> rows = turning_base(options);
  const int turn = options.steps_per_turn;
  REQUIRE(static_cast<int>(rows.size()) == 3 * turn + 1);
  const auto extremes =
      std::minmax_element(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a.energy < b.energy; });
  REQUIRE(extremes.second->energy > 1.5 * extremes.first->energy);  // the angle matters

  for (std::size_t k = 0; k + turn < rows.size(); ++k) {
    CAPTURE(k);
    CHECK_THAT(rows[k + turn].energy, WithinAbs(rows[k].energy, 1e-10));  // the residual's tolerance, 1e-11
    CHECK_THAT(rows[k + turn].base_moment, WithinAbs(rows[k].base_moment, 1e-9));
    CHECK((rows[k + turn].tip - rows[k].tip).norm() < 1e-10);
  }
  // The spinning beam is its own mirror image about a full turn, so that nothing odd in the angle may come out of it.
  if (options.about_own_axis)
    for (int full = turn; full + 3 < static_cast<int>(rows.size()); full += turn)
      for (int k = 1; k <= 3; ++k) CHECK_THAT(rows[full + k].energy, WithinAbs(rows[full - k].energy, 1e-10));
  // Third differences are the derivative times step³; the largest anywhere is not at a full turn by more than
  // elsewhere.
  const auto third = [&](int k) {
    return std::abs(rows[k + 2].energy - 3.0 * rows[k + 1].energy + 3.0 * rows[k].energy - rows[k - 1].energy);
  };
  double away = 0.0, across = 0.0;
  for (int k = 1; k + 2 < static_cast<int>(rows.size()); ++k) {
    const int from_turn = std::min(k % turn, turn - k % turn);
    (from_turn <= 2 ? across : away) = std::max(from_turn <= 2 ? across : away, third(k));
  }
  CHECK(away > 0.0);
  CHECK(across < 1.2 * away);
}
