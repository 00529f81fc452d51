#include "verification/studies/atlas_mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "verification/studies/atlas_scene.hpp"

namespace finegauge {
namespace {

// Slender cells.

/// A block of 2 × 2 × 2 cells, as many times longer than high as its cells are, each refined twice, sliding on three
/// planes and pulled along x: bending of the long block is as soft beside its tension as a mode can be.
constexpr const char* slender_scene = R"(name = "slender"
units = "none"
[box]
size = [$ASPECT, 1, 1]
cells = [2, 2, 2]
[[refine]]
all = true
levels = 2
[material]
youngs_modulus = 1e4
poisson_ratio = 0.3
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
traction = [10, 0, 0]
)";

AtlasPoint slender(double aspect, const std::string& method) {
  const std::string text = filled(slender_scene, {{"ASPECT", aspect}}) + "[solver]\nmethod = \"" + method +
                           "\"\n[[quantity]]\nkind = \"energy\"\n";
  return scene_point(aspect, text, [&] {
    const StaticEnd end = solve_scene(text);
    if (const std::string why = why_unsolved(end.solution.equilibrium); !why.empty()) return refusal(aspect, why);
    const Eigen::Matrix3Xd exact =
        Eigen::Vector3d(1e-3, -0.3e-3, -0.3e-3).asDiagonal() * end.solution.discretization.mesh.nodes;
    const Eigen::Matrix3Xd error = end.solution.equilibrium.u - exact;
    AtlasChecks checks;
    // Each direction by its own size: across a long block the displacement is small beside that along it.
    checks.add("error along the cells", largest_entry(error.row(0)) / (1e-3 * aspect), 1e-3);
    checks.add("error across the cells", largest_entry(error.bottomRows<2>()) / 0.3e-3, 1e-2);
    return checks.point(aspect);
  });
}

// Depth.

constexpr double usual = 1e-6, tight = 1e-12;  // relative residuals: what a scene gets, and near to round-off

/// 2 × 2 × 2 cells, the first of which is refined towards their common corner, level after level: its smallest leaf
/// touches seven cells that are not refined at all. The block slides on three planes and is pulled along x.
std::string deep_scene(int levels, double nu, const std::string& division, double residual) {
  std::string text = R"(name = "deep"
units = "none"
[box]
size = [2, 2, 2]
cells = [2, 2, 2]
)";
  const double parts = division[0] - '0';
  double size = 1.0;
  for (int level = 0; level < levels; ++level, size /= parts) {
    // The leaf at the corner (1, 1, 1) and no other has its centre here.
    text += "[[refine]]\ntemplate = \"" + division + "\"\n" +
            filled("min = [$LOW, $LOW, $LOW]\nmax = [$HIGH, $HIGH, $HIGH]\n",
                   {{"LOW", 1.0 - 0.75 * size}, {"HIGH", 1.0 - 0.25 * size}});
  }
  return text + filled(R"([material]
youngs_modulus = 1e4
poisson_ratio = $NU
dilatation = "mean"
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
traction = [10, 0, 0]
[solver]
relative_residual = $RESIDUAL
[[quantity]]
kind = "energy"
)",
                       {{"NU", nu}, {"RESIDUAL", residual}});
}

/// Strains of the smallest leaves, not only displacements, are what depth endangers: differences between nodes that
/// lie close together.
AtlasPoint deep(double value, int levels, double nu, const std::string& division, double residual) {
  const std::string text = deep_scene(levels, nu, division, residual);
  return scene_point(value, text, [&] {
    const StaticEnd end = solve_scene(text);
    if (const std::string why = why_unsolved(end.solution.equilibrium); !why.empty()) return refusal(value, why);
    const Mesh& mesh = end.solution.discretization.mesh;
    const Eigen::Matrix3Xd error =
        end.solution.equilibrium.u - Eigen::Vector3d(1e-3, -1e-3 * nu, -1e-3 * nu).asDiagonal() * mesh.nodes;
    double strain_error = 0.0;
    int depth = 0;
    for (int cell = 0; cell < mesh.cell_count(); ++cell) {
      const auto& c = mesh.cells[cell];
      depth = std::max(depth, mesh.frames[cell].depth);
      for (const int corner : {1, 2, 4}) {
        const double edge = (mesh.nodes.col(c[corner]) - mesh.nodes.col(c[0])).norm();
        keep_largest(strain_error, (error.col(c[corner]) - error.col(c[0])).norm() / edge);
      }
    }
    AtlasChecks checks;
    checks.add("levels that are not there", levels - depth, 0.0);
    checks.add("error of the displacement over its largest", largest_entry(error) / 2e-3, 1e-4);
    checks.add("error of the strain in a cell, over it", strain_error / 1e-3, 1e-3);
    return checks.point(value);
  });
}

// Cells that are filled in part.

constexpr double lattice_cell = 0.25;

/// A bar along x whose last layer of lattice cells is filled to the share; as long as three whole layers and that.
AtlasFile bar_surface(double share) {
  AtlasFile file{"bar.obj", ""};
  const double length = lattice_cell * (3.0 + share), width = 2 * lattice_cell;
  for (int c = 0; c < 8; ++c)
    file.content +=
        filled("v $X $Y $Z\n", {{"X", (c & 1) * length}, {"Y", (c >> 1 & 1) * width}, {"Z", (c >> 2 & 1) * width}});
  // Outward.
  for (const auto& f : {std::array{1, 5, 7, 3}, {2, 4, 8, 6}, {1, 2, 6, 5}, {3, 7, 8, 4}, {1, 3, 4, 2}, {5, 6, 8, 7}}) {
    file.content += "f " + std::to_string(f[0]) + " " + std::to_string(f[1]) + " " + std::to_string(f[2]) + "\n";
    file.content += "f " + std::to_string(f[0]) + " " + std::to_string(f[2]) + " " + std::to_string(f[3]) + "\n";
  }
  return file;
}

constexpr const char* bar_scene = R"(name = "cut_bar"
[organ]
surface = "bar.obj"
cell_size = 0.25
origin = [0, 0, 0]
[material]
youngs_modulus = 1e4
poisson_ratio = 0.3
[[attachment]]
name = "root"
box_min = [-0.01, -0.01, -0.01]
box_max = [0.01, 1, 1]
[[load]]
body_force = [0, 0, -10]
[solver]
relative_residual = 1e-10
[[quantity]]
kind = "energy"
)";

/// Mean displacement of the nodes at x = 3 layers [m].
double end_displacement(const StaticEnd& end) {
  const Mesh& mesh = end.solution.discretization.mesh;
  double sum = 0.0;
  int count = 0;
  for (int node = 0; node < mesh.node_count(); ++node)
    if (std::abs(mesh.nodes(0, node) - 3.0 * lattice_cell) < 1e-6) sum += end.solution.equilibrium.u(2, node), ++count;
  return sum / count;
}

AtlasPoint cut(double share) {
  std::vector<AtlasFile> files = {bar_surface(share)};
  return scene_point(
      share, bar_scene,
      [&] {
        const std::vector<AtlasFile> whole_files = {bar_surface(0.0)}, next_files = {bar_surface(1.0)};
        const double without = end_displacement(solve_scene(bar_scene, whole_files));
        const double with = end_displacement(solve_scene(bar_scene, next_files));
        const StaticEnd end = solve_scene(bar_scene, files);
        if (const std::string why = why_unsolved(end.solution.equilibrium); !why.empty()) return refusal(share, why);
        const Discretization& d = end.solution.discretization;
        const Eigen::Matrix3Xd loads = nodal_loads(end.forest.base(), d.mesh, {}, body_force(end.scene));
        const double weight = 10.0 * lattice_cell * (3.0 + share) * 4.0 * lattice_cell * lattice_cell;
        AtlasChecks checks;
        // Lattice cells below this share are left out (immersed_body.hpp).
        checks.add("relative error of the weight", std::abs(loads.row(2).sum() + weight) / weight, 1e-9);
        // The layer's weight, and the moment that it makes, bring the bar from one whole length to the next.
        const double way = (end_displacement(end) - without) / (with - without);
        checks.add("end displacement short of that without the layer, over what the layer adds", -way, 0.02);
        checks.add("end displacement more than in proportion to the share, over what the layer adds", way - share,
                   0.02);
        return checks.point(share);
      },
      files);
}

}  // namespace

std::vector<AtlasAxis> mesh_axes() {
  std::vector<AtlasAxis> axes;
  axes.push_back({.group = "mesh",
                  .name = "aspect_ratio",
                  .unit = "",
                  .about = "length over height of the cells of a pulled block, direct solver",
                  .truth = "uniaxial tension, exact on every mesh",
                  .normal = 1.0,
                  .values = {1.0, 10.0, 100.0, 1e3, 1e4},
                  .more_values = {1e-4, 1e-3, 1e-2, 0.1, 1e5, 1e6},
                  .at = [](double value) { return slender(value, "direct"); },
                  .safe = {1.0, 1e4},
                  .answered = {1.0, 1e4},
                  .reason = "none to 1e4, where the error is 3e-7; ten times that and the count of rigid motions takes "
                            "the block for one that is not held, and says so"});
  axes.push_back({.group = "mesh",
                  .name = "aspect_ratio_automatic",
                  .unit = "",
                  .about = "the same with the solver that scenes get: multigrid",
                  .truth = "uniaxial tension, exact on every mesh",
                  .normal = 1.0,
                  .values = {1.0, 3.0, 10.0, 30.0, 100.0, 1e3, 1e4},
                  .more_values = {1e-4, 1e-3, 1e-2, 0.1, 300.0, 3e3, 1e5, 1e6},
                  .at = [](double value) { return slender(value, "automatic"); },
                  .safe = {1.0, 1e4},
                  .answered = {1.0, 1e4},
                  .reason = "as for the direct solver"});
  axes.push_back(
      {.group = "mesh",
       .name = "refinement_depth",
       .unit = "levels",
       .about = "halvings of a cell beside seven that are not refined",
       .truth = "uniaxial tension, exact on every mesh",
       .normal = 1.0,
       .values = {0, 1, 2, 4, 6, 8, 10},
       .more_values = {12, 14, 16, 18, 19, 20, 25, 30, 31},
       .at = [](double value) { return deep(value, static_cast<int>(value), 0.3, "2x2x2", tight); },
       .safe = {0, 10},
       .answered = {0, 10},
       .reason =
           "ten levels are asked for; strains lose the digits by which the smallest cell is smaller than the body"});
  axes.push_back(
      {.group = "mesh",
       .name = "refinement_depth_thirds",
       .unit = "levels",
       .about = "the same with 3x3x3",
       .truth = "uniaxial tension, exact on every mesh",
       .normal = 1.0,
       .values = {0, 1, 2, 4, 6, 8, 10},
       .more_values = {11, 12, 14, 16, 18, 20, 21, 22},
       .at = [](double value) { return deep(value, static_cast<int>(value), 0.3, "3x3x3", tight); },
       .safe = {0, 10},
       .answered = {0, 10},
       .reason =
           "ten levels are asked for; strains lose the digits by which the smallest cell is smaller than the body"});
  axes.push_back({.group = "mesh",
                  .name = "depth_at_usual_residual",
                  .unit = "levels",
                  .about = "a pair: depth in thirds, and the relative residual of 1e-6 that a scene gets",
                  .truth = "uniaxial tension, exact on every mesh",
                  .normal = 1.0,
                  .values = {0, 1, 2, 3, 4, 6, 8, 10},
                  .more_values = {5, 7, 9},
                  .at = [](double value) { return deep(value, static_cast<int>(value), 0.3, "3x3x3", usual); },
                  .safe = {0, 10},
                  .answered = {0, 10},
                  .reason = "ten levels are asked for; the residual of nodes' forces does not see cells as small, but "
                            "the solve also asks that no cell's strain changes any more"});
  axes.push_back({.group = "mesh",
                  .name = "incompressibility_at_depth_8",
                  .unit = "1/2 - nu",
                  .about = "a pair: Poisson's ratio where a cell was halved eight times beside seven whole ones",
                  .truth = "uniaxial tension, exact on every mesh",
                  .normal = 0.2,
                  .values = {1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2, 0.2},
                  .more_values = {1e-14, 1e-13, 1e-11, 1e-9, 1e-7, 1e-5, 1e-3, 0.5},
                  .at = [](double value) { return deep(value, 8, 0.5 - value, "2x2x2", usual); },
                  .safe = {1e-12, 0.2},
                  .answered = {1e-10, 0.2},
                  .reason = "as without the depth: the round-off of the bulk part, and the solve says so"});
  axes.push_back(
      {.group = "mesh",
       .name = "cut_fraction",
       .unit = "",
       .about = "share of material in the last layer of a bar's cells, under its own weight",
       .truth = "the exact weight, and the whole lattices with and without that layer",
       .normal = 0.5,
       .values = {0.0, 1e-12, 1e-9, 2e-9, 1e-8, 1e-6, 1e-4, 1e-2, 0.5, 1.0},
       .more_values = {1e-16, 1e-15, 1e-14, 1e-13, 1e-11, 1e-10, 1e-7, 1e-5, 1e-3, 0.1, 0.9, 0.99, 0.999999},
       .at = cut,
       .safe = {0.0, 1.0},
       .answered = {0.0, 1.0},
       .reason = "none: below 1e-9 the layer is left out, and above a cell keeps a hundredth of its stiffness"});
  return axes;
}

}  // namespace finegauge
