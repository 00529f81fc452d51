#include "verification/studies/plane_problems.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "core/adapt/stress_recovery.hpp"
#include "core/elasticity/cell_response.hpp"
#include "core/space/loads.hpp"
#include "verification/studies/published_problems.hpp"
#include "verification/support/convergence.hpp"
#include "verification/support/extrapolation.hpp"
#include "verification/support/mapped_mesh.hpp"
#include "verification/support/solved_body.hpp"
#include "verification/support/traction_field.hpp"

namespace finegauge {
namespace {

using std::numbers::pi;

/// [0, 1] onto itself, lines gathered at both ends: spacing grows with the root of the distance from the end.
double gathered_at_ends(double s) { return s * s * (3.0 - 2.0 * s); }

constexpr double cook_half_thickness = 0.05;  // thin beside the smallest cells' 0.5

constexpr double membrane_half_thickness = 0.005;  // [m]

constexpr double kirsch_outer = 4.0, kirsch_height = 0.25;  // [m]

/// Displacement of the infinite plate [m] under unit tension, hole of radius 1 m, plane strain (κ = 3 - 4 nu).
Eigen::Vector3d kirsch_displacement(const Material& material, const Eigen::Vector3d& X) {
  const double r = std::hypot(X.x(), X.y()), angle = std::atan2(X.y(), X.x());
  const double kappa = 3.0 - 4.0 * material.poisson_ratio, scale = 1.0 / (8.0 * material.mu());
  const double c = std::cos(angle), s = std::sin(angle), c3 = std::cos(3.0 * angle), s3 = std::sin(3.0 * angle);
  const double cubed = 2.0 / (r * r * r);
  return {scale * (r * (kappa + 1.0) * c + 2.0 / r * ((1.0 + kappa) * c + c3) - cubed * c3),
          scale * (r * (kappa - 3.0) * s + 2.0 / r * ((1.0 - kappa) * s + s3) - cubed * s3), 0.0};
}

// --- evidence ---

/// Bricks of order four on meshes gathered still more at the edges, by another program: the last differences are 1e-4
/// in the middle and 4e-4 in the corner. Sixty-four by sixty-four biquadratic cells on a plain mesh give 23.965 and
/// 25.164, which still rise: the customary 23.96 is the middle's, not the corner's.
constexpr double cook_middle = 23.9677, cook_corner = 25.189;
/// NAFEMS prints 92.7 MPa; bricks of order four in a plate 0.01 m thick, by another program, 92.660 MPa. Of a plate of
/// the benchmark's own 0.1 m they make 92.82 MPa in the middle and 92.40 MPa on the faces.
constexpr double membrane_stress = 92.66e6;

void add_cook(Evidence& evidence, const EvidenceOptions& options) {
  EvidenceTable table{"Cook's membrane, plane stress: u_y at two points; high-order bricks 23.9677 and 25.189",
                      {"dilatation", "n", "dofs", "(48, 52)", "(48, 60)", "rms σ_zz / σ_xx"},
                      {}};
  for (const Dilatation dilatation : dilatations) {
    std::vector<CookRow> rows;
    for (const int n : {16, 32, 64}) {
      rows.push_back(solve_cook(options.full ? 2 * n : n, dilatation));
      const CookRow& row = rows.back();
      table.rows.push_back({name_of(dilatation), static_cast<double>(row.n), static_cast<double>(row.dofs), row.middle,
                            row.corner, row.thickness_stress});
    }
    const Extrapolation middle = extrapolate(rows[0].middle, rows[1].middle, rows[2].middle),
                        corner = extrapolate(rows[0].corner, rows[1].corner, rows[2].corner);
    table.rows.push_back({name_of(dilatation), "order", "", middle.order, corner.order, ""});
    table.rows.push_back({name_of(dilatation), "limit", "", middle.limit, corner.limit, ""});
    const std::string name = "cook_" + name_of(dilatation);
    evidence.claim(name + "_middle", middle.limit, cook_middle * (1.0 - 3e-4), cook_middle * (1.0 + 3e-4),
                   "23.9677 by bricks of order four; 3e-4 for the extrapolation, a tenth of the last grid's error");
    evidence.claim(name + "_corner", corner.limit, cook_corner * (1.0 - 5e-4), cook_corner * (1.0 + 5e-4),
                   "25.189 by bricks of order four; 5e-4 for the extrapolation, a sixth of the last grid's error");
    evidence.claim(name + "_order_middle", middle.order, 1.87, 2.05,
                   "order 2, since lines gather at the singular corners; on even meshes 1.85");
    evidence.claim(
        name + "_order_corner", corner.order, 1.7, 2.1,
        "order 2 but for a logarithm: shear meets a free edge at the corner that is read; on even meshes 1.4");
    evidence.claim(name + "_plane_stress", rows.back().thickness_stress, 0.0, 0.05,
                   "σ_zz vanishes but in the cells at the singular corners");
  }
  evidence.tables.push_back(std::move(table));
}

void add_membrane(Evidence& evidence, const EvidenceOptions& options) {
  EvidenceTable table{
      "NAFEMS LE1, elliptic membrane: stress at D [MPa], target 92.7; HEX8 of OptiStruct 63.15 and 79.8",
      {"dilatation", "n", "dofs", "σ_yy", "σ_zz", "σ_yy by strains in the plane"},
      {}};
  std::vector<int> grids = {8, 16, 32};
  if (options.full) grids.push_back(64);
  for (const Dilatation dilatation : dilatations) {
    MembraneRow row;
    ErrorSeries thickness{"σ_zz", {}, {}};
    for (const int n : grids) {
      row = solve_elliptic_membrane(n, dilatation);
      table.rows.push_back({name_of(dilatation), static_cast<double>(n), static_cast<double>(row.dofs),
                            1e-6 * row.stress, 1e-6 * row.thickness_stress, 1e-6 * row.plane_stress});
      thickness.h.push_back(1.0 / n);
      thickness.error.push_back(std::abs(row.thickness_stress));
    }
    const std::string name = "elliptic_membrane_" + name_of(dilatation);
    evidence.claim(name, row.stress, 0.996 * membrane_stress, 1.004 * membrane_stress,
                   "92.66 MPa by bricks of order four, 92.7 MPa as NAFEMS prints it; 0.4 % is 3/7 of the σ_zz that a "
                   "free edge of 32 cells leaves, 0.6 %, and its own error");
    evidence.claim(name + "_plane", row.plane_stress, 0.9985 * membrane_stress, 1.0015 * membrane_stress,
                   "the same without σ_zz: order 2 remains, 1.6 % on the first grid, an eighth of that on the second");
    evidence.claim(name + "_thickness_order", last_order(thickness), 0.8, 1.2,
                   "order 1 at a free edge: the strain across follows a mean over one side");
  }
  evidence.tables.push_back(std::move(table));
}

void add_kirsch(Evidence& evidence, const EvidenceOptions& options) {
  EvidenceTable table{"Kirsch: displacement's relative error, hoop stress at the hole over the far tension",
                      {"dilatation", "n", "dofs", "displacement", "at 90° (3)", "at 0° (-1)"},
                      {}};
  std::vector<int> grids = {8, 16, 32};
  if (options.full) grids.push_back(64);
  for (const Dilatation dilatation : dilatations) {
    ErrorSeries displacement{"displacement", {}, {}}, top{"top", {}, {}}, side{"side", {}, {}};
    for (const int n : grids) {
      const KirschRow row = solve_kirsch(n, dilatation);
      table.rows.push_back({name_of(dilatation), static_cast<double>(n), static_cast<double>(row.dofs),
                            row.displacement_error, row.top_stress, row.side_stress});
      for (const auto& [series, error] : {std::pair{&displacement, row.displacement_error},
                                          {&top, std::abs(row.top_stress - 3.0)},
                                          {&side, std::abs(row.side_stress + 1.0)}}) {
        series->h.push_back(1.0 / n);
        series->error.push_back(error);
      }
    }
    const std::string name = "kirsch_" + name_of(dilatation);
    evidence.claim(name + "_displacement_order", last_order(displacement), 1.9, 2.1,
                   "order 2 on a smooth mesh of a smooth solution");
    evidence.claim(name + "_displacement", displacement.error.back(), 1e-4 * 1024.0 / (grids.back() * grids.back()),
                   1e-3 * 1024.0 / (grids.back() * grids.back()),
                   "the chord of an arc is (π / 4 n)² / 2 = 3e-4 off the hole at n = 32");
    for (const ErrorSeries* series : {&top, &side}) {
      evidence.claim(name + "_" + series->quantity + "_stress", series->error.back(), 0.0,
                     6e-3 * 1024.0 / (grids.back() * grids.back()),
                     "of the far tension; Kirsch's 3 and -1, order 2 and a constant of 6");
      evidence.claim(name + "_" + series->quantity + "_stress_order", fitted_order(*series), 1.8, 2.4,
                     "recovered stress of order 2, extrapolated over one cell to the hole");
    }
  }
  evidence.tables.push_back(std::move(table));
}

}  // namespace

CookRow solve_cook(int n, Dilatation dilatation) {
  const RefinementForest forest(mapped_box({n, n, 1}, [](const Eigen::Vector3d& X) {
    const double s = gathered_at_ends(X.x()), t = gathered_at_ends(X.y());
    return Eigen::Vector3d(48.0 * s, (1.0 - t) * 44.0 * s + t * (44.0 + 16.0 * s), cook_half_thickness * X.z());
  }));
  const Material material{.youngs_modulus = 1.0, .poisson_ratio = 1.0 / 3.0, .dilatation = dilatation};
  const std::vector<SupportCondition> supports = {
      {"x_min", x_axis, {}, {}}, {"x_min", y_axis, {}, {}}, {"z_min", z_axis, {}, {}}};
  const SolvedBody body = solve_body(forest, material, supports, [](const BaseMesh& base, const Mesh& mesh) {
    return nodal_loads(base, mesh, {{"x_max", LoadKind::total_by_area, cook_half_thickness * y_axis}});
  });
  const Eigen::Matrix<double, 6, Eigen::Dynamic> centre = cell_stresses(body.d, body.u).centre;
  return {n, body.d.dof_count(), body.u(1, node_at(body.d.mesh.nodes, {48.0, 52.0, 0.0})),
          body.u(1, node_at(body.d.mesh.nodes, {48.0, 60.0, 0.0})), centre.row(2).norm() / centre.row(0).norm()};
}

MembraneRow solve_elliptic_membrane(int n, Dilatation dilatation) {
  const RefinementForest forest(mapped_box({n, 2 * n, 2}, [](const Eigen::Vector3d& X) {
    const double s = 0.5 * (X.x() + X.x() * X.x()), angle = 0.5 * pi * X.y();  // finer towards the inner edge
    return Eigen::Vector3d((2.0 + 1.25 * s) * std::cos(angle), (1.0 + 1.75 * s) * std::sin(angle),
                           membrane_half_thickness * X.z());
  }));
  const Material material{.youngs_modulus = 210e9, .poisson_ratio = 0.3, .dilatation = dilatation};
  const std::vector<SupportCondition> supports = {
      {"y_min", y_axis, {}, {}}, {"y_max", x_axis, {}, {}}, {"z_min", z_axis, {}, {}}};
  const SolvedBody body = solve_body(forest, material, supports, [](const BaseMesh& base, const Mesh& mesh) {
    return traction_forces(base, mesh, "x_max", [](const Eigen::Vector3d&, const Eigen::Vector3d& normal) {
      return Eigen::Vector3d(10e6 * normal);
    });
  });
  const Voigt at_D = body.nodal_stress.col(node_at(body.d.mesh.nodes, {2.0, 0.0, 0.0}));
  const double nu = material.poisson_ratio;
  return {n, body.d.dof_count(), at_D[1], at_D[2], at_D[1] - nu / (1.0 - nu) * at_D[2]};
}

KirschRow solve_kirsch(int n, Dilatation dilatation) {
  const RefinementForest forest(mapped_box({n, n, 2}, [](const Eigen::Vector3d& X) {
    const double r = std::pow(kirsch_outer, X.x()), angle = 0.5 * pi * X.y();
    return Eigen::Vector3d(r * std::cos(angle), r * std::sin(angle), kirsch_height * X.z());
  }));
  const Material material{.youngs_modulus = 1e3, .poisson_ratio = 0.3, .dilatation = dilatation};
  const auto exact = [&](const Eigen::Vector3d& X) { return kirsch_displacement(material, X); };
  const std::vector<SupportCondition> supports = {{"x_max", {}, exact, {}},
                                                  {"y_min", y_axis, {}, {}},
                                                  {"y_max", x_axis, {}, {}},
                                                  {"z_min", z_axis, {}, {}},
                                                  {"z_max", z_axis, {}, {}}};
  const SolvedBody body = solve_body(forest, material, supports, {});
  const Mesh& mesh = body.d.mesh;
  double squared_error = 0.0, squared = 0.0;
  for (int node = 0; node < mesh.node_count(); ++node) {
    const Eigen::Vector3d u = exact(mesh.nodes.col(node));
    squared_error += (body.u.col(node) - u).squaredNorm();
    squared += u.squaredNorm();
  }
  return {n, body.d.dof_count(), std::sqrt(squared_error / squared),
          body.nodal_stress(0, node_at(mesh.nodes, {0.0, 1.0, 0.5 * kirsch_height})),
          body.nodal_stress(1, node_at(mesh.nodes, {1.0, 0.0, 0.5 * kirsch_height}))};
}

Evidence plane_problems_evidence(const EvidenceOptions& options) {
  Evidence evidence;
  const std::array<std::pair<const char*, void (*)(Evidence&, const EvidenceOptions&)>, 3> problems = {
      {{"Cook's membrane", add_cook}, {"LE1", add_membrane}, {"Kirsch", add_kirsch}}};
  for (std::size_t i = 0; i < problems.size(); ++i) {
    if (options.interrupted()) break;
    options.progress(static_cast<double>(i) / problems.size(), problems[i].first);
    problems[i].second(evidence, options);
  }
  return evidence;
}

}  // namespace finegauge
