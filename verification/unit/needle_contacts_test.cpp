#include "core/needle/needle_contacts.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/needle/needle_step.hpp"
#include "verification/support/catch.hpp"

using namespace finegauge;

namespace {

constexpr double tau = 0.01;             // [s]
constexpr double start_distance = 1e-4;  // of the tip before the wall, along the axis [m]
constexpr double least_speed = 1e-9;     // that a solve can tell from zero [m/s]
constexpr int elements = 8;
constexpr double length = 0.032;  // of the needle [m]

/// A straight needle before the wall x = 0 of a block that does not move. The needle is moved by hand, and what a solve
/// would find at its points is given by hand: what is tested is the bookkeeping between the two.
struct ByHand {
  RefinementForest forest;
  Mesh mesh = forest.leaf_mesh();
  HangingNodes hanging = find_hanging_nodes(forest, mesh);
  Eigen::Matrix3Xd u = Eigen::Matrix3Xd::Zero(3, mesh.node_count());
  Needle needle;
  NeedleState state = needle_at_rest(needle);
  NeedleContacts contacts;
  std::vector<ContactRows> rows;  ///< of the last step

  TissueView view() const { return {forest, mesh, hanging, u, u}; }
  /// A step in which the needle moves by `motion`; `outcome(i, rows)` is what happens at point i.
  template <class Outcome>
  void step(const Eigen::Vector3d& motion, const Outcome& outcome) {
    const auto found = contacts.begin_step(needle, state, view(), motion, Eigen::Matrix3d::Identity(), tau);
    rows.assign(found.begin(), found.end());
    std::vector<ContactOutcome> outcomes;
    for (int i = 0; i < static_cast<int>(rows.size()); ++i) outcomes.push_back(outcome(i, rows[i]));
    state.positions.colwise() += motion;
    contacts.end_step(needle, state, view(), outcomes, 0.0, tau, least_speed);
  }
  /// Rest position of a row's tissue point; without hanging nodes reduced numbers are nodes.
  Eigen::Vector3d tissue_point(const ContactRows& row) const {
    Eigen::Vector3d X = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < row.tissue.node.size(); ++k)
      X += row.tissue.weight[k] * mesh.nodes.col(row.tissue.node[k]);
    return X;
  }
};

ByHand by_hand(const Eigen::Vector3d& axis, const ContactRules& rules) {
  BoxMeshOptions box;
  box.size = {0.04, 0.02, 0.02};
  box.cells = {4, 2, 2};
  const Eigen::Vector3d tip = Eigen::Vector3d(0.0, 0.009, 0.011) - start_distance * axis;
  return {.forest = RefinementForest(box_mesh(box)),
          .needle = straight_needle({2e11, 0.3, 1e-3, 7800.0}, tip - length * axis, tip, elements),
          .contacts = NeedleContacts(rules),
          .rows = {}};
}

}  // namespace

TEST_CASE("an oblique touch pushes back along the needle by normal force and friction", "[contacts]") {
  const double degrees = GENERATE(0.0, 20.0, 50.0), mu = GENERATE(0.0, 0.8);
  CAPTURE(degrees, mu);
  const double alpha = degrees * std::numbers::pi / 180.0;
  const Eigen::Vector3d axis(std::cos(alpha), std::sin(alpha), 0.0);
  ByHand hand = by_hand(axis, {.puncture_strength = 10.0, .surface_friction = mu});
  const double pressed = 2.0;  // [N]
  hand.step(2.0 * start_distance * axis, [&](int, const ContactRows& row) {
    CHECK(row.axial == AxialLaw::unilateral);
    CHECK(row.lateral == LateralLaw::coulomb);
    // The tissue's normal force on the tip along -x; the tip is driven upwards along the wall, so friction acts down on
    // it. Impulses count as those of the needle on the tissue.
    const Eigen::Vector3d impulse = tau * pressed * Eigen::Vector3d(1.0, mu, 0.0);
    return ContactOutcome{row.frame.transpose() * impulse, Eigen::Vector3d::Zero(), 0, false};
  });
  REQUIRE(hand.rows.size() == 1);
  CHECK(hand.contacts.tip_state() == TipState::touch);
  const ContactForces forces = hand.contacts.forces(axis, tau);
  CHECK_THAT(forces.tip, WithinRel(pressed * (std::cos(alpha) + mu * std::sin(alpha)), 1e-12));
  CHECK(forces.shaft == 0.0);
  CHECK_THAT(forces.tip_lateral, WithinAbs(pressed * mu, 1e-12 * pressed));
  CHECK(forces.total() == forces.tip);
}

TEST_CASE("inside, rows push along the needle, and what holds it across counts on other axes only", "[contacts]") {
  const double alpha = 0.4;
  const Eigen::Vector3d axis(std::cos(alpha), std::sin(alpha), 0.0);
  ByHand hand = by_hand(axis, {.puncture_strength = 1.0, .cut_strength = 10.0});
  hand.step(2.0 * start_distance * axis, [&](int, const ContactRows&) {
    return ContactOutcome{tau * Eigen::Vector3d(1.5, 0.0, 0.0), Eigen::Vector3d::Zero(), 0, false};
  });
  REQUIRE(hand.contacts.tip_state() == TipState::stick);
  double whole_on_x = 0.0;
  hand.step(Eigen::Vector3d::Zero(), [&](int i, const ContactRows& row) {
    CHECK((row.frame.col(0) - axis).norm() < 1e-12);
    CHECK(row.axial == (i == 0 ? AxialLaw::friction : AxialLaw::unilateral));
    const Eigen::Vector3d force(i == 0 ? 0.25 : 3.0, 7.0, -24.0);
    whole_on_x += (row.frame * force).x();
    return ContactOutcome{tau * force, Eigen::Vector3d::Zero(), 0, false};
  });
  REQUIRE(hand.rows.size() == 2);
  const ContactForces forces = hand.contacts.forces(axis, tau);
  CHECK_THAT(forces.shaft, WithinRel(0.25, 1e-12));
  CHECK_THAT(forces.tip, WithinRel(3.0, 1e-12));
  CHECK_THAT(forces.tip_lateral, WithinRel(25.0, 1e-12));
  CHECK_THAT(forces.across, WithinAbs(0.0, 1e-12 * 25.0));
  // On another axis: its cosine with the needle, and the share of what holds the needle across itself.
  const ContactForces on_x = hand.contacts.forces(Eigen::Vector3d::UnitX(), tau);
  CHECK_THAT(on_x.tip, WithinRel(3.0 * std::cos(alpha), 1e-12));
  CHECK(std::abs(on_x.across) > 1.0);
  CHECK_THAT(on_x.total(), WithinRel(whole_on_x, 1e-12));
}

TEST_CASE(
    "a cut goes on while the tip advances, however slowly, and ends where it stands to the tolerance of the solve",
    "[contacts]") {
  const auto [speed, goes_on] =
      GENERATE(std::pair{2.0 * least_speed, true}, std::pair{0.5 * least_speed, false}, std::pair{0.0, false},
               std::pair{-0.5 * least_speed, false}, std::pair{-2.0 * least_speed, false});
  CAPTURE(speed);
  ByHand hand = by_hand(Eigen::Vector3d::UnitX(), {.puncture_strength = 1.0, .cut_strength = 1.0, .cut_advance = 2e-3});
  const auto pressed = [](int, const ContactRows& row) {
    const bool tip = row.axial == AxialLaw::unilateral;
    return ContactOutcome{tau * Eigen::Vector3d(tip ? 5.0 : 0.0, 0.0, 0.0), Eigen::Vector3d::Zero(), 0, false};
  };
  hand.step(2.0 * start_distance * Eigen::Vector3d::UnitX(), pressed);
  hand.step(-start_distance * Eigen::Vector3d::UnitX(), pressed);
  REQUIRE(hand.contacts.tip_state() == TipState::cut);
  for (int frame = 0; frame < 3; ++frame) {
    const Eigen::Vector3d velocity = speed * Eigen::Vector3d::UnitX();
    // A tip that goes back stays where it is here, or it would leave the body that it has just entered.
    const Eigen::Vector3d motion = goes_on ? Eigen::Vector3d(tau * velocity) : Eigen::Vector3d::Zero();
    hand.step(motion, [&](int, const ContactRows&) {
      return ContactOutcome{Eigen::Vector3d::Zero(), velocity, 0, false};
    });
    CHECK(hand.contacts.tip_state() == (goes_on ? TipState::cut : TipState::stick));
    if (!goes_on) break;
  }
}

TEST_CASE("a point is laid at every d_c however far the tip went in a frame", "[contacts]") {
  const double d_c = 2e-3;
  struct Advance {
    double over_d_c;
    int points;  ///< laid: the last stretch is between one half and three halves of d_c
  };
  const Advance first = GENERATE(values<Advance>({{0.95, 0}, {1.0001, 1}, {1.45, 1}, {1.55, 2}, {2.9, 3}, {5.4, 5}}));
  const Advance second = GENERATE(values<Advance>({{1.2, 1}, {4.6, 5}}));
  CAPTURE(first.over_d_c, second.over_d_c);
  const double clamping = 300.0;  // [N/m]
  ByHand hand = by_hand(Eigen::Vector3d::UnitX(),
                        {.puncture_strength = 1.0, .cut_strength = 1.0, .cut_advance = d_c, .clamping = clamping});
  const auto pressed = [](int, const ContactRows& row) {
    const bool tip = row.axial == AxialLaw::unilateral;
    return ContactOutcome{tau * Eigen::Vector3d(tip ? 5.0 : 0.0, 0.0, 0.0), Eigen::Vector3d::Zero(), 0, false};
  };
  const auto moving = [](int, const ContactRows&) {
    return ContactOutcome{Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX(), 0, false};
  };
  const Eigen::Vector3d still = Eigen::Vector3d::Zero(), x = Eigen::Vector3d::UnitX();
  hand.step(2.0 * start_distance * x, pressed);  // touch, puncture: the tip is 0.1 mm past the wall
  REQUIRE(hand.contacts.tip_state() == TipState::stick);
  hand.step(-start_distance * x, pressed);  // at the wall, cut
  REQUIRE(hand.contacts.tip_state() == TipState::cut);

  std::vector<double> expected = {0.0, 0.0};  // the entry, and the place that the tip starts from
  double depth = 0.0;
  const auto cut = [&](const Advance& advance) {
    hand.step(advance.over_d_c * d_c * x, moving);
    for (int k = 1; k < advance.points; ++k) expected.push_back(depth + k * d_c);
    depth += advance.over_d_c * d_c;
    if (advance.points > 0) expected.push_back(depth);
    CHECK(hand.contacts.tip_state() == (advance.points > 0 ? TipState::stick : TipState::cut));
    hand.step(still, advance.points > 0 ? +pressed : +moving);
    REQUIRE(hand.rows.size() == expected.size());
    double clamped = 0.0;
    for (std::size_t k = 0; k < expected.size(); ++k) {
      const Eigen::Vector3d X = hand.tissue_point(hand.rows[k]);
      CHECK((X - Eigen::Vector3d(expected[k], 0.009, 0.011)).norm() < 1e-9 * length);
      clamped += hand.rows[k].clamp;
    }
    CHECK_THAT(clamped, WithinRel(clamping * depth, 1e-6));  // of all that is in the tissue, whoever stands for it
    CHECK_THAT(hand.contacts.inserted_length(), WithinAbs(depth, 1e-9 * length));
    CHECK_THAT(hand.contacts.entry_length(hand.needle), WithinAbs(length - depth, 1e-9 * length));
  };
  cut(first);
  if (first.points > 0) cut(second);
}

TEST_CASE("a step of another length starts from the same forces", "[contacts]") {
  ByHand hand = by_hand(Eigen::Vector3d::UnitX(), {.puncture_strength = 1.0, .cut_strength = 10.0});
  // The entry is too near to the tip to hold across.
  const std::array<Eigen::Vector3d, 2> forces = {Eigen::Vector3d(0.5, 0.0, 0.0), Eigen::Vector3d(4.0, 1.0, 0.25)};
  hand.step(2.0 * start_distance * Eigen::Vector3d::UnitX(), [&](int, const ContactRows&) {
    return ContactOutcome{tau * forces[1], Eigen::Vector3d::Zero(), 0, false};
  });
  const auto carry = [&](int i, const ContactRows&) {
    return ContactOutcome{tau * forces[static_cast<std::size_t>(i)], Eigen::Vector3d::Zero(), 0, false};
  };
  hand.step(Eigen::Vector3d::Zero(), carry);
  REQUIRE(hand.rows.size() == 2);
  for (const double length_of_step : {tau, 0.25 * tau, 3.0 * tau}) {
    CAPTURE(length_of_step);
    const auto rows = hand.contacts.begin_step(hand.needle, hand.state, hand.view(), Eigen::Vector3d::Zero(),
                                               Eigen::Matrix3d::Identity(), length_of_step);
    REQUIRE(rows.size() == 2);
    for (std::size_t i = 0; i < 2; ++i)
      CHECK((rows[i].lambda / length_of_step - forces[i]).norm() <= 1e-14 * forces[i].norm());
  }
}

TEST_CASE("the guide lets go of the nodes less than an element before the entry", "[contacts][guide]") {
  const ByHand hand = by_hand(Eigen::Vector3d::UnitX(), {});
  const double element = length / elements;
  struct Case {
    double entry;  ///< in elements from the base
    int guided;    ///< nodes besides the base
  };
  const auto [entry, guided] = GENERATE(values<Case>({{8.0, 8},   // outside: all of them, the tip too
                                                      {7.99, 6},  // node 7 is nearer than an element
                                                      {7.01, 6},  // node 6 is just farther
                                                      {6.99, 5},
                                                      {2.5, 1},
                                                      {1.9, 0},
                                                      {0.0, 0}}));
  CAPTURE(entry);
  NeedleState bent = hand.state;
  bent.positions.row(1).array() += 1e-5;  // the guide brings nodes back to its line
  bent.positions(1, 0) -= 1e-5;
  NeedleSystem system = start_needle_system(hand.needle);
  REQUIRE((system.axes.col(0) - Eigen::Vector3d::UnitX()).norm() < 1e-14);
  const double entry_length = entry * element;  // a structured binding cannot be captured
  const auto assemble = [&](const NeedleDrive& drive) {
    assemble_needle_step(hand.needle, drive, bent, entry_length, Eigen::Vector3d::Zero(), nullptr, 0.0, tau, system);
  };
  assemble({.strokes = {}, .guided = true});
  CHECK(system.held[0] == 63u);
  for (int node = 1; node <= elements; ++node) {
    CAPTURE(node);
    CHECK(system.held[node] == (node <= guided ? 6u : 0u));  // bits of the two directions across
    const Eigen::Vector3d back = system.axes * system.prescribed.segment<3>(6 * node);
    CHECK((back - (node <= guided ? -1e-5 / tau : 0.0) * Eigen::Vector3d::UnitY()).norm() < 1e-12);
  }
  assemble({.strokes = {}, .guided = false});
  for (int node = 1; node <= elements; ++node) CHECK(system.held[node] == 0u);
}
