#include "verification/studies/atlas_contact.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "core/tissue_forces.hpp"
#include "verification/studies/atlas_scene.hpp"

namespace finegauge {
namespace {

/// A needle driven 10 mm into a block of 4 x 2 x 2 cells and drawn out again. Linear tissue and a needle that stays
/// straight: momentum and energy balance to the solver's tolerance.
constexpr const char* insertion_scene = R"([box]
size = [$L40, $L20, $L20]
cells = [4, 2, 2]
[[support]]
surface = "x_max"
[material]
youngs_modulus = $TISSUE_MODULUS
poisson_ratio = 0.4
[dynamics]
time_step = $TAU
density = $TISSUE_DENSITY
stiffness_damping = $BETA
[needle]
youngs_modulus = $NEEDLE_MODULUS
poisson_ratio = 0.3
radius = $L1
density = $NEEDLE_DENSITY
base = [$BASE_X, $BASE_Y, $BASE_Z]
tip = [$TIP_X, $TIP_Y, $TIP_Z]
elements = 8
[[stroke]]
displacement = [$IN_X, $IN_Y, 0]
speed = $SPEED
[[stroke]]
displacement = [$OUT_X, $OUT_Y, 0]
speed = $SPEED
[contact]
puncture_strength = $STRENGTH
cut_advance = $L4
friction = $FRICTION
surface_friction = $SURFACE_FRICTION
clamping = $CLAMPING
weight = $WEIGHT
)";

constexpr double needle_length = 0.032, gap = 5e-4;  // [m]
constexpr double strength = 0.05;                    // of the surface [N]

struct Drive {
  double tissue_modulus = 1e5, needle_modulus = 1e9;  // [Pa]
  double tissue_density = 1000.0, needle_density = 1000.0;
  double tau = 0.01;          // [s]
  double y = 0.01, z = 0.01;  // where the needle enters [m]
  double angle = 90.0;        // of the needle and the surface that it enters, in degrees
  double depth = 0.01;        // of the stroke in the body [m]
  double friction = 0.5, weight = 1e4;
  double surface_friction = 0.8;
  int frames_in = 55;  // of the stroke in; the speed follows
  double metre = 1.0;  // in units of length; masses and times stay
};

std::string insertion_text(const std::string& name, const Drive& drive, const std::string& more = "") {
  const double L = drive.metre, pressure = 1.0 / L;
  const double c = drive.angle == 90.0 ? 0.0 : std::cos(drive.angle * EIGEN_PI / 180.0);
  const double s = drive.angle == 90.0 ? 1.0 : std::sin(drive.angle * EIGEN_PI / 180.0);
  const double way = gap + drive.depth;
  const std::pair<std::string_view, double> values[] = {{"L40", 0.04 * L},
                                                        {"L20", 0.02 * L},
                                                        {"L1", 1e-3 * L},
                                                        {"L4", 4e-3 * L},
                                                        {"TISSUE_MODULUS", drive.tissue_modulus * pressure},
                                                        {"TISSUE_DENSITY", drive.tissue_density / (L * L * L)},
                                                        {"TAU", drive.tau},
                                                        {"BETA", 0.1 * drive.tau},
                                                        {"NEEDLE_MODULUS", drive.needle_modulus * pressure},
                                                        {"NEEDLE_DENSITY", drive.needle_density / (L * L * L)},
                                                        {"BASE_X", -(gap + needle_length) * s * L},
                                                        {"BASE_Y", (drive.y - (gap + needle_length) * c) * L},
                                                        {"BASE_Z", drive.z * L},
                                                        {"TIP_X", -gap * s * L},
                                                        {"TIP_Y", (drive.y - gap * c) * L},
                                                        {"TIP_Z", drive.z * L},
                                                        {"IN_X", way * s * L},
                                                        {"IN_Y", way * c * L},
                                                        {"OUT_X", -1.1 * way * s * L},
                                                        {"OUT_Y", -1.1 * way * c * L},
                                                        {"SPEED", way / (drive.tau * drive.frames_in) * L},
                                                        {"STRENGTH", strength * L},
                                                        {"FRICTION", drive.friction},
                                                        {"SURFACE_FRICTION", drive.surface_friction},
                                                        {"CLAMPING", 3.0},
                                                        {"WEIGHT", drive.weight}};
  return "name = \"" + name + "\"\n" + filled(insertion_scene, values) + more +
         "[[quantity]]\nkind = \"force_curve\"\n";
}

/// What a run showed, beside whether it answered at all.
struct Followed {
  std::string stopped;          // why there is no answer; empty where there is one
  std::vector<double> force;    // a frame each [N]
  double largest_force = 0.0;   // [N]
  double balance = 0.0;         // largest error of the needle's axial momentum, over the largest force
  double equilibrium = 0.0;     // largest force out of balance in the tissue, over the largest force in it
  double closure = 0.0;         // of the energy, largest, over the work done
  double bound_exceeded = 0.0;  // of Coulomb's law for the shaft, over the largest force
  double sliding_error = 0.0;   // of a shaft that slides, against friction times clamping times depth
  int punctures = 0, slides = 0, coarsened_beneath = 0;  // beneath: places along the needle whose leaf grew
};

double axial_momentum(const Insertion& insertion, const Needle& needle) {
  const Eigen::VectorXd mass = needle_mass(needle);
  double p = 0.0;
  for (int node = 0; node < needle.node_count(); ++node)
    p += mass[6 * node] * insertion.needle.velocities.col(node).dot(insertion.axis);
  return p;
}

/// Of the forces in the tissue that a frame balances, the largest, elastic ones, inertia and the needle's [N]. Changes
/// of the mesh after the frame are not taken out. `velocity`: the frame's before; becomes its own.
double frame_force(const FrameView& view, double tau, Eigen::VectorXd& velocity) {
  const TissueMesh& mesh = view.tissue.mesh;
  const Eigen::VectorXd v = gather(mesh.d.hanging, view.tissue.state.v);
  const double inertia = velocity.size() == v.size() ? mass_times(mesh.mass, v - velocity).norm() / tau : 0.0;
  velocity = v;
  return std::max({tissue_forces(mesh.d, view.tissue.state.u, view.tissue.state.v).internal.norm(), inertia,
                   std::abs(view.report.force), view.report.tip_lateral_force});
}

/// How often the leaves were refined that lie along the needle's way, a millimetre apart from its entry to its depth.
std::vector<int> leaf_depths(const Tissue& tissue, double depth) {
  std::vector<int> depths;
  for (double x = 5e-4; x < depth; x += 1e-3) {
    const auto place = locate_at_rest(tissue.forest.base(), {x, 0.01, 0.01});
    depths.push_back(tissue.mesh.d.mesh.frames[find_leaf(tissue.forest, tissue.mesh.d.mesh, place.value()).cell].depth);
  }
  return depths;
}

Followed follow(const std::string& text) {
  Followed run;
  const Scene scene = scene_from_text(text);
  const double tau = scene.dynamics->time_step;
  const Needle needle =
      straight_needle(scene.needle->properties, scene.needle->base, scene.needle->tip, scene.needle->elements);
  const ContactRules& rules = scene.needle->contact;
  double momentum = 0.0, depth = 0.0, work = 0.0, worst_balance = 0.0, worst_closure = 0.0, worst_bound = 0.0,
         worst_sliding = 0.0, inertia = 0.0, tissue_force = 0.0, worst_equilibrium = 0.0;
  Eigen::VectorXd velocity;
  std::vector<int> leaves;
  run_scene(scene, [&](const FrameView& view) {
    const InsertionReport& report = view.report;
    const FrameReport& frame = report.frame;
    if (!frame.converged) {
      char words[160];
      std::snprintf(words, sizeof words,
                    "frame %d did not converge and says so: violation %.2g, residual %.2g after %d iterations",
                    frame.frame, frame.violation, frame.residual, frame.uzawa_iterations);
      run.stopped = words;
      return false;
    }
    run.force.push_back(report.force);
    keep_largest(run.largest_force, std::abs(report.force));
    const double p = axial_momentum(*view.insertion, needle);
    inertia = std::max(inertia, std::abs(p - momentum) / tau);
    keep_largest(worst_balance, std::abs(report.base_force - report.force - (p - momentum) / tau));
    momentum = p;
    // equilibrium_error is relative to the frame's own forces; of a body that hardly moves any more they are round-off.
    const double own = frame_force(view, tau, velocity);
    tissue_force = std::max(tissue_force, own);
    keep_largest(worst_equilibrium, frame.equilibrium_error * own);
    work = std::max({work, std::abs(frame.energy.work), frame.energy.dissipated});
    keep_largest(worst_closure, std::abs(frame.energy.closure));
    // Without lateral forces the shaft's friction is at most mu p l, l being the length in the body at the start of the
    // frame; and no less in a frame in which all of it slides.
    const double limit = rules.friction_in * rules.clamping * depth;
    keep_largest(worst_bound, std::abs(report.shaft_force) - limit);
    bool slides = false;  // all of the shaft, where part of it did not
    for (const ContactEvent& event : report.events) {
      run.punctures += event.kind == ContactEventKind::puncture;
      if (event.kind == ContactEventKind::slip) slides = true, ++run.slides;
    }
    if (slides) keep_largest(worst_sliding, std::abs(std::abs(report.shaft_force) - limit));
    depth = report.insertion_depth;
    if (scene.dynamics->adapt) {
      std::vector<int> depths = leaf_depths(view.tissue, report.insertion_depth);
      for (std::size_t i = 0; i < std::min(depths.size(), leaves.size()); ++i)
        run.coarsened_beneath += depths[i] < leaves[i];
      leaves = std::move(depths);
    }
    return true;
  });
  const double force = std::max(run.largest_force, inertia);
  run.balance = force > 0.0 ? worst_balance / force : worst_balance;
  run.closure = work > 0.0 ? worst_closure / work : worst_closure;
  run.bound_exceeded = force > 0.0 ? worst_bound / force : worst_bound;
  run.sliding_error = force > 0.0 ? worst_sliding / force : worst_sliding;
  run.equilibrium = tissue_force > 0.0 ? worst_equilibrium / tissue_force : worst_equilibrium;
  return run;
}

/// What holds of every insertion along a symmetric axis. The multipliers are solved to 1e-8 of the largest.
void check_balances(const Followed& run, AtlasChecks& checks) {
  // Where the needle bends, forces across it have a share along the axis that is not counted.
  checks.add("error of the needle's momentum over the force", run.balance, 1e-4);
  checks.add("force out of balance in the tissue over the largest", run.equilibrium, 1e-6);
  checks.add("energy that the balance leaves over, over the work", run.closure, 1e-5);
}
/// `symmetric`: no force acts across the needle, and friction is that of the clamping alone.
AtlasPoint insertion(double value, const std::string& name, const Drive& drive, bool symmetric = true) {
  const std::string text = insertion_text(name, drive);
  return scene_point(value, text, [&] {
    const Followed run = follow(text);
    if (!run.stopped.empty()) return refusal(value, run.stopped);
    AtlasChecks checks;
    check_balances(run, checks);
    if (symmetric) checks.add("shaft force above Coulomb's bound, over the largest force", run.bound_exceeded, 1e-6);
    // A wave along the needle has to bring the base's motion to the tip first, and the needle has to bear the force.
    const double wave = std::sqrt(drive.needle_modulus / drive.needle_density);
    const double area = EIGEN_PI * 1e-6, pushed = drive.needle_modulus * area * (gap + drive.depth) / needle_length;
    if (drive.tau * drive.frames_in * wave > 2.0 * needle_length && pushed > 2.0 * strength)
      checks.add("punctures that are missing", run.punctures > 0 ? 0.0 : 1.0, 0.0);
    if (symmetric && run.slides > 0)
      checks.add("force of a sliding shaft against mu p l, over the largest force", run.sliding_error, 1e-6);
    return checks.point(value);
  });
}

double largest_difference(const std::vector<double>& a, double factor, const std::vector<double>& b) {
  double difference = a.size() == b.size() ? 0.0 : std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    keep_largest(difference, std::abs(factor * a[i] - b[i]));
  return difference;
}

/// The forces have to be those of another scene.
AtlasPoint like_another(double value, const std::string& name, const Drive& drive, const Drive& other, double bound) {
  const std::string text = insertion_text(name, drive);
  return scene_point(value, text, [&] {
    const Followed run = follow(text), usual = follow(insertion_text(name, other));
    if (!run.stopped.empty()) return refusal(value, run.stopped);
    if (!usual.stopped.empty()) throw std::logic_error("the scene to compare with " + usual.stopped);
    AtlasChecks checks;
    check_balances(run, checks);
    checks.add("difference of the forces over the largest",
               largest_difference(run.force, other.metre / drive.metre, usual.force) / usual.largest_force, bound);
    return checks.point(value);
  });
}

constexpr double cell = 0.01;  // edge length of a cell of the block [m]

/// Beside a face, an edge or a surface by a share of a cell.
AtlasPoint beside(double value, const std::string& name, double y, double z, double share) {
  const Drive on{.y = y, .z = z};
  Drive off = on;
  off.y += share * cell;
  if (name == "beside_edge") off.z += share * cell;
  // Far from it punctures and cuts come in other frames, and the forces are others.
  if (share > 1e-2) return insertion(value, name, off, false);
  // Near to it the force depends on the place smoothly, with cells as the scale.
  return like_another(value, name, off, on, share + 1e-6);
}

AtlasPoint under_surface(double value) {
  const std::string text = insertion_text("under_surface", {.y = value * cell, .z = 0.014});
  return scene_point(value, text, [&] {
    const Followed run = follow(text);
    if (!run.stopped.empty()) return refusal(value, run.stopped);
    AtlasChecks checks;
    checks.add("force out of balance in the tissue over the largest", run.equilibrium, 1e-6);
    checks.add("energy that the balance leaves over, over the work", run.closure, 0.05);
    return checks.point(value);
  });
}

AtlasPoint grazing(double angle) {
  Drive drive{.z = 0.012, .angle = angle, .depth = 0.012};
  drive.y = 2e-3;
  const std::string text = insertion_text("grazing", drive);
  return scene_point(angle, text, [&] {
    const Followed run = follow(text);
    if (!run.stopped.empty()) return refusal(angle, run.stopped);
    AtlasChecks checks;
    // The needle bends: its rotations leave the energy a remainder of second order.
    checks.add("force out of balance in the tissue over the largest", run.equilibrium, 1e-6);
    checks.add("energy that the balance leaves over, over the work", run.closure, 0.05);
    return checks.point(angle);
  });
}

// Cells that are coarsened under the needle.

/// The cells around the needle are halved, level by level, and may be coarsened as soon as the stress falls.
AtlasPoint coarsening(double levels) {
  std::string more = "[adapt]\ntheta = 1.0\ncoarsen_below = 0.9\ndwell = 0\nrelease = 0\nmax_depth = $LEVELS\n";
  more = filled(more, {{"LEVELS", levels}});
  double half = 6e-3;
  for (int level = 0; level < static_cast<int>(levels); ++level, half *= 0.5)
    more += filled("[[refine]]\nmin = [-1, $LOW, $LOW]\nmax = [1, $HIGH, $HIGH]\n",
                   {{"LOW", 0.01 - half}, {"HIGH", 0.01 + half}});
  const std::string text = insertion_text("coarsening", {.depth = 0.015}, more);
  return scene_point(levels, text, [&] {
    const Followed run = follow(text);
    if (!run.stopped.empty()) return refusal(levels, run.stopped);
    AtlasChecks checks;
    check_balances(run, checks);
    checks.add("coarsening under the needle that did not happen", run.coarsened_beneath > 0 ? 0.0 : 1.0, 0.0);
    return checks.point(levels);
  });
}

const std::vector<double> stiffness_ratios = {1.0, 10.0, 1e2, 1e4, 1e6, 1e8, 1e10};
constexpr const char* stiffness_limit =
    "none to 1e10, since the needle is eliminated exactly; from 1e12 on the round-off of its positions, "
    "1e-16 of their distance from the origin, strains it as much as the tissue does";
const std::vector<double> more_stiffness_ratios = {1e-4, 1e-3, 1e-2, 0.1, 1e3, 1e5, 1e7, 1e9, 1e12, 1e14, 1e16};
const std::vector<double> offsets = {0.0, 1e-16, 1e-12, 1e-9, 1e-6, 1e-3, 0.1, 0.3, 0.5};
const std::vector<double> more_offsets = {1e-18, 1e-15, 1e-14, 1e-13, 1e-11, 1e-10, 1e-8, 1e-7, 1e-5, 1e-4, 1e-2};

}  // namespace

std::vector<AtlasAxis> contact_axes() {
  std::vector<AtlasAxis> axes;
  const std::string balances = "momentum of the needle, equilibrium of the tissue, energy, Coulomb's bound";
  axes.push_back(
      {.group = "contact",
       .name = "stiffness_ratio",
       .unit = "",
       .about = "Young's modulus of the needle over the tissue's, a needle in and out",
       .truth = balances,
       .normal = 1e4,
       .values = stiffness_ratios,
       .more_values = more_stiffness_ratios,
       .at = [](double value) { return insertion(value, "stiffness_ratio", {.needle_modulus = 1e5 * value}); },
       .safe = {1.0, 1e10},
       .answered = {1.0, 1e10},
       .reason = stiffness_limit});
  axes.push_back({.group = "contact",
                  .name = "uzawa_weight",
                  .unit = "",
                  .about = "weight of the augmented Lagrangian over the stiffness that a constraint meets",
                  .truth = "the forces at a weight of 1e4",
                  .normal = 1e4,
                  .values = {1e-8, 1e-6, 1e-4, 1e-2, 0.1, 1.0, 10.0, 100.0, 1e4, 1e6, 1e8},
                  .more_values = {1e-12, 0.03, 0.3, 3.0, 1e3, 1e5, 1e7, 1e9, 1e10, 1e12, 1e14, 1e16, 1e20},
                  .at = [](double value) { return like_another(value, "uzawa_weight", {.weight = value}, {}, 1e-6); },
                  .safe = {1e-8, 1e8},
                  .answered = {0.1, 1e8},
                  .reason = "an iteration leaves 1 / (1 + weight) of the violation: from 0.03 down a hundred are too "
                            "few for 1e-8; from 1e12 up what the constraints add hides the tissue. Both say so"});
  axes.push_back({.group = "contact",
                  .name = "stiffness_ratio_at_low_weight",
                  .unit = "",
                  .about = "a pair: stiffness of the needle at a weight of 10",
                  .truth = balances,
                  .normal = 1e4,
                  .values = stiffness_ratios,
                  .more_values = more_stiffness_ratios,
                  .at =
                      [](double value) {
                        return insertion(value, "stiffness_ratio", {.needle_modulus = 1e5 * value, .weight = 10.0});
                      },
                  .safe = {1.0, 1e10},
                  .answered = {1.0, 1e10},
                  .reason = stiffness_limit});
  axes.push_back({.group = "contact",
                  .name = "stiffness_ratio_at_high_weight",
                  .unit = "",
                  .about = "a pair: stiffness of the needle at a weight of 1e8",
                  .truth = balances,
                  .normal = 1e4,
                  .values = stiffness_ratios,
                  .more_values = more_stiffness_ratios,
                  .at =
                      [](double value) {
                        return insertion(value, "stiffness_ratio", {.needle_modulus = 1e5 * value, .weight = 1e8});
                      },
                  .safe = {1.0, 1e10},
                  .answered = {1.0, 1e10},
                  .reason = stiffness_limit});
  axes.push_back({.group = "contact",
                  .name = "mass_ratio",
                  .unit = "",
                  .about = "density of the needle over the tissue's",
                  .truth = balances,
                  .normal = 1.0,
                  .values = {1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6},
                  .more_values = {1e-15, 1e-12, 10.0, 100.0, 1e4, 1e5, 1e7, 1e9, 1e12},
                  .at = [](double value) { return insertion(value, "mass_ratio", {.needle_density = 1000.0 * value}); },
                  .safe = {1e-9, 1e6},
                  .answered = {1e-9, 1e6},
                  .reason = "none was found"});
  axes.push_back({.group = "contact",
                  .name = "insertion_time_step",
                  .unit = "s",
                  .about = "a needle in and out in 116 frames; in shorter ones its waves do not reach the tip",
                  .truth = balances,
                  .normal = 0.01,
                  .values = {1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0, 1e3},
                  .more_values = {100.0, 1e4, 1e6, 1e9},
                  .at = [](double value) { return insertion(value, "insertion_time_step", {.tau = value}); },
                  .safe = {1e-6, 1e3},
                  .answered = {1e-6, 1e3},
                  .reason = "none was found in what these frames can show"});
  axes.push_back({.group = "contact",
                  .name = "friction",
                  .unit = "",
                  .about = "Coulomb's coefficient of shaft and tip",
                  .truth = balances,
                  .normal = 0.5,
                  .values = {0.0, 1e-6, 1e-3, 0.1, 0.5, 1.0, 3.0, 10.0},
                  .more_values = {1e-12, 0.2, 2.0, 5.0, 30.0, 100.0, 1e3, 1e6},
                  .at = [](double value) { return insertion(value, "friction", {.friction = value}); },
                  .safe = {0.0, 10.0},
                  .answered = {0.0, 10.0},
                  .reason = "none to 10"});
  axes.push_back({.group = "contact",
                  .name = "length_unit",
                  .unit = "per m",
                  .about = "how many units of length a metre has: a needle in and out",
                  .truth = "the forces in metres",
                  .normal = 1.0,
                  .values = {1e-6, 1e-3, 1.0, 1e3, 1e6},
                  .more_values = {1e-12, 1e-9, 10.0, 39.37007874, 100.0, 1e9, 1e12},
                  .at = [](double value) { return like_another(value, "length_unit", {.metre = value}, {}, 1e-6); },
                  .safe = {1e-6, 1e6},
                  .answered = {1e-6, 1e6},
                  .reason = "none was found"});
  axes.push_back({.group = "contact",
                  .name = "beside_face",
                  .unit = "cells",
                  .about = "distance of the needle's axis from a face between cells, along which it goes",
                  .truth = "the forces on the face, but for what so small a distance can change",
                  .normal = 0.1,
                  .values = offsets,
                  .more_values = more_offsets,
                  .at = [](double value) { return beside(value, "beside_face", 0.01, 0.014, value); },
                  .safe = {0.0, 0.5},
                  .answered = {0.0, 0.5},
                  .reason = "none: points belong to one leaf, and a field is the same in all that share them"});
  axes.push_back({.group = "contact",
                  .name = "beside_edge",
                  .unit = "cells",
                  .about = "distance from a line of nodes and edges, which it enters at a node",
                  .truth = "the forces on the line, but for what so small a distance can change",
                  .normal = 0.1,
                  .values = offsets,
                  .more_values = more_offsets,
                  .at = [](double value) { return beside(value, "beside_edge", 0.01, 0.01, value); },
                  .safe = {0.0, 0.5},
                  .answered = {0.0, 0.5},
                  .reason = "none: points belong to one leaf, and a field is the same in all that share them"});
  axes.push_back({.group = "contact",
                  .name = "under_surface",
                  .unit = "cells",
                  .about = "distance from the block's side, under which it goes",
                  .truth = "balances; on the side itself either answer, none or a grazing contact",
                  .normal = 0.5,
                  .values = offsets,
                  .more_values = more_offsets,
                  .at = under_surface,
                  .safe = {0.0, 0.5},
                  .answered = {0.0, 0.5},
                  .reason =
                      "none: at a weight of 100 a frame within a tenth of a cell of the side would not settle its "
                      "multipliers in a hundred iterations, at the usual one twenty are enough"});
  axes.push_back({.group = "contact",
                  .name = "grazing_angle",
                  .unit = "degrees",
                  .about = "angle of the needle and the surface that it enters",
                  .truth = "equilibrium and energy",
                  .normal = 90.0,
                  .values = {1e-9, 1e-6, 1e-3, 0.1, 1.0, 5.0, 10.0, 30.0, 60.0, 90.0},
                  .more_values = {1e-12, 1e-7, 1e-5, 1e-4, 1e-2, 0.3, 2.0, 3.0, 20.0, 45.0},
                  .at = grazing,
                  .safe = {1e-9, 90.0},
                  .answered = {5.0, 90.0},
                  .reason =
                      "at 1 degree one frame, with the tip just through the surface, does not settle in a hundred "
                      "iterations, and says so; below 1e-6 degrees it starts on the surface, and is refused"});
  axes.push_back({.group = "contact",
                  .name = "coarsening_under_needle",
                  .unit = "levels",
                  .about = "halvings around the needle that may go as soon as the stress falls",
                  .truth = balances,
                  .normal = 1.0,
                  .values = {1, 2, 3},
                  .more_values = {4, 5},
                  .at = coarsening,
                  .safe = {1, 3},
                  .answered = {1, 3},
                  .reason = "none: contact points are material points, which no mesh moves"});
  return axes;
}

}  // namespace finegauge
