#include "verification/studies/atlas_material.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include "verification/studies/atlas_scene.hpp"

namespace finegauge {
namespace {

std::string digits(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

std::string row(std::initializer_list<double> values) {
  std::string text = "[";
  for (const double value : values) text += (text.size() > 1 ? ", " : "") + digits(value);
  return text + "]";
}

// The thick cylinder of MacNeal and Harder (1985): a quarter of it, one layer in plane strain, a pressure inside.

constexpr int around = 8, through = 6;
constexpr double inner = 3.0, outer = 9.0, modulus = 1000.0, pressure = 1.0;

int cylinder_node(int i, int j, int k) { return (k * (through + 1) + j) * (around + 1) + i; }  // angle, radius, layer

std::string cylinder_scene(double half_minus_nu, bool mean) {
  const auto angle = [](double i) { return 0.5 * std::numbers::pi * i / around; };
  std::string nodes, cells;
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j <= through; ++j)
      for (int i = 0; i <= around; ++i) {
        const double r = inner * std::pow(outer / inner, static_cast<double>(j) / through);
        // On the planes of symmetry the coordinate is zero, not its rounded cosine.
        const double x = i == around ? 0.0 : r * std::cos(angle(i)), y = i == 0 ? 0.0 : r * std::sin(angle(i));
        nodes += "  " + row({x, y, 0.5 * k}) + ",\n";
      }
  for (int j = 0; j < through; ++j)
    for (int i = 0; i < around; ++i) {
      cells += "  [";
      for (int k = 0; k < 2; ++k)
        for (const auto& [di, dj] : {std::array{0, 0}, {0, 1}, {1, 1}, {1, 0}})
          cells += std::to_string(cylinder_node(i + di, j + dj, k)) + ", ";
      cells += "],\n";
    }
  std::string text =
      "name = \"thick_cylinder\"\nunits = \"none\"\n[mesh]\nnodes = [\n" + nodes + "]\ncells = [\n" + cells + "]\n";
  text += "[material]\nyoungs_modulus = " + digits(modulus) + "\npoisson_ratio = $NU\ndilatation = \"" +
          (mean ? "mean" : "standard") + "\"\n";
  // A pressure is a traction along each flat face's own normal.
  for (int i = 0; i < around; ++i) {
    const std::string name = "inside_" + std::to_string(i);
    text += "[[surface]]\nname = \"" + name + "\"\nnodes = [";
    for (const auto& [a, k] : {std::array{i, 0}, {i + 1, 0}, {i, 1}, {i + 1, 1}})
      text += std::to_string(cylinder_node(a, 0, k)) + ", ";
    text += "]\n[[load]]\nsurface = \"" + name +
            "\"\ntraction = " + row({pressure * std::cos(angle(i + 0.5)), pressure * std::sin(angle(i + 0.5)), 0.0}) +
            "\n";
  }
  for (const auto& [surface, component] : {std::pair{"x_min", "x"}, {"y_min", "y"}, {"z_min", "z"}, {"z_max", "z"}})
    text += std::string("[[support]]\nsurface = \"") + surface + "\"\ncomponents = [\"" + component + "\"]\n";
  text += "[[quantity]]\nkind = \"energy\"\n";
  return filled(text, {{"NU", 0.5 - half_minus_nu}});
}

/// Largest error of a node's displacement over the largest displacement. Lamé's solution in plane strain,
///   u_r = p a² (1 + nu) / (E (b² - a²)) ((1 - 2 nu) r + b² / r).
double cylinder_error(const StaticEnd& end) {
  const Mesh& mesh = end.solution.discretization.mesh;
  const double nu = end.scene.material.poisson_ratio, a2 = inner * inner, b2 = outer * outer;
  double error = 0.0, size = 0.0;
  for (int node = 0; node < mesh.node_count(); ++node) {
    const Eigen::Vector3d X = mesh.nodes.col(node);
    const double r = X.head<2>().norm();
    const double u_r = pressure * a2 * (1.0 + nu) / (modulus * (b2 - a2)) * ((1.0 - 2.0 * nu) * r + b2 / r);
    const Eigen::Vector3d exact(u_r * X.x() / r, u_r * X.y() / r, 0.0);
    keep_largest(error, (end.solution.equilibrium.u.col(node) - exact).norm());
    size = std::max(size, exact.norm());
  }
  return error / size;
}

AtlasPoint incompressible(double half_minus_nu, bool mean) {
  const std::string text = cylinder_scene(half_minus_nu, mean);
  return scene_point(half_minus_nu, text, [&] {
    const StaticEnd end = solve_scene(text);
    if (const std::string why = why_unsolved(end.solution.equilibrium); !why.empty())
      return refusal(half_minus_nu, why);
    AtlasChecks checks;
    checks.add("error of the displacement over its largest", cylinder_error(end), 0.05);
    return checks.point(half_minus_nu);
  });
}

// Bodies under a constant strain: exact but for round-off, whatever the mesh.

/// MacNeal and Harder's seven distorted cells; every strain component is 1e-3.
constexpr const char* patch_scene = R"(name = "patch"
units = "none"
[mesh]
nodes = [
  [0.249, 0.342, 0.192], [0.826, 0.288, 0.288], [0.850, 0.649, 0.263], [0.273, 0.750, 0.230],
  [0.320, 0.186, 0.643], [0.677, 0.305, 0.683], [0.788, 0.693, 0.644], [0.165, 0.745, 0.702],
  [0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1],
]
cells = [
  [0, 1, 2, 3, 4, 5, 6, 7], [8, 9, 10, 11, 0, 1, 2, 3], [4, 5, 6, 7, 12, 13, 14, 15], [8, 9, 1, 0, 12, 13, 5, 4],
  [9, 10, 2, 1, 13, 14, 6, 5], [10, 11, 3, 2, 14, 15, 7, 6], [11, 8, 0, 3, 15, 12, 4, 7],
]
[material]
youngs_modulus = 1e6
poisson_ratio = $NU
dilatation = "mean"
[[support]]
surface = "boundary"
gradient = [[1e-3, 0.5e-3, 0.5e-3], [0.5e-3, 1e-3, 0.5e-3], [0.5e-3, 0.5e-3, 1e-3]]
[[quantity]]
kind = "energy"
)";

double patch_error(const StaticEnd& end) {
  const Eigen::Matrix3d G = (Eigen::Matrix3d() << 1, 0.5, 0.5, 0.5, 1, 0.5, 0.5, 0.5, 1).finished() * 1e-3;
  const Eigen::Matrix3Xd exact = G * end.solution.discretization.mesh.nodes;
  return largest_entry(end.solution.equilibrium.u - exact) / largest_entry(exact);
}

AtlasPoint patch(double value, double nu) {
  const std::string text = filled(patch_scene, {{"NU", nu}});
  return scene_point(value, text, [&] {
    const StaticEnd end = solve_scene(text);
    if (const std::string why = why_unsolved(end.solution.equilibrium); !why.empty()) return refusal(value, why);
    AtlasChecks checks;
    checks.add("error of the displacement over its largest", patch_error(end), 1e-3);
    return checks.point(value);
  });
}

/// Two cells, one of them refined 2x3x3, sliding on three planes and pulled along x.
constexpr const char* pulled_scene = R"(name = "pulled"
[box]
size = [1, 0.5, 0.5]
cells = [2, 1, 1]
[[refine]]
min = [0.5, 0, 0]
max = [1, 0.5, 0.5]
template = "2x3x3"
[material]
youngs_modulus = $E
poisson_ratio = 0.3
kinematics = "corotational"
[[support]]
surface = "x_min"
components = ["x"]
[[support]]
surface = "y_min"
components = ["y"]
[[support]]
surface = "z_min"
components = ["z"]
[[load]]
surface = "x_max"
traction = [$TRACTION, 0, 0]
[solver]
relative_residual = 1e-12
newton_residual = 1e-12
[[quantity]]
kind = "energy"
)";

AtlasPoint youngs_modulus(double E) {
  const std::string text = filled(pulled_scene, {{"E", E}, {"TRACTION", 1e-3 * E}});
  return scene_point(E, text, [&] {
    const StaticEnd end = solve_scene(text);
    if (const std::string why = why_unsolved(end.solution.equilibrium); !why.empty()) return refusal(E, why);
    const Eigen::Matrix3Xd exact =
        Eigen::Vector3d(1e-3, -0.3e-3, -0.3e-3).asDiagonal() * end.solution.discretization.mesh.nodes;
    AtlasChecks checks;
    checks.add("error of the displacement over its largest", largest_entry(end.solution.equilibrium.u - exact) / 1e-3,
               1e-9);
    checks.add("relative estimated error of a uniform stress", end.solution.estimate.relative, 1e-7);
    return checks.point(E);
  });
}

/// A clamped cantilever: the stress varies, so that there is an estimated error.
constexpr const char* loaded_scene = R"(name = "loaded"
[box]
size = [2, 1, 1]
cells = [4, 2, 2]
[[refine]]
min = [0, 0, 0]
max = [0.5, 1, 1]
[material]
youngs_modulus = 1e4
poisson_ratio = 0.3
[[support]]
surface = "x_min"
[[load]]
surface = "x_max"
traction = [0, 0, $TRACTION]
[solver]
relative_residual = 1e-12
[[quantity]]
kind = "energy"
)";

AtlasPoint load(double traction) {
  const std::string text = filled(loaded_scene, {{"TRACTION", traction}});
  return scene_point(traction, text, [&] {
    const StaticEnd unit = solve_scene(filled(loaded_scene, {{"TRACTION", 1.0}}));
    const StaticEnd end = solve_scene(text);
    if (const std::string why = why_unsolved(end.solution.equilibrium); !why.empty()) return refusal(traction, why);
    AtlasChecks checks;
    const Eigen::Matrix3Xd& u_1 = unit.solution.equilibrium.u;
    const double largest = largest_entry(u_1);
    checks.add("change of the displacement per load",
               largest_entry(end.solution.equilibrium.u / traction - u_1) / largest, 1e-9);
    checks.add("change of the relative estimated error",
               std::abs(end.solution.estimate.relative - unit.solution.estimate.relative), 1e-9);
    return checks.point(traction);
  });
}

/// Nothing acts on a body: zero over zero wherever something is relative. Kinds: 0 static and linear, 1 static and
/// corotational, 2 moving.
AtlasPoint nothing_acts(double kind) {
  std::string text = filled(loaded_scene, {{"TRACTION", 0.0}});
  if (kind == 1.0) text.insert(text.find("[[support]]"), "kinematics = \"corotational\"\n");
  if (kind == 2.0) {
    text.insert(text.find("[[support]]"), "[dynamics]\ntime_step = 0.01\nduration = 0.2\ndensity = 1000\n");
    text += "[adapt]\ntolerance = 0.05\nmax_depth = 3\n";
  }
  return scene_point(kind, text, [&] {
    AtlasChecks checks;
    if (kind < 2.0) {
      const StaticEnd end = solve_scene(text);
      if (const std::string why = why_unsolved(end.solution.equilibrium); !why.empty()) return refusal(kind, why);
      checks.add("displacement without a load [m]", largest_entry(end.solution.equilibrium.u), 0.0);
      checks.add("relative estimated error of nothing", end.solution.estimate.relative, 0.0);
      return checks.point(kind);
    }
    double moved = 0.0, eta = 0.0, unconverged = 0.0;
    run_scene(scene_from_text(text), [&](const FrameView& view) {
      unconverged += view.report.frame.converged ? 0.0 : 1.0;
      keep_largest(moved, largest_entry(view.tissue.state.u));
      keep_largest(moved, largest_entry(view.tissue.state.v));
      keep_largest(eta, view.report.frame.eta.value());
      return true;
    });
    checks.add("frames that did not converge", unconverged, 0.0);
    checks.add("displacement [m] or velocity [m/s] without a load", moved, 0.0);
    checks.add("relative estimated error of nothing", eta, 0.0);
    return checks.point(kind);
  });
}

}  // namespace

std::vector<AtlasAxis> material_axes() {
  std::vector<AtlasAxis> axes;
  axes.push_back({.group = "material",
                  .name = "incompressibility_mean",
                  .unit = "1/2 - nu",
                  .about = "MacNeal and Harder's thick cylinder under pressure, mean dilatation",
                  .truth = "Lamé's solution; 5 % is seven times what the mesh leaves of it",
                  .normal = 0.1,
                  .values = {1e-12, 1e-10, 1e-9, 1e-8, 1e-6, 1e-4, 1e-2, 0.1, 0.2},
                  .more_values = {1e-14, 1e-13, 1e-11, 1e-7, 1e-5, 1e-3, 0.5},
                  .at = [](double value) { return incompressible(value, true); },
                  .safe = {1e-12, 0.2},
                  .answered = {1e-9, 0.2},
                  .reason = "the bulk part of the matrix is 1 / (1 - 2 nu) times the rest: from 1e-10 on its round-off "
                            "alone leaves more than the residual of 1e-6 that is asked for, and the solve says so"});
  axes.push_back(
      {.group = "material",
       .name = "incompressibility_standard",
       .unit = "1/2 - nu",
       .about = "the same cylinder with the dilatation at each quadrature point",
       .truth = "Lamé's solution",
       .normal = 0.1,
       .values = {1e-12, 1e-8, 1e-6, 1e-4, 1e-3, 1e-2, 3e-2, 0.1, 0.2},
       .more_values = {1e-10, 1e-5, 3e-3, 0.5},
       .at = [](double value) { return incompressible(value, false); },
       .safe = {3e-2, 0.2},
       .answered = {3e-2, 0.2},
       .reason =
           "cells that keep their volume at eight points each lock: 5 % at nu = 0.47, 13 % at 0.49, 93 % at 0.4999, "
           "and nothing in the result says so; that is the plain trilinear cell, and why there is another"});
  axes.push_back({.group = "material",
                  .name = "incompressibility_patch",
                  .unit = "1/2 - nu",
                  .about = "seven distorted cells under a constant strain that changes their volume, mean dilatation",
                  .truth = "the linear field itself",
                  .normal = 0.2,
                  .values = {1e-12, 1e-11, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2, 0.2},
                  .more_values = {1e-14, 1e-13, 1e-9, 1e-7, 1e-5, 1e-3, 0.5},
                  .at = [](double value) { return patch(value, 0.5 - value); },
                  .safe = {1e-12, 0.2},
                  .answered = {1e-12, 0.2},
                  .reason = "the error is the unit round-off times the condition, 5e-17 over 1/2 - nu"});
  axes.push_back(
      {.group = "material",
       .name = "auxetic",
       .unit = "1 + nu",
       .about = "the same patch with Poisson's ratio towards -1, where the shear modulus is infinite",
       .truth = "the linear field itself",
       .normal = 1.0,
       .values = {1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2, 0.1, 1.0, 1.4},
       .more_values = {1e-15, 1e-14, 1e-13, 1e-11, 1e-9, 1e-7, 1e-5, 1e-3},
       .at = [](double value) { return patch(value, value - 1.0); },
       .safe = {1e-12, 1.4},
       .answered = {1e-12, 1.4},
       .reason =
           "none was found: a linear field under prescribed displacements asks for no difference of large terms"});
  axes.push_back({.group = "material",
                  .name = "youngs_modulus",
                  .unit = "Pa",
                  .about = "a pulled block with hanging nodes, its load in proportion, corotational",
                  .truth = "uniaxial tension, exact on every mesh",
                  .normal = 1e4,
                  .values = {1e-300, 1e-100, 1e-50, 1e-30, 1e-6, 1.0, 1e4, 1e8, 1e12, 1e30, 1e50, 1e100},
                  .more_values = {1e-200, 1e-60, 1e-57, 1e-10, 1e20, 1e60, 1e62, 1e200, 1e300},
                  .at = youngs_modulus,
                  .safe = {1e-300, 1e100},
                  .answered = {1e-50, 1e50},
                  .reason = "scenes take magnitudes from 1e-60 to 1e60; norms are sums of squares, which overflow from "
                            "1e154 on and vanish below 1e-154, where a load would be taken for none"});
  axes.push_back({.group = "material",
                  .name = "load",
                  .unit = "Pa",
                  .about = "the traction on a clamped cantilever with hanging nodes, linear",
                  .truth = "displacement in proportion and the same relative error as under 1 Pa",
                  .normal = 1.0,
                  .values = {1e-300, 1e-100, 1e-50, 1e-30, 1e-10, 1.0, 1e10, 1e30, 1e50, 1e100, 1e200},
                  .more_values = {1e-200, 1e-60, 1e-40, 1e-20, 1e20, 1e40, 1e60, 1e300},
                  .at = load,
                  .safe = {1e-300, 1e200},
                  .answered = {1e-50, 1e50},
                  .reason = "scenes take magnitudes from 1e-60 to 1e60; norms are sums of squares, which overflow from "
                            "1e154 on and vanish below 1e-154, where a load would be taken for none"});
  axes.push_back(
      {.group = "material",
       .name = "nothing_acts",
       .unit = "kind",
       .about = "no load, no gravity, no energy: 0 static linear, 1 static corotational, 2 moving and adaptive",
       .truth = "a body at rest, and an estimated error of zero",
       .normal = 0.0,
       .values = {0, 1, 2},
       .more_values = {},
       .at = nothing_acts,
       .safe = {0, 2},
       .answered = {0, 2},
       .reason = "all there are"});
  return axes;
}

}  // namespace finegauge
