#include "verification/studies/line_force.hpp"

#include <cmath>
#include <cstdio>
#include <numbers>
#include <stdexcept>

#include "core/needle/tissue_coupling.hpp"
#include "core/solve/direct_solver.hpp"
#include "core/space/assembly.hpp"

namespace finegauge {
namespace {

constexpr int base_cells = 8;  // per side; even, so that the line is a node line
constexpr double thickness = 0.25;

RefinementForest plate() {
  BoxMeshOptions options;
  options.origin = {-1.0, -1.0, 0.0};
  options.size = {2.0, 2.0, thickness};
  options.cells = {base_cells, base_cells, 1};
  return RefinementForest(box_mesh(options));
}

std::vector<SupportCondition> antiplane_supports() {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(), z = Eigen::Vector3d::UnitZ();
  std::vector<SupportCondition> supports;
  for (const char* side : {"z_min", "z_max"})
    for (const Eigen::Vector3d& direction : {x, y}) supports.push_back({side, direction, {}, {}});
  for (const char* side : {"x_min", "x_max", "y_min", "y_max"}) supports.push_back({side, z, {}, {}});
  return supports;
}

/// One halving across the line.
void refine_around_line(RefinementForest& forest, const LineForceOptions& options, double h) {
  const Mesh mesh = forest.leaf_mesh();
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    const double width = mesh.nodes(0, mesh.cells[cell][1]) - mesh.nodes(0, mesh.cells[cell][0]);
    const Eigen::Vector2d centre =
        0.5 * (mesh.nodes.col(mesh.cells[cell][0]) + mesh.nodes.col(mesh.cells[cell][7])).head<2>();
    if (width < 1.5 * h && std::abs(centre.norm() - options.radius) < options.zone * h)
      forest.refine(mesh.forest_cell[cell], {{2, 2, 1}});
  }
}

}  // namespace

std::vector<LineForceRow> line_force_table(const LineForceOptions& options) {
  RefinementForest forest = plate();
  const Material material{.youngs_modulus = 1.0e3, .poisson_ratio = 0.3};
  const auto supports = antiplane_supports();
  const auto middle = locate_at_rest(forest.base(), {0.0, 0.0, 0.5 * thickness});
  const auto beside = locate_at_rest(forest.base(), {0.5, 0.0, 0.5 * thickness});
  const SpreadPoint line =
      spread_over_ring(forest.base(), middle.value(), Eigen::Vector3d::UnitZ(), options.radius, options.ring_points);
  std::vector<LineForceRow> rows;
  double h = 2.0 / base_cells;
  for (int level = 0; level <= options.levels; ++level, h /= 2.0) {
    if (level > 0) refine_around_line(forest, options, 2.0 * h);
    const Discretization d = discretize(forest, material, supports);
    BlockMatrix<double> A = assemble_stiffness(d, Eigen::Matrix3Xd::Zero(3, d.mesh.node_count()));
    apply_supports(d.supports, A);
    // f = G: a force G × thickness along z.
    ReducedWeights weights;
    find_reduced_weights(forest, d.mesh, d.hanging, line, weights);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(d.dof_count());
    for (std::size_t k = 0; k < weights.node.size(); ++k)
      b[3 * weights.node[k] + 2] = material.mu() * thickness * weights.weight[k];
    project(d.supports, b);
    const DirectSolver solver(A);
    if (!solver.factored()) throw std::runtime_error("line force: the stiffness could not be factored");
    const Eigen::Matrix3Xd u = expand(d.hanging, solver.solve(b));
    LineForceRow row{h, d.mesh.cell_count(), d.hanging.hanging_count(), 0.0, 0.0, 0.0};
    row.displacement = spread_value(forest, d.mesh, u, line).z();
    row.rise = rows.empty() ? 0.0 : row.displacement - rows.back().displacement;
    row.at_distance = interpolate(d.mesh, u, find_leaf(forest, d.mesh, beside.value())).z();
    rows.push_back(row);
  }
  return rows;
}

double spread_line_displacement(double radius) {
  constexpr double half_lemniscate = 1.3110287771460599;  // ϖ / 2
  return std::log(std::numbers::sqrt2 / half_lemniscate / radius) / (2.0 * std::numbers::pi);
}

double line_displacement_at(double x) {
  double sum = 0.0;
  for (int n = 1; n < 200; n += 2) {
    const double k = 0.5 * std::numbers::pi * n;  // sinh k(1 - x) sinh k / sinh 2k, without overflow
    sum += -std::expm1(-2.0 * k * (1.0 - x)) * std::exp(-k * x) / (2.0 * (1.0 + std::exp(-2.0 * k))) / k;
  }
  return sum;
}

std::string to_string(const std::vector<LineForceRow>& rows) {
  std::string text = "h [m]        cells  hanging  G u/f at the force  rise       G u/f at 1/2 m\n";
  for (const LineForceRow& row : rows) {
    char line[160];
    std::snprintf(line, sizeof line, "%-11.5g %6d %8d  %-18.7f  %-9.7f  %.7f\n", row.h, row.cells, row.hanging_nodes,
                  row.displacement, row.rise, row.at_distance);
    text += line;
  }
  return text;
}

}  // namespace finegauge
