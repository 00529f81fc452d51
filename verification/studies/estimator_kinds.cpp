#include "verification/studies/estimator_kinds.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <stdexcept>

#include "core/adapt/apply_refinements.hpp"
#include "core/elasticity/polynomial_cell.hpp"
#include "core/static_step.hpp"
#include "core/tissue_frame.hpp"
#include "verification/studies/estimator_rungs.hpp"
#include "verification/studies/pollution.hpp"
#include "verification/support/cut_body.hpp"
#include "verification/support/field_errors.hpp"
#include "verification/support/scrambled_mesh.hpp"
#include "verification/support/solved_body.hpp"

namespace finegauge {

namespace {

using std::numbers::pi;

BoxMeshOptions box(const Eigen::Vector3d& size, std::array<int, 3> cells, CellShape shape = CellShape::hexahedron) {
  BoxMeshOptions options;
  options.size = size;
  options.cells = cells;
  options.shape = shape;
  return options;
}

std::vector<SupportCondition> held_all_around(const BaseMesh& base, const ManufacturedSolution& exact) {
  std::vector<SupportCondition> supports;
  for (const auto& [name, faces] : base.surfaces)
    supports.push_back({name, std::nullopt, [exact](const Eigen::Vector3d& X) { return displacement(exact, X); }});
  return supports;
}

KindRow row_of(ProblemKind kind, const std::string& rung, const Discretization& d, const Eigen::Matrix3Xd& u,
               double error) {
  const ErrorEstimate spr = estimate_error(d, u, Estimator::spr), edges = estimate_error(d, u, Estimator::spr_edges);
  return {
      kind, rung, d.mesh.cell_count(), d.dof_count(), error / spr.energy_norm, spr.total / error, edges.total / error};
}

StaticSolution solved(const RefinementForest& forest, StaticProblem problem) {
  problem.solver.linear.relative_residual = 1e-9;
  FactorCache factors;
  StaticSolution solution = solve_static(forest, problem, nullptr, factors);
  if (!solution.equilibrium.converged) throw std::runtime_error("estimator ladder: a solve did not converge");
  return solution;
}

/// Half space n · X <= offset, and a field without stress on its plane.
struct CutProblem {
  HalfSpace body;
  ManufacturedSolution exact;
};
const HalfSpace oblique{{1.0, 0.6, -0.35}, 0.55}, nearly_flat{{0.1, 0.05, 1.0}, 0.71};

/// Quadratic in the distance to the plane: without stress there, so the cut is free.
Jets fading(const HalfSpace& body, const Jets& x) {
  const Eigen::Vector3d& n = body.normal;
  const Jet s = n.x() * x[0] + n.y() * x[1] + n.z() * x[2] - body.offset, square = 0.1 * s * s;
  return {square * sin(2.0 * x[1] + x[2]), square * cos(2.0 * x[0] - x[2]), square * exp(0.5 * x[1])};
}

/// By 6³ boxes in every cell, each with its own share of material, at their centres.
double cut_error(const Discretization& d, const Eigen::Matrix3Xd& solution, const CutProblem& problem) {
  constexpr int m = 6;
  const Material& material = d.shapes.material();
  double squared = 0.0;
  CellGeometry scratch;
  for (int cell = 0; cell < d.mesh.cell_count(); ++cell) {
    const CellVectors X = corner_values(d.mesh, cell, d.mesh.nodes), u = corner_values(d.mesh, cell, solution);
    const Gradients mean = d.shapes.geometry(d.mesh, cell, scratch).mean_gradients;
    const Eigen::Vector3d size = X.col(7) - X.col(0);
    for (int k = 0; k < m * m * m; ++k) {
      const Eigen::Vector3d place = Eigen::Vector3i(k % m, k / m % m, k / (m * m)).cast<double>() / m;
      const Eigen::Vector3d low = X.col(0) + size.cwiseProduct(place), high = low + size / m;
      const double share = share_of_box(problem.body, low, high);
      if (share == 0.0) continue;
      const Gradients gradients = size.cwiseInverse().asDiagonal() *
                                  shape_gradients(CellShape::hexahedron, Eigen::Vector3d(place.array() + 0.5 / m));
      const Voigt off =
          discrete_stress(material, u, gradients, mean) - stress(problem.exact, material, 0.5 * (low + high));
      squared += share * size.prod() / (m * m * m) * complementary_product(material, off, off);
    }
  }
  return std::sqrt(squared);
}

KindRow cut_row(const std::string& rung, const CutProblem& problem, int n) {
  const RefinementForest forest(reached_part(problem.body, box_mesh(box(Eigen::Vector3d::Ones(), {n, n, n}))));
  Mesh mesh = forest.leaf_mesh();
  mesh.fraction = shares_in(problem.body, mesh);
  mesh.means = means_in(problem.body, mesh);
  StaticProblem statics;
  statics.supports = held_all_around(forest.base(), problem.exact);
  const ManufacturedSolution exact = problem.exact;
  statics.body = [exact](const Eigen::Vector3d& X) { return body_force(exact, Material{}, X); };
  statics.solver.method = LinearMethod::direct;
  Discretization d = discretize(forest, std::move(mesh), statics.material, statics.supports);
  FactorCache factors;
  const StaticSolution solution = solve_static(forest, std::move(d), statics, nullptr, factors);
  return row_of(ProblemKind::cut_cells, rung, solution.discretization, solution.equilibrium.u,
                cut_error(solution.discretization, solution.equilibrium.u, problem));
}

/// Stress of a cell with its own rotation at natural coordinates, in the global frame [Pa].
class CellStress {
 public:
  CellStress(const Discretization& d, const Eigen::Matrix3Xd& u, int cell)
      : material_(d.shapes.material()), X_(corner_values(d.mesh, cell, d.mesh.nodes)) {
    CellGeometry scratch;
    const CellGeometry& geometry = d.shapes.geometry(d.mesh, cell, scratch);
    const CellVectors x = X_ + corner_values(d.mesh, cell, u);
    R_ = cell_rotation(geometry, material_, x);
    local_ = R_.transpose() * x - X_;
    mean_ = geometry.mean_gradients;
  }
  Voigt operator()(const Eigen::Vector3d& xi) const {
    const Gradients dN = shape_gradients(CellShape::hexahedron, xi);
    const Eigen::Matrix3d J = X_ * dN.transpose();
    return rotate_stress(R_, discrete_stress(material_, local_, J.inverse().transpose() * dN, mean_));
  }

 private:
  Material material_;
  CellVectors X_, local_;
  Eigen::Matrix3d R_;
  Gradients mean_;
};

/// Energy norm [√J] of the distance of the stresses of two solutions on meshes of one forest, each cell of the second
/// part of one of the first.
double nested_distance(const Discretization& coarse, const Eigen::Matrix3Xd& u_coarse, const Discretization& fine,
                       const Eigen::Matrix3Xd& u_fine) {
  const Material& material = fine.shapes.material();
  std::vector<std::vector<int>> leaves_of;
  for (int cell = 0; cell < coarse.mesh.cell_count(); ++cell) {
    const auto base = static_cast<std::size_t>(coarse.mesh.frames[cell].base_cell);
    if (leaves_of.size() <= base) leaves_of.resize(base + 1);
    leaves_of[base].push_back(cell);
  }
  double squared = 0.0;
  CellGeometry scratch;
  for (int cell = 0; cell < fine.mesh.cell_count(); ++cell) {
    const LeafFrame& frame = fine.mesh.frames[cell];
    const auto holds = [&](int leaf) {
      const auto &low = coarse.mesh.frames[leaf].corners[0], &size = coarse.mesh.frames[leaf].corners[1];
      for (int i = 0; i < 3; ++i)
        if (frame.corners[0][i] < low[i] || frame.corners[0][i] >= low[i] + size[i]) return false;
      return true;
    };
    const int around = *std::ranges::find_if(leaves_of[static_cast<std::size_t>(frame.base_cell)], holds);
    const LeafFrame& of_coarse = coarse.mesh.frames[around];
    const CellStress ours(fine, u_fine, cell), theirs(coarse, u_coarse, around);
    const CellGeometry& geometry = fine.shapes.geometry(fine.mesh, cell, scratch);
    for (int q = 0; q < 8; ++q) {
      const Eigen::Vector3d xi = quadrature_point(CellShape::hexahedron, q);
      Eigen::Vector3d of_theirs;
      for (int i = 0; i < 3; ++i)
        of_theirs[i] = (static_cast<double>(frame.corners[0][i] - of_coarse.corners[0][i]) +
                        xi[i] * static_cast<double>(frame.corners[1][i])) /
                       static_cast<double>(of_coarse.corners[1][i]);
      const Voigt off = ours(xi) - theirs(of_theirs);
      squared += geometry.weights[q] * complementary_product(material, off, off);
    }
  }
  return std::sqrt(squared);
}

KindRow nested_row(ProblemKind kind, const std::string& rung, const Discretization& d, const Eigen::Matrix3Xd& u,
                   const Discretization& reference, const Eigen::Matrix3Xd& u_reference) {
  const double rest = estimate_error(reference, u_reference, Estimator::spr_edges).total;
  return row_of(kind, rung, d, u, std::hypot(nested_distance(d, u, reference, u_reference), rest));
}

Material gel(Kinematics kinematics) {
  Material material;
  material.youngs_modulus = 2e5;
  material.poisson_ratio = 0.4;
  material.dilatation = Dilatation::mean;
  material.kinematics = kinematics;
  return material;
}

KindRow rotated_row(const std::string& rung, const BoxMeshOptions& options, const StaticProblem& problem) {
  RefinementForest forest(box_mesh(options));
  const StaticSolution coarse = solved(forest, problem);
  for (int k = 0; k < 2; ++k) refine_uniformly(forest);
  const StaticSolution fine = solved(forest, problem);
  return nested_row(ProblemKind::rotated, rung, coarse.discretization, coarse.equilibrium.u, fine.discretization,
                    fine.equilibrium.u);
}

}  // namespace

std::optional<EffectivityRange> effectivity_range(ProblemKind kind) {
  switch (kind) {
    case ProblemKind::hexahedra:
    case ProblemKind::tetrahedra:
    case ProblemKind::cut_cells:
    case ProblemKind::rotated:
      return EffectivityRange{0.95, 1.15};
    case ProblemKind::moving:
      return EffectivityRange{0.9, 1.15};
    case ProblemKind::line_force:
      break;
  }
  return {};
}

std::string rungs_of(ProblemKind kind) {
  switch (kind) {
    case ProblemKind::hexahedra:
      return "smooth fields, notches, cracks and clamped rims, regular, perturbed, flat and hanging cells, nu to "
             "0.4999";
    case ProblemKind::tetrahedra:
      return "smooth fields, notches, cracks, clamped rims, the L-shape and bent blocks in tetrahedra, nu to 0.4";
    case ProblemKind::cut_cells:
      return "smooth fields in a cube that a plane cuts";
    case ProblemKind::rotated:
      return "bars that are bent and twisted by tens of degrees";
    case ProblemKind::moving:
      return "a bar that falls and swings, on a mesh that stays and on one that follows";
    case ProblemKind::line_force:
      break;
  }
  return "";
}

std::vector<KindRow> tetrahedra_rows() {
  std::vector<KindRow> rows;
  for (LadderRung& rung : tetrahedra_rungs()) {
    const StaticSolution solution = solve(rung);
    const Discretization& d = solution.discretization;
    const ErrorEstimate spr = estimate_error(d, solution.equilibrium.u, Estimator::spr);
    rows.push_back(row_of(ProblemKind::tetrahedra, rung.name, d, solution.equilibrium.u,
                          true_error_of(rung, solution, spr).total));
  }
  return rows;
}

std::vector<KindRow> cut_rows() {
  const CutProblem across{oblique, {"fades out at an oblique plane", [](const Jets& x) { return fading(oblique, x); }}};
  const CutProblem along{nearly_flat,
                         {"fades out at a flat plane", [](const Jets& x) { return fading(nearly_flat, x); }}};
  return {cut_row("oblique plane, n = 6", across, 6), cut_row("oblique plane, n = 10", across, 10),
          cut_row("nearly flat plane, n = 7", along, 7), cut_row("nearly flat plane, n = 10", along, 10)};
}

std::vector<KindRow> rotated_rows() {
  StaticProblem bent;
  bent.material = gel(Kinematics::corotational);
  bent.supports = {{"x_min", std::nullopt, {}}};
  bent.loads = {{"x_max", LoadKind::total_by_area, {0.0, 0.0, -0.4}}};
  StaticProblem twisted;
  twisted.material = gel(Kinematics::corotational);
  const Eigen::Vector3d axis(0.0, 0.01, 0.01);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(pi / 3.0, Eigen::Vector3d::UnitX()).toRotationMatrix();
  twisted.supports = {{"x_min", std::nullopt, {}},
                      {"x_max", std::nullopt, [=](const Eigen::Vector3d& X) -> Eigen::Vector3d {
                         return (turn - Eigen::Matrix3d::Identity()) * (X - axis);
                       }}};
  return {rotated_row("bar bent", box({0.08, 0.02, 0.02}, {8, 2, 2}), bent),
          rotated_row("bar bent, fine", box({0.08, 0.02, 0.02}, {12, 4, 4}), bent),
          rotated_row("bar twisted by 60 degrees", box({0.04, 0.02, 0.02}, {8, 4, 4}), twisted)};
}

std::vector<KindRow> moving_rows() {
  MotionProblem problem;
  problem.tissue.material = gel(Kinematics::corotational);
  problem.tissue.gravity = {0.0, 0.0, -9.81};
  problem.tissue.stiffness_damping = 1e-3;
  problem.tissue.supports = {{"x_min", std::nullopt, {}}};
  problem.time_step = 5e-3;
  problem.estimate_error = false;
  MotionProblem following = problem;
  following.estimate_error = true;
  following.estimator = Estimator::spr_edges;
  following.adapt = FrameAdaptRules{.refine_above = 0.5, .dwell = 3, .max_depth = 1};
  RefinementForest forest(box_mesh(box({0.08, 0.02, 0.02}, {8, 2, 2})));
  Tissue fixed = start_tissue(forest, problem), adapted = start_tissue(forest, following);
  for (int k = 0; k < 2; ++k) refine_uniformly(forest);
  Tissue fine = start_tissue(std::move(forest), problem);
  EnergyLedger fixed_energy, adapted_energy, fine_energy;
  std::vector<KindRow> rows;
  int sampled = 0;
  for (int frame = 1; frame <= 16; ++frame) {
    const FrameReport of_adapted = advance_frame(following, adapted, adapted_energy);
    const bool converged = of_adapted.converged && advance_frame(problem, fixed, fixed_energy).converged &&
                           advance_frame(problem, fine, fine_energy).converged;
    if (!converged) throw std::runtime_error("estimator ladder: a frame did not converge");
    const std::string text = ", frame " + std::to_string(frame);
    if (frame % 6 == 3)
      rows.push_back(
          nested_row(ProblemKind::moving, "bar swings" + text, fixed.mesh.d, fixed.state.u, fine.mesh.d, fine.state.u));
    // The state of a frame that ends in a change of the mesh is on the next mesh already.
    const bool same_mesh = of_adapted.refined + of_adapted.coarsened == 0;
    if (frame < 4 * (sampled + 1) || !same_mesh || of_adapted.hanging_nodes == 0) continue;
    ++sampled;
    rows.push_back(nested_row(ProblemKind::moving, "the same, adaptive" + text, adapted.mesh.d, adapted.state.u,
                              fine.mesh.d, fine.state.u));
  }
  return rows;
}

LineForceErrors line_force_errors(int halvings) {
  // u_z = 0 on the sides of the square [-1, 1]² and u_x = u_y = 0 throughout: -G Δu = f δ.
  const double thickness = 0.5, force = 1.0;
  BoxMeshOptions options = box({2.0, 2.0, thickness}, {8, 8, 2});
  options.origin = {-1.0, -1.0, 0.0};
  RefinementForest forest(box_mesh(options));
  const Material material;
  std::vector<SupportCondition> supports;
  for (const char* side : {"x_min", "x_max", "y_min", "y_max"}) supports.push_back({side, std::nullopt, {}});
  for (const char* side : {"z_min", "z_max"})
    for (int axis = 0; axis < 2; ++axis) supports.push_back({side, Eigen::Vector3d(Eigen::Vector3d::Unit(axis)), {}});
  const auto on_line = [](const Eigen::Vector3d& X) { return X.head<2>().norm() < 1e-12; };
  const NodalLoads loads = [&](const BaseMesh&, const Mesh& mesh) {
    Eigen::Matrix3Xd f = Eigen::Matrix3Xd::Zero(3, mesh.node_count());
    for (int node = 0; node < mesh.node_count(); ++node) {
      if (!on_line(mesh.nodes.col(node))) continue;
      const double z = mesh.nodes(2, node);
      const bool end = z < 1e-12 || z > thickness - 1e-12;
      f(2, node) = force * thickness / 2.0 * (end ? 0.5 : 1.0);  // two cells through the thickness, at every level
    }
    return f;
  };
  LineForceErrors result;
  double energy = 0.0, first = 0.0, eta = 0.0;
  for (int level = 0; level <= halvings; ++level) {
    const SolvedBody body = solve_body(forest, material, supports, loads);
    const double now = loads(forest.base(), body.d.mesh).cwiseProduct(body.u).sum();
    if (level == 0) {
      first = now;
      eta = estimate_error(body.d, body.u, Estimator::spr_edges).total;
    } else {
      result.effectivity.push_back(eta / std::sqrt(now - first));
      result.rise.push_back((now - energy) * 2.0 * pi * material.mu() /
                            (force * force * thickness * std::numbers::ln2));
    }
    energy = now;
    const double size = 0.25 * std::pow(0.5, level);
    for (int cell = 0; cell < body.d.mesh.cell_count(); ++cell) {
      const Eigen::Vector3d centre = corner_values(body.d.mesh, cell, body.d.mesh.nodes).rowwise().mean();
      if (centre.head<2>().norm() < 4.0 * size) forest.refine(body.d.mesh.forest_cell[cell], {{2, 2, 1}});
    }
  }
  return result;
}

void add_kinds(const EvidenceOptions& options, Evidence& evidence) {
  struct Kind {
    const char* name;
    std::vector<KindRow> (*rows)();
  };
  EvidenceTable table{"Effectivity beyond linear strains in full hexahedra",
                      {"kind", "rung", "cells", "error over |u_h|", "spr", "spr_edges"},
                      {}};
  for (const Kind& kind : {Kind{"tetrahedra", &tetrahedra_rows}, Kind{"cut", &cut_rows}, Kind{"rotated", &rotated_rows},
                           Kind{"moving", &moving_rows}}) {
    if (options.interrupted()) return;
    options.progress(0.9, kind.name);
    for (const KindRow& row : kind.rows()) {
      table.rows.push_back(
          {std::string(kind.name), row.rung, static_cast<double>(row.cells), row.true_error, row.spr, row.spr_edges});
      const EffectivityRange range = *effectivity_range(row.kind);
      std::string key = row.rung;
      std::ranges::replace(key, ' ', '_');
      std::erase(key, ',');
      evidence.claim(std::string(kind.name) + "." + key, row.spr_edges, range.low, range.high,
                     "what scenes of this kind print as the range of their error rests on it");
    }
  }
  const SquaresShown far = squares_shown_far_from_tip();
  EvidenceTable of_pollution{
      "A crack in tetrahedra: squares of the error that spr shows far from the tip, over the true ones",
      {"nodal values", "shown"},
      {{std::string("exact"), far.of_interpolant}, {std::string("computed"), far.of_solution}}};
  const LineForceErrors line = line_force_errors(5);
  EvidenceTable of_line{"A force on a line: the error of one mesh by the reference's halvings of its cells",
                        {"halvings", "effectivity", "energy's rise over theory's"},
                        {}};
  for (std::size_t k = 0; k < line.rise.size(); ++k)
    of_line.rows.push_back({static_cast<double>(k + 1), line.effectivity[k], line.rise[k]});
  evidence.tables.push_back(table);
  evidence.tables.push_back(of_pollution);
  evidence.tables.push_back(of_line);
  evidence.claim("pollution.interpolant", far.of_interpolant, 0.95, 1.08, "the recovery finds the error that is local");
  evidence.claim("pollution.solution", far.of_solution, 0.55, 0.7,
                 "and not what the tip takes from the whole field, at λ = 1/2 a constant share of it");
  evidence.claim("line_force.rise", line.rise.back(), 0.98, 1.02,
                 "f² L ln 2 / (2 pi G) with every halving, without end: there is no true error to be certain of");
  evidence.claim("line_force.effectivity", line.effectivity.back(), 0.0, 0.7, "falls as the reference gets finer");
}

}  // namespace finegauge
