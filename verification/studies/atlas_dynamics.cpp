#include "verification/studies/atlas_dynamics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "verification/studies/atlas_scene.hpp"

namespace finegauge {
namespace {

/// A column along x, held at x = 0, under a gravity along x; nu = 0, so that it is a chain of masses and springs. One
/// cell is split across, which adds hanging nodes but no place along x.
constexpr const char* column_scene = R"(name = "column"
[box]
size = [0.08, 0.01, 0.01]
cells = [8, 1, 1]
[[refine]]
min = [0.04, 0, 0]
max = [0.05, 1, 1]
template = "1x2x3"
[material]
youngs_modulus = 1e4
poisson_ratio = 0
[[support]]
surface = "x_min"
[dynamics]
time_step = $TAU
duration = $DURATION
density = $DENSITY
mass_damping = $ALPHA
stiffness_damping = $BETA
gravity = [$GRAVITY, 0, 0]
[solver]
relative_residual = 1e-12
[[quantity]]
kind = "displacement"
point = [0.08, 0.005, 0.005]
)";

struct Column {
  double tau = 1e-3, gravity = 9.81, density = 1000.0, mass_damping = 0.0, stiffness_damping = 0.0;
  int frames = 20;
};

std::string column_text(const Column& column) {
  return filled(column_scene, {{"TAU", column.tau},
                               {"DURATION", column.tau * column.frames},
                               {"DENSITY", column.density},
                               {"GRAVITY", column.gravity},
                               {"ALPHA", column.mass_damping},
                               {"BETA", column.stiffness_damping}});
}

/// The same column as a chain, in extended precision: backward Euler in 1D, each step a tridiagonal system. Places 1 to
/// 8; the root does not move.
class Chain {
 public:
  explicit Chain(const Column& column) : column_(column) {
    const long double h = 0.01L, area = 1e-4L;
    k_ = 1e4L * area / h;
    m_.fill(column.density * area * h);
    m_.back() *= 0.5L;
  }
  void step() {
    const long double tau = column_.tau, a = 1.0L + tau * column_.mass_damping;
    const long double s = tau * (column_.stiffness_damping + tau) * k_;
    // (M (1 + τα) + (τβ + τ²) K) v⁺ = M v + τ (M g - K u), by elimination from the root.
    std::array<long double, places> diagonal, right, v;
    for (int i = 0; i < places; ++i) {
      const long double left_u = i > 0 ? u_[i - 1] : 0.0L, right_u = i + 1 < places ? u_[i + 1] : u_[i];
      diagonal[i] = a * m_[i] + s * (i + 1 < places ? 2.0L : 1.0L);
      right[i] = m_[i] * v_[i] + tau * (m_[i] * column_.gravity - k_ * ((u_[i] - left_u) - (right_u - u_[i])));
      if (i == 0) continue;
      const long double factor = -s / diagonal[i - 1];
      diagonal[i] += factor * s;
      right[i] -= factor * right[i - 1];
    }
    for (int i = places - 1; i >= 0; --i) v[i] = (right[i] + (i + 1 < places ? s * v[i + 1] : 0.0L)) / diagonal[i];
    v_ = v;
    for (int i = 0; i < places; ++i) u_[i] += tau * v_[i];
  }
  /// Place i = 0 is the root.
  long double displacement(int i) const { return i == 0 ? 0.0L : u_[i - 1]; }

 private:
  static constexpr int places = 8;
  Column column_;
  long double k_;
  std::array<long double, places> m_{}, u_{}, v_{};
};

AtlasPoint column_point(double value, const Column& column) {
  const std::string text = column_text(column);
  return scene_point(value, text, [&] {
    Chain chain(column);
    double largest = 0.0, eta = 0.0;
    std::string stopped;
    run_scene(scene_from_text(text), [&](const FrameView& view) {
      const FrameReport& frame = view.report.frame;
      if (!frame.converged) {
        stopped = "frame " + std::to_string(frame.frame) + " did not converge and says so";
        return false;
      }
      chain.step();
      const Mesh& mesh = view.tissue.mesh.d.mesh;
      const Eigen::Matrix3Xd& u = view.tissue.state.u;
      double error = 0.0;
      for (int node = 0; node < mesh.node_count(); ++node) {
        const auto place = static_cast<int>(std::lround(mesh.nodes(0, node) / 0.01));
        keep_largest(error, static_cast<double>(std::abs(u(0, node) - chain.displacement(place))));
        keep_largest(error, largest_entry(u.col(node).tail<2>()));
      }
      const auto end = static_cast<double>(std::abs(chain.displacement(8)));
      const double share = end > 0.0 ? error / end : error;
      keep_largest(largest, share);
      if (!std::isfinite(frame.eta.value_or(0.0))) eta = std::numeric_limits<double>::quiet_NaN();
      return true;
    });
    if (!stopped.empty()) return refusal(value, stopped);
    AtlasChecks checks;
    // The solver's residual of 1e-12, over the column's condition of some hundred, through twenty steps.
    checks.add("error of the displacement over the column's end's", largest, 1e-8);
    checks.add("estimated error that is no number", eta, 0.0);
    return checks.point(value);
  });
}

// A body that nothing holds falls as a whole.

constexpr const char* falling_scene = R"(name = "falling"
[box]
size = [0.02, 0.01, 0.01]
cells = [2, 1, 1]
[[refine]]
min = [0.01, 0, 0]
max = [0.02, 1, 1]
template = "2x3x3"
[material]
youngs_modulus = 1e4
poisson_ratio = 0.3
kinematics = "$KINEMATICS"
[dynamics]
time_step = @TAU
duration = @DURATION
density = 1000
gravity = [0, 0, -9.81]
[[quantity]]
kind = "energy"
)";

AtlasPoint falling(double tau, const std::string& kinematics) {
  constexpr int frames = 20;
  std::string text = falling_scene;
  text.replace(text.find("$KINEMATICS"), 11, kinematics);
  std::ranges::replace(text, '@', '$');
  text = filled(text, {{"TAU", tau}, {"DURATION", tau * frames}});
  return scene_point(tau, text, [&] {
    double largest = 0.0;
    std::string stopped;
    run_scene(scene_from_text(text), [&](const FrameView& view) {
      const FrameReport& frame = view.report.frame;
      if (!frame.converged) {
        stopped = "frame " + std::to_string(frame.frame) + " did not converge and says so";
        return false;
      }
      const double n = frame.frame, exact = -9.81 * tau * tau * 0.5 * n * (n + 1.0);
      const Eigen::Matrix3Xd error = view.tissue.state.u.colwise() - Eigen::Vector3d(0.0, 0.0, exact);
      const double share = largest_entry(error) / std::abs(exact);
      keep_largest(largest, share);
      return true;
    });
    if (!stopped.empty()) return refusal(tau, stopped);
    AtlasChecks checks;
    // The usual residual of 1e-9.
    checks.add("error of the fall over it", largest, 1e-6);
    return checks.point(tau);
  });
}

// Decay.

constexpr const char* decay_scene = R"(name = "decay"
[box]
size = [0.02, 0.01, 0.01]
cells = [2, 1, 1]
[[refine]]
min = [0.01, 0, 0]
max = [0.02, 1, 1]
template = "1x2x2"
[material]
youngs_modulus = 1e4
poisson_ratio = 0.3
kinematics = "$KINEMATICS"
[[support]]
surface = "x_min"
displacement = [1e-4, 2e-4, 0]
course = [[0, 0], [0.05, 1], [0.1, 0]]
[dynamics]
time_step = 0.01
duration = @DURATION
density = 1000
stiffness_damping = 1e-3
[adapt]
theta = 0.5
max_depth = 2
[[quantity]]
kind = "energy"
)";

/// Numbers that are not normal: subnormal ones, whose arithmetic is slow, and those that are none.
int abnormal(const Eigen::Matrix3Xd& x) {
  return static_cast<int>(
      std::ranges::count_if(x.reshaped(), [](double value) { return value != 0.0 && !std::isnormal(value); }));
}

AtlasPoint decay(double frames, const std::string& kinematics) {
  std::string text = decay_scene;
  text.replace(text.find("$KINEMATICS"), 11, kinematics);
  std::ranges::replace(text, '@', '$');
  text = filled(text, {{"DURATION", 0.01 * frames}});
  return scene_point(frames, text, [&] {
    double largest_energy = 0.0, last_energy = 0.0, growth = 0.0, eta = 0.0;
    int abnormal_in_a_row = 0, most_in_a_row = 0, unconverged = 0;
    run_scene(scene_from_text(text), [&](const FrameView& view) {
      const FrameReport& frame = view.report.frame;
      unconverged += !frame.converged;
      const bool any = abnormal(view.tissue.state.u) + abnormal(view.tissue.state.v) > 0;
      abnormal_in_a_row = any ? abnormal_in_a_row + 1 : 0;
      most_in_a_row = std::max(most_in_a_row, abnormal_in_a_row);
      const double energy = frame.energy.kinetic + frame.energy.elastic;
      keep_largest(largest_energy, energy);
      if (frame.frame > 12) keep_largest(growth, energy - last_energy);  // the pulse is over
      last_energy = energy;
      if (!std::isfinite(frame.eta.value_or(0.0))) eta = std::numeric_limits<double>::quiet_NaN();
      return true;
    });
    AtlasChecks checks;
    // What symmetry makes zero falls by some 15 decades a frame to zero, and so passes the 16 decades of the subnormal
    // numbers once.
    checks.add("frames in a row with subnormal numbers or none at all", most_in_a_row, 10.0);
    checks.add("frames that did not converge", unconverged, 0.0);
    checks.add("largest growth of the energy in a frame, over its largest", growth / largest_energy, 1e-12);
    checks.add("energy at the end over the largest", last_energy / largest_energy, 1e-20);
    checks.add("estimated error that is no number", eta, 0.0);
    return checks.point(frames);
  });
}

const std::vector<double> steps = {1e-9, 1e-7, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0, 1e3};
const std::vector<double> more_steps = {1e-150, 1e-100, 1e-60, 1e-30, 1e-20, 1e-12, 1e-11, 1e-10, 1e-8, 1e-6,
                                        1e4,    1e5,    1e6,   1e8,   1e12,  1e20,  1e30,  1e60,  1e100};
const std::vector<double> densities = {1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9, 1e12};
const std::vector<double> more_densities = {1e-300, 1e-100, 1e-30, 1e-20, 1e-15, 1e-12, 1e15, 1e20, 1e30, 1e100, 1e300};

}  // namespace

std::vector<AtlasAxis> dynamics_axes() {
  std::vector<AtlasAxis> axes;
  const std::string chain = "the chain of masses and springs that it is, in extended precision";
  axes.push_back({.group = "dynamics",
                  .name = "time_step",
                  .unit = "s",
                  .about = "twenty steps of a hanging column",
                  .truth = chain,
                  .normal = 1e-3,
                  .values = steps,
                  .more_values = more_steps,
                  .at = [](double value) { return column_point(value, {.tau = value}); },
                  .safe = {1e-9, 1e3},
                  .answered = {1e-9, 1e3},
                  .reason = "none was found"});
  axes.push_back({.group = "dynamics",
                  .name = "time_step_free_fall",
                  .unit = "s",
                  .about = "twenty steps of a block that nothing holds, linear",
                  .truth = "the fall of a point, g tau^2 n (n + 1) / 2",
                  .normal = 1e-3,
                  .values = steps,
                  .more_values = more_steps,
                  .at = [](double value) { return falling(value, "linear"); },
                  .safe = {1e-9, 1e3},
                  .answered = {1e-9, 1.0},
                  .reason = "tau^2 K outweighs the mass, a hundred thousand times at 1 s: beside the round-off of K "
                            "the force of a rigid motion cannot be solved to 1e-9, and the solve says so"});
  axes.push_back({.group = "dynamics",
                  .name = "time_step_free_fall_corotational",
                  .unit = "s",
                  .about = "the same, corotational",
                  .truth = "the fall of a point, g tau^2 n (n + 1) / 2",
                  .normal = 1e-3,
                  .values = steps,
                  .more_values = more_steps,
                  .at = [](double value) { return falling(value, "corotational"); },
                  .safe = {1e-9, 1e3},
                  .answered = {1e-9, 1.0},
                  .reason = "tau^2 K outweighs the mass, a hundred thousand times at 1 s: beside the round-off of K "
                            "the force of a rigid motion cannot be solved to 1e-9, and the solve says so"});
  axes.push_back({.group = "dynamics",
                  .name = "density",
                  .unit = "kg/m^3",
                  .about = "twenty steps of 1 ms of the hanging column",
                  .truth = chain,
                  .normal = 1e3,
                  .values = densities,
                  .more_values = more_densities,
                  .at = [](double value) { return column_point(value, {.density = value}); },
                  .safe = {1e-9, 1e12},
                  .answered = {1e-9, 1e12},
                  .reason = "none found: forces of linear tissue come from displacements themselves, however small"});
  axes.push_back({.group = "dynamics",
                  .name = "density_at_short_step",
                  .unit = "kg/m^3",
                  .about = "a pair: density in steps of 1e-9 s",
                  .truth = chain,
                  .normal = 1e3,
                  .values = densities,
                  .more_values = more_densities,
                  .at = [](double value) { return column_point(value, {.tau = 1e-9, .density = value}); },
                  .safe = {1e-9, 1e12},
                  .answered = {1e-9, 1e12},
                  .reason = "none found: forces of linear tissue come from displacements themselves, however small"});
  axes.push_back({.group = "dynamics",
                  .name = "density_at_long_step",
                  .unit = "kg/m^3",
                  .about = "a pair: density in steps of 1e3 s",
                  .truth = chain,
                  .normal = 1e3,
                  .values = densities,
                  .more_values = more_densities,
                  .at = [](double value) { return column_point(value, {.tau = 1e3, .density = value}); },
                  .safe = {1e-9, 1e12},
                  .answered = {1e-9, 1e12},
                  .reason = "none found: forces of linear tissue come from displacements themselves, however small"});
  axes.push_back(
      {.group = "dynamics",
       .name = "gravity",
       .unit = "m/s^2",
       .about = "twenty steps of 1 ms of the hanging column",
       .truth = chain,
       .normal = 9.81,
       .values = {0.0, 1e-9, 1e-6, 1e-3, 1.0, 9.81, 1e3, 1e6, 1e9},
       .more_values = {1e-30, 1e-20, 1e-12, 1e12, 1e20, 1e30, 1e100},
       .at = [](double value) { return column_point(value, {.gravity = value}); },
       .safe = {0.0, 1e9},
       .answered = {0.0, 1e9},
       .reason =
           "none found: forces of linear tissue come from displacements themselves, however small; zero is zero"});
  const std::vector<double> dampings = {0.0, 1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6};
  const std::vector<double> more_dampings = {1e-30, 1e-15, 1e9, 1e12, 1e15, 1e30, 1e100, 1e300};
  axes.push_back({.group = "dynamics",
                  .name = "stiffness_damping",
                  .unit = "s",
                  .about = "Rayleigh's beta, twenty steps of 1 ms of the hanging column",
                  .truth = chain,
                  .normal = 1e-3,
                  .values = dampings,
                  .more_values = more_dampings,
                  .at = [](double value) { return column_point(value, {.stiffness_damping = value}); },
                  .safe = {0.0, 1e6},
                  .answered = {0.0, 1e6},
                  .reason = "none was found"});
  axes.push_back({.group = "dynamics",
                  .name = "mass_damping",
                  .unit = "1/s",
                  .about = "Rayleigh's alpha, twenty steps of 1 ms of the hanging column",
                  .truth = chain,
                  .normal = 1.0,
                  .values = dampings,
                  .more_values = more_dampings,
                  .at = [](double value) { return column_point(value, {.mass_damping = value}); },
                  .safe = {0.0, 1e6},
                  .answered = {0.0, 1e6},
                  .reason = "none was found"});
  axes.push_back(
      {.group = "dynamics",
       .name = "decay_frames",
       .unit = "frames",
       .about = "a block shaken once and left to itself, its mesh adaptive, linear",
       .truth = "energy that never grows and ends far below what it was, in normal numbers",
       .normal = 1e3,
       .values = {1e3, 3e3},
       .more_values = {1e4, 1e5, 1e6},
       .at = [](double value) { return decay(value, "linear"); },
       .safe = {1e3, 3e3},
       .answered = {1e3, 3e3},
       .reason =
           "none: what decays ends where the squares of numbers vanish, near 1e-160, far above the subnormal ones"});
  axes.push_back(
      {.group = "dynamics",
       .name = "decay_frames_corotational",
       .unit = "frames",
       .about = "the same, corotational",
       .truth = "energy that never grows and ends far below what it was, in normal numbers",
       .normal = 1e3,
       .values = {1e3, 3e3},
       .more_values = {1e4, 1e5, 1e6},
       .at = [](double value) { return decay(value, "corotational"); },
       .safe = {1e3, 3e3},
       .answered = {1e3, 3e3},
       .reason =
           "none: what decays ends where the squares of numbers vanish, near 1e-160, far above the subnormal ones"});
  return axes;
}

}  // namespace finegauge
