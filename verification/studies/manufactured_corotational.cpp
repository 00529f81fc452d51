#include "verification/studies/manufactured_corotational.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>
#include <utility>

#include "core/elasticity/cell_response.hpp"
#include "core/elasticity/rotation.hpp"
#include "core/equilibrium.hpp"
#include "verification/support/sample_cells.hpp"
#include "verification/support/scrambled_mesh.hpp"
#include "verification/support/slope_matrix.hpp"

namespace finegauge {

namespace {

using std::numbers::pi;

/// R of F = R U by Newton's iteration (Higham 1986), values and gradients at once: both converge quadratically. Strains
/// here are below one half, from which six steps reach round-off; two more are for the gradients, which lag.
SlopeMatrix rotation_of(const SlopeMatrix& F) {
  SlopeMatrix R = F;
  const Slope half{0.5};
  for (int step = 0; step < 8; ++step) R = half * (R + inverse_transposed(R));
  return R;
}

SlopeMatrix deformation_gradient(const Motion& motion, const Eigen::Vector3d& X) {
  const Jets x = motion.positions(coordinates_at(X));
  return filled([&](int i, int j) { return Slope{x[i].gradient[j], x[i].hessian.row(j).transpose()}; });
}

SlopeMatrix piola(const SlopeMatrix& F, HyperelasticLaw law, const Material& material) {
  const Slope lambda{material.lambda()}, two_mu{2.0 * material.mu()}, half{0.5};
  if (law == HyperelasticLaw::saint_venant_kirchhoff) {
    const SlopeMatrix E = half * (transposed(F) * F - identity());
    return F * (lambda * trace(E) * identity() + two_mu * E);
  }
  const SlopeMatrix R = rotation_of(F);
  return two_mu * (F - R) + lambda * trace(transposed(R) * F - identity()) * R;
}

std::vector<SupportCondition> held(const Motion& motion, const std::vector<const char*>& surfaces) {
  std::vector<SupportCondition> supports;
  for (const char* surface : surfaces)
    supports.push_back({surface,
                        std::nullopt,
                        [u = motion.displacement()](const Eigen::Vector3d& X) -> Eigen::Vector3d {
                          const Jets value = u(coordinates_at(X));
                          return {value[0].value, value[1].value, value[2].value};
                        },
                        {}});
  return supports;
}
const std::vector<const char*> all_around = {"x_min", "x_max", "y_min", "y_max", "z_min", "z_max"};

/// A bar of length 1 with `across` cells through its thickness, as in bar_motion. `refined`: the cells of a quarter of
/// the length are.
RefinementForest bar(double thickness, int across, CellShape shape, const std::vector<RefinementTemplate>& refined) {
  BoxMeshOptions options;
  options.origin = {0.0, -0.5 * thickness, -0.5 * thickness};
  options.size = {1.0, thickness, thickness};
  options.cells = {static_cast<int>(std::lround(across / thickness)), across, across};
  options.shape = shape;
  RefinementForest forest(box_mesh(options));
  if (refined.empty()) return forest;
  const Mesh mesh = forest.leaf_mesh();
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    const double x = corner_values(mesh, cell, mesh.nodes).row(0).sum() / corner_count(shape);
    if (x > 0.25 && x < 0.5) forest.refine(mesh.forest_cell[cell], refined[cell % refined.size()]);
  }
  return forest;
}

Material corotational(double nu = 0.3, Dilatation dilatation = Dilatation::standard) {
  Material material;
  material.poisson_ratio = nu;
  material.dilatation = dilatation;
  material.kinematics = Kinematics::corotational;
  return material;
}

/// Internal forces at u with the rotations that belong to `at`.
Eigen::Matrix3Xd forces_with_rotations_of(const Discretization& d, const Eigen::Matrix3Xd& at,
                                          const Eigen::Matrix3Xd& u) {
  Eigen::Matrix3Xd forces = Eigen::Matrix3Xd::Zero(3, d.mesh.node_count());
  RestShapes::Entry scratch;
  for (int cell = 0; cell < d.mesh.cell_count(); ++cell) {
    const RestShapes::CellView entry = d.shapes.entry(d.mesh, cell, scratch);
    const CellVectors X = corner_values(d.mesh, cell, d.mesh.nodes);
    const CellVectors x_at = X + corner_values(d.mesh, cell, at), x = X + corner_values(d.mesh, cell, u);
    const Eigen::Matrix3d R = cell_rotation(entry.geometry, d.shapes.material(), x_at);
    const CellVectors f = cell_force(entry.stiffness, R, X, x);
    for (int c = 0; c < corner_count(d.mesh.shape); ++c) forces.col(d.mesh.cells[cell][c]) += f.col(c);
  }
  return forces;
}

/// A conforming field of random directions.
Eigen::Matrix3Xd random_direction(const Discretization& d) {
  std::mt19937 generator(11);
  Eigen::VectorXd reduced(d.dof_count());
  for (double& value : reduced) value = random_number(generator);
  return expand(d.hanging, reduced);
}

struct TangentErrors {
  double frozen = 0.0, free = 0.0;
};
/// Central differences over a step of `step` against K, relative, reduced.
TangentErrors tangent_errors(const Discretization& d, const Eigen::Matrix3Xd& u, double step) {
  const Eigen::Matrix3Xd direction = random_direction(d);
  Eigen::VectorXd tangent;
  multiply(assemble_stiffness(d, u), gather(d.hanging, direction), tangent);
  const auto error = [&](const Eigen::Matrix3Xd& ahead, const Eigen::Matrix3Xd& behind) {
    const Eigen::VectorXd slope = reduce_forces(d.hanging, Eigen::Matrix3Xd((ahead - behind) / (2.0 * step)));
    return (slope - tangent).norm() / tangent.norm();
  };
  const Eigen::Matrix3Xd ahead = u + step * direction, behind = u - step * direction;
  return {error(forces_with_rotations_of(d, u, ahead), forces_with_rotations_of(d, u, behind)),
          error(internal_forces(d, ahead), internal_forces(d, behind))};
}

Equilibrium solve(const RefinementForest& forest, const Discretization& d,
                  const std::vector<SupportCondition>& supports, const Eigen::Matrix3Xd& loads,
                  const Eigen::Matrix3Xd& start, double residual) {
  EquilibriumOptions options;
  options.method = LinearMethod::direct;
  options.linear.relative_residual = 1e-8;  // a step's error enters the next step, not the result
  options.newton_residual = residual;
  options.newton_iterations = 200;
  const MeshHierarchy hierarchy = build_hierarchy(forest, d, supports);
  return solve_equilibrium(d, hierarchy, loads, start, options);
}

RecoveredRow recover(const std::string& name, const RefinementForest& forest, const Motion& motion,
                     const std::vector<const char*>& surfaces) {
  const std::vector<SupportCondition> supports = held(motion, surfaces);
  const Discretization d = discretize(forest, corotational(), supports);
  const Eigen::Matrix3Xd u = interpolant(d, motion.displacement());
  RecoveredRow row;
  row.name = name;
  row.dofs = d.dof_count();
  row.hanging_nodes = d.hanging.hanging_count();
  CellGeometry scratch;
  for (int cell = 0; cell < d.mesh.cell_count(); ++cell) {
    const Gradients& g = d.shapes.geometry(d.mesh, cell, scratch).centre_gradients;
    const CellVectors x = corner_values(d.mesh, cell, d.mesh.nodes) + corner_values(d.mesh, cell, u);
    const Eigen::Matrix3d F = x * g.transpose(), R = nearest_rotation(F);
    const Eigen::Matrix3d V = R.transpose() * F - Eigen::Matrix3d::Identity();
    row.largest_turn = std::max(row.largest_turn, Eigen::AngleAxisd(R).angle());
    row.largest_strain = std::max(row.largest_strain, V.cwiseAbs().maxCoeff());
  }
  const Eigen::Matrix3Xd loads = internal_forces(d, u);
  // A start that is off by a smooth field of a twentieth of a radian or so.
  Eigen::Matrix3Xd start = u;
  for (int node = 0; node < d.mesh.node_count(); ++node)
    start.col(node) += 0.02 * std::sin(pi * d.mesh.nodes(0, node)) * Eigen::Vector3d(1.0, -0.5, 0.7);
  start = expand(d.hanging, gather(d.hanging, start));
  row.start_distance = (start - u).norm() / u.norm();
  for (const double residual : {1e-4, 1e-8, 1e-12}) {
    const Equilibrium solved = solve(forest, d, supports, loads, start, residual);
    row.iterations.push_back(solved.converged ? solved.newton_iterations : -1);
    row.distance = (solved.u - u).norm() / u.norm();
  }
  const TangentErrors errors = tangent_errors(d, u, 1e-6);
  row.frozen_tangent_error = errors.frozen;
  row.turning_share = errors.free;
  return row;
}

/// The body under a law's force, its boundary as the motion has it.
struct HyperelasticSolution {
  Discretization d;
  Equilibrium solved;
};
HyperelasticSolution solve_hyperelastic(const RefinementForest& forest, const Material& material, const Motion& motion,
                                        HyperelasticLaw law) {
  const std::vector<SupportCondition> supports = held(motion, all_around);
  HyperelasticSolution result{discretize(forest, material, supports), {}};
  const Discretization& d = result.d;
  const auto force = [&](const Eigen::Vector3d& X) { return hyperelastic_body_force(motion, law, material, X); };
  const Eigen::Matrix3Xd loads = nodal_loads(forest.base(), d.mesh, {}, force, 3);
  result.solved = solve(forest, d, supports, loads, interpolant(d, motion.displacement()), 1e-9);
  if (!result.solved.converged) throw std::runtime_error(motion.name + ": the solve did not converge");
  return result;
}

HyperelasticRow hyperelastic_row(const RefinementForest& forest, int across, double h, const Material& material,
                                 const Motion& motion, HyperelasticLaw law) {
  const HyperelasticSolution solution = solve_hyperelastic(forest, material, motion, law);
  const FormulaErrors errors = formula_errors(solution.d, motion.displacement(), solution.solved.u);
  HyperelasticRow row;
  row.cells_across = across;
  row.h = h;
  row.dofs = solution.d.dof_count();
  row.hanging_nodes = solution.d.hanging.hanging_count();
  row.iterations = solution.solved.newton_iterations;
  row.displacement_error = errors.displacement;
  row.gradient_error = errors.gradient;
  row.displacement_over_best = errors.displacement / errors.best_displacement;
  return row;
}

ErrorSeries series(const std::string& quantity, const std::vector<HyperelasticRow>& rows,
                   double HyperelasticRow::*error) {
  ErrorSeries result{quantity, {}, {}};
  for (const HyperelasticRow& row : rows) {
    result.h.push_back(row.h);
    result.error.push_back(row.*error);
  }
  return result;
}

Eigen::Matrix3d oblique_turn(double angle) {
  return Eigen::AngleAxisd(angle, Eigen::Vector3d(1.0, 2.0, -2.0) / 3.0).toRotationMatrix();
}

}  // namespace

FieldFormula Motion::displacement() const {
  return [phi = positions](const Jets& X) -> Jets {
    const Jets x = phi(X);
    return {x[0] - X[0], x[1] - X[1], x[2] - X[2]};
  };
}

Eigen::Matrix3d Motion::gradient(const Eigen::Vector3d& X) const {
  const Jets x = positions(coordinates_at(X));
  Eigen::Matrix3d F;
  for (int i = 0; i < 3; ++i) F.row(i) = x[i].gradient.transpose();
  return F;
}

Motion turned_motion(double angle, double strain, const ManufacturedSolution& field) {
  const Eigen::Matrix3d Q = oblique_turn(angle);
  return {"turned", [Q, strain, formula = field.formula](const Jets& X) {
            const Jets w = formula(X);
            Jets x;
            for (int i = 0; i < 3; ++i)
              for (int j = 0; j < 3; ++j) x[i] = x[i] + Q(i, j) * (X[j] + strain * w[j]);
            return x;
          }};
}

Motion bar_motion(double bend, double twist, double thickness, double strain) {
  return {"bar", [=](const Jets& X) -> Jets {
            // In units of the thickness across, so that the strain keeps its size in thinner bars.
            const Jet y = (1.0 / thickness) * X[1], z = (1.0 / thickness) * X[2], along = sin(2.0 * pi * X[0]);
            const double size = strain * thickness;
            const Jet a = X[0] + size * (along * y * z + sin(pi * y));
            const Jet b = X[1] + size * (along * cos(pi * y) + 0.5 * y * z);
            const Jet c = X[2] + size * (z * sin(pi * (2.0 * X[0] + y)));
            const Jet cosine = cos(twist * a), sine = sin(twist * a);
            const Jet b1 = cosine * b - sine * c, c1 = sine * b + cosine * c;
            if (bend == 0.0) return {a, b1, c1};
            const Jet radius = 1.0 / bend - b1;
            return {sin(bend * a) * radius, 1.0 / bend - cos(bend * a) * radius, c1};
          }};
}

Eigen::Vector3d hyperelastic_body_force(const Motion& motion, HyperelasticLaw law, const Material& material,
                                        const Eigen::Vector3d& X) {
  const SlopeMatrix P = piola(deformation_gradient(motion, X), law, material);
  Eigen::Vector3d force;
  for (int i = 0; i < 3; ++i) force[i] = -(P[i][0].gradient[0] + P[i][1].gradient[1] + P[i][2].gradient[2]);
  return force;
}

Eigen::Matrix3d piola_stress(HyperelasticLaw law, const Material& material, const Eigen::Matrix3d& F) {
  const SlopeMatrix P = piola(filled([&](int i, int j) { return Slope{F(i, j)}; }), law, material);
  Eigen::Matrix3d stress;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) stress(i, j) = P[i][j].value;
  return stress;
}

double stored_energy(HyperelasticLaw law, const Material& material, const Eigen::Matrix3d& F) {
  const Eigen::Matrix3d one = Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d strain = law == HyperelasticLaw::saint_venant_kirchhoff
                                     ? Eigen::Matrix3d(0.5 * (F.transpose() * F - one))
                                     : Eigen::Matrix3d(nearest_rotation(F).transpose() * F - one);
  const double trace = strain.trace();
  return material.mu() * strain.squaredNorm() + 0.5 * material.lambda() * trace * trace;
}

std::vector<RecoveredRow> recovered_displacements() {
  const double thickness = 0.125;
  const std::vector<RefinementTemplate> templates = {{{2, 2, 2}}, {{2, 3, 3}}};
  const std::vector<const char*> ends = {"x_min", "x_max"}, one_end = {"x_min"};
  const RefinementForest hexahedra = bar(thickness, 2, CellShape::hexahedron, templates);
  const RefinementForest tetrahedra = bar(thickness, 2, CellShape::tetrahedron, {{{2, 2, 2}}});
  CubeMesh octant;
  octant.perturbation = 0.15;
  octant.levels = {{{{3, 3, 3}}}};
  return {
      recover("bar_bent_by_180_degrees", hexahedra, bar_motion(pi, 0.0, thickness, 0.05), ends),
      recover("bar_twisted_by_180_degrees", hexahedra, bar_motion(0.0, pi, thickness, 0.05), ends),
      recover("cantilever_bent_by_90_degrees_and_twisted", hexahedra, bar_motion(0.5 * pi, 0.5 * pi, thickness, 0.02),
              one_end),
      recover("cube_turned_by_180_degrees", refined_cube(octant, 4), turned_motion(pi, 0.2, smooth_solution()),
              one_end),
      recover("tetrahedra_bent_by_120_degrees", tetrahedra, bar_motion(2.0 / 3.0 * pi, 0.0, thickness, 0.05), ends)};
}

std::vector<TurningShareRow> turning_shares() {
  CubeMesh octant;
  octant.levels = {{{{2, 3, 3}}}};
  const RefinementForest forest = refined_cube(octant, 4);
  const Discretization d = discretize(forest, corotational(), {});
  std::vector<TurningShareRow> rows;
  for (const double strain : {0.2, 0.1, 0.05}) {
    const Eigen::Matrix3Xd u = interpolant(d, turned_motion(2.0, strain, smooth_solution()).displacement());
    rows.push_back({strain, tangent_errors(d, u, 1e-6).free});
  }
  return rows;
}

ErrorSeries HyperelasticTable::displacement() const {
  return series(name + ", L2", rows, &HyperelasticRow::displacement_error);
}
ErrorSeries HyperelasticTable::gradient() const {
  return series(name + ", gradient", rows, &HyperelasticRow::gradient_error);
}

namespace {

/// sqrt of the mean of |½ (H + Hᵀ)|² over the cube, H the gradient of the field: what a strain of size one has.
double strain_of(const ManufacturedSolution& field) {
  CubeMesh mesh;
  const Mesh cells = refined_cube(mesh, 8).leaf_mesh();
  double sum = 0.0;
  for (int cell = 0; cell < cells.cell_count(); ++cell)
    for (int q = 0; q < 8; ++q) {
      const CellVectors X = corner_values(cells, cell, cells.nodes);
      const Eigen::Vector3d at =
          X.col(0) + quadrature_point(CellShape::hexahedron, q).cwiseProduct(X.col(7) - X.col(0));
      const Jets w = field.formula(coordinates_at(at));
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          const double e = 0.5 * (w[i].gradient[j] + w[j].gradient[i]);
          sum += e * e / (8.0 * cells.cell_count());
        }
    }
  return std::sqrt(sum);
}

constexpr double cube_turn = 2.0;  // [rad]

Motion turned_cube(double strain) {
  static const double of_one = strain_of(smooth_solution());
  return turned_motion(cube_turn, strain / of_one, smooth_solution());
}

Motion bent_bar(double thickness) { return bar_motion(pi, 0.5 * pi, thickness, 0.05 * thickness / 0.125); }

const std::vector<RefinementTemplate> no_templates;

Jets nothing(const Jets&) { return {}; }

double l2_norm(const Discretization& d, const Eigen::Matrix3Xd& u) {
  return formula_errors(d, nothing, u).displacement;
}

}  // namespace

HyperelasticTable turned_cube_table(const std::string& name, const CubeMesh& mesh, const Material& material,
                                    HyperelasticLaw law, double strain, const std::vector<int>& grids) {
  HyperelasticTable table{name, {}};
  for (const int n : grids)
    table.rows.push_back(hyperelastic_row(refined_cube(mesh, n), n, 1.0 / n, material, turned_cube(strain), law));
  return table;
}

double cube_error_at_rest(const CubeMesh& mesh, Material material, double strain, int n) {
  material.kinematics = Kinematics::linear;
  StaticCase the_case;
  the_case.name = "cube at rest";
  the_case.material = material;
  the_case.mesh = mesh;
  const Discretization d = discretize(refined_cube(mesh, n), material, {});
  const FieldFormula formula = smooth_solution().formula;
  const double norm = formula_errors(d, formula, interpolant(d, formula)).displacement_norm;
  return solve_static_case(the_case, n).displacement_error * norm * strain / strain_of(smooth_solution());
}

HyperelasticTable bent_bar_table(const std::string& name, HyperelasticLaw law, const std::vector<int>& across) {
  const double thickness = 0.125;
  HyperelasticTable table{name, {}};
  for (const int cells : across)
    table.rows.push_back(hyperelastic_row(bar(thickness, cells, CellShape::hexahedron, no_templates), cells,
                                          thickness / cells, corotational(), bent_bar(thickness), law));
  return table;
}

std::vector<LawDifferenceRow> cube_law_differences(const std::vector<double>& strains) {
  const RefinementForest forest = refined_cube({}, 6);
  std::vector<LawDifferenceRow> rows;
  for (const double strain : strains) {
    const Motion motion = turned_cube(strain);
    const Material material = corotational();
    const auto under = [&](HyperelasticLaw law) { return solve_hyperelastic(forest, material, motion, law); };
    const HyperelasticSolution S = under(HyperelasticLaw::saint_venant_kirchhoff);
    const HyperelasticSolution C = under(HyperelasticLaw::corotated);
    LawDifferenceRow row{strain, l2_norm(S.d, S.solved.u - C.solved.u), 0.0};  // volume and thickness are 1

    Material at_rest = material;
    at_rest.kinematics = Kinematics::linear;
    std::vector<SupportCondition> supports;
    for (const char* surface : all_around) supports.push_back({surface, std::nullopt, {}, {}});
    const Discretization d = discretize(forest, at_rest, supports);
    const Eigen::Matrix3d back = oblique_turn(cube_turn).transpose();
    const auto force = [&](const Eigen::Vector3d& X) -> Eigen::Vector3d {
      return back * (hyperelastic_body_force(motion, HyperelasticLaw::saint_venant_kirchhoff, material, X) -
                     hyperelastic_body_force(motion, HyperelasticLaw::corotated, material, X));
    };
    const Eigen::Matrix3Xd loads = nodal_loads(forest.base(), d.mesh, {}, force, 3);
    const Eigen::Matrix3Xd rest = Eigen::Matrix3Xd::Zero(3, d.mesh.node_count());
    row.predicted = l2_norm(d, solve(forest, d, supports, loads, rest, 1e-9).u);
    rows.push_back(row);
  }
  return rows;
}

std::vector<LawDifferenceRow> bar_law_differences(const std::vector<double>& thicknesses) {
  std::vector<LawDifferenceRow> rows;
  for (const double thickness : thicknesses) {
    const RefinementForest forest = bar(thickness, 4, CellShape::hexahedron, no_templates);
    const auto under = [&](HyperelasticLaw law) {
      return solve_hyperelastic(forest, corotational(), bent_bar(thickness), law);
    };
    const HyperelasticSolution S = under(HyperelasticLaw::saint_venant_kirchhoff);
    const HyperelasticSolution C = under(HyperelasticLaw::corotated);
    const double mean = l2_norm(S.d, S.solved.u - C.solved.u) / thickness;  // over the root of the volume
    rows.push_back({0.5 * pi * thickness, mean / thickness, 0.0});
  }
  return rows;
}

namespace {

constexpr HyperelasticLaw corotated = HyperelasticLaw::corotated,
                          saint_venant = HyperelasticLaw::saint_venant_kirchhoff;

/// That stress is the energy's derivative and the body force the stress's, by central differences.
void claim_derivatives(Evidence& evidence) {
  const Material material;
  const Motion motion = bent_bar(0.125);
  const double step = 1e-5;  // of F; round-off 1e-16 / 1e-5 of an energy of strain², over a stress of strain
  double stress_error = 0.0, force_error = 0.0;
  for (const HyperelasticLaw law : {corotated, saint_venant})
    for (const Eigen::Vector3d& X : {Eigen::Vector3d(0.2, 0.05, -0.03), Eigen::Vector3d(0.7, -0.06, 0.02)}) {
      const Eigen::Matrix3d F = motion.gradient(X), P = piola_stress(law, material, F);
      Eigen::Matrix3d slope;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          Eigen::Matrix3d ahead = F, behind = F;
          ahead(i, j) += step;
          behind(i, j) -= step;
          slope(i, j) = (stored_energy(law, material, ahead) - stored_energy(law, material, behind)) / (2.0 * step);
        }
      stress_error = std::max(stress_error, (slope - P).norm() / P.norm());
      Eigen::Vector3d force = Eigen::Vector3d::Zero();
      for (int j = 0; j < 3; ++j) {
        const Eigen::Vector3d along = 1e-5 * Eigen::Vector3d::Unit(j);
        force -= (piola_stress(law, material, motion.gradient(X + along)) -
                  piola_stress(law, material, motion.gradient(X - along)))
                     .col(j) /
                 2e-5;
      }
      const Eigen::Vector3d exact = hyperelastic_body_force(motion, law, material, X);
      force_error = std::max(force_error, (force - exact).norm() / exact.norm());
    }
  evidence.claim("stress_is_the_energys_derivative", stress_error, 0.0, 1e-7,
                 "differences over 1e-5: 1e-10, and round-off 1e-11 times E over a stress of E/20");
  evidence.claim("body_force_is_the_stress_divergence", force_error, 0.0, 1e-6,
                 "differences over 1e-5: the fields vary over an eighth, (1e-5 × 2 π × 8)² = 3e-7 at most");
}

void claim_recovered(Evidence& evidence) {
  EvidenceTable table{"displacements recovered from their own internal forces",
                      {"case", "dofs", "hanging", "turned [rad]", "strain", "start off by", "iterations to 1e-4",
                       "to 1e-8", "to 1e-12", "end off by", "tangent, R held", "tangent, R free"},
                      {}};
  for (const RecoveredRow& row : recovered_displacements()) {
    table.rows.push_back({row.name, static_cast<double>(row.dofs), static_cast<double>(row.hanging_nodes),
                          row.largest_turn, row.largest_strain, row.start_distance,
                          static_cast<double>(row.iterations[0]), static_cast<double>(row.iterations[1]),
                          static_cast<double>(row.iterations[2]), row.distance, row.frozen_tangent_error,
                          row.turning_share});
    evidence.claim(row.name + "_turn", row.largest_turn, 0.5 * pi, pi,
                   "a right angle at least: the rotation is finite");
    evidence.claim(row.name + "_start", row.start_distance, 0.01, 0.5, "near, and not the answer itself");
    evidence.claim(row.name + "_recovered", row.distance, 0.0, 1e-10,
                   "a residual of 1e-12 times the condition of a bar of eight times its thickness");
    evidence.claim(row.name + "_iterations", row.iterations[2] < 0 ? 0.0 : row.iterations[2] - row.iterations[0], 4.0,
                   90.0, "linear, not quadratic: eight decades take many steps, since the tangent leaves turning out");
    evidence.claim(row.name + "_frozen_tangent", row.frozen_tangent_error, 0.0, 1e-9,
                   "with the rotations held the force is linear: round-off over a step of 1e-6");
    evidence.claim(row.name + "_turning_over_strain", row.turning_share / row.largest_strain, 0.1, 0.4,
                   "what turning adds to the tangent is of the order of the stress over E");
  }
  evidence.tables.push_back(table);

  EvidenceTable shares{"what the tangent leaves out: differences with the rotations free", {"strain", "share"}, {}};
  ErrorSeries series{"turning", {}, {}};
  for (const TurningShareRow& row : turning_shares()) {
    shares.rows.push_back({row.strain, row.share});
    series.h.push_back(row.strain);
    series.error.push_back(row.share);
  }
  evidence.tables.push_back(shares);
  evidence.claim("turning_share_order", last_order(series), 0.97, 1.03,
                 "1: a turned body without strain has no stress to turn, and loses nothing");
}

void add_table(const HyperelasticTable& table, EvidenceTable& rows, EvidenceTable& orders) {
  for (const HyperelasticRow& row : table.rows)
    rows.rows.push_back({table.name, static_cast<double>(row.cells_across), static_cast<double>(row.dofs),
                         static_cast<double>(row.hanging_nodes), static_cast<double>(row.iterations),
                         row.displacement_error, row.displacement_over_best, row.gradient_error});
  orders.rows.push_back({table.name, last_order(table.displacement()), fitted_order(table.displacement()),
                         last_order(table.gradient()), fitted_order(table.gradient())});
}

struct TurnedCase {
  std::string name;
  CubeMesh mesh;
  Material material;
};
std::vector<TurnedCase> turned_cases() {
  std::vector<TurnedCase> cases(4);
  cases[0] = {"turned_hexahedra", {}, corotational()};
  cases[1] = {"turned_hexahedra_mean_dilatation", {}, corotational(0.45, Dilatation::mean)};
  cases[2] = {"turned_hexahedra_octant_2x2x2", {}, corotational()};
  cases[2].mesh.levels = {{{{2, 2, 2}}}};
  cases[3] = {"turned_tetrahedra", {}, corotational()};
  cases[3].mesh.shape = CellShape::tetrahedron;
  return cases;
}

}  // namespace

Evidence manufactured_corotational_evidence(const EvidenceOptions& options) {
  Evidence evidence;
  claim_derivatives(evidence);
  if (options.interrupted()) return evidence;
  options.progress(0.1, "displacements recovered");
  claim_recovered(evidence);

  EvidenceTable rows{"motions under the body force of an energy",
                     {"case", "n", "dofs", "hanging", "iterations", "L2 error", "over best", "gradient error"},
                     {}};
  EvidenceTable orders{"orders", {"case", "L2, last", "L2, all grids", "gradient, last", "gradient, all grids"}, {}};
  const std::vector<int> grids = options.full ? std::vector{4, 8, 16} : std::vector{4, 6, 8};
  const double strain = 0.05;
  double done = 0.2;
  for (const TurnedCase& the_case : turned_cases()) {
    if (options.interrupted()) return evidence;
    options.progress(done += 0.1, the_case.name);
    const HyperelasticTable table =
        turned_cube_table(the_case.name, the_case.mesh, the_case.material, corotated, strain, grids);
    add_table(table, rows, orders);
    const bool tetrahedra = the_case.mesh.shape == CellShape::tetrahedron;
    evidence.claim(the_case.name + "_displacement_order", last_order(table.displacement()), tetrahedra ? 1.86 : 1.97,
                   2.03, tetrahedra ? "2, reached from below, as at rest" : "2 to the bottom: no floor");
    evidence.claim(the_case.name + "_gradient_order", last_order(table.gradient()), 0.97,
                   the_case.material.dilatation == Dilatation::mean ? 1.08 : 1.04,
                   "1, from above: the gradient of what nodes are off by is of order 2, more with the mean dilatation");
    evidence.claim(the_case.name + "_error_over_error_at_rest",
                   table.rows.back().displacement_error /
                       cube_error_at_rest(the_case.mesh, the_case.material, strain, grids.back()),
                   0.98, 1.02,
                   "linear elasticity's error on the same mesh: a turn changes nothing, a strain of 1/20 little");
  }
  if (options.interrupted()) return evidence;
  options.progress(0.6, "bars");
  const std::vector<int> across = options.full ? std::vector{2, 4, 8} : std::vector{2, 4, 6};
  const HyperelasticTable bar_C = bent_bar_table("bent_bar", corotated, across);
  const HyperelasticTable bar_S = bent_bar_table("bent_bar_by_St_Venant", saint_venant, across);
  add_table(bar_C, rows, orders);
  add_table(bar_S, rows, orders);
  evidence.tables.push_back(rows);
  evidence.tables.push_back(orders);
  evidence.claim("bent_bar_displacement_order", last_order(bar_C.displacement()), 1.95, 2.05,
                 "2 to the bottom, though strains are up to a fifth: the corotated energy is the limit");
  evidence.claim("bent_bar_displacement_slope", fitted_order(bar_C.displacement()), 1.92, 2.05, "2 on all grids");
  evidence.claim("bent_bar_gradient_order", last_order(bar_C.gradient()), 0.97, 1.03, "1");
  evidence.claim("bent_bar_displacement_over_best", bar_C.rows.back().displacement_over_best, 2.15, 2.4,
                 "found, without a source of its own; each cell's own fit is the least, 1");
  evidence.claim("bent_bar_by_St_Venant_displacement_order", last_order(bar_S.displacement()), 0.0, 1.0,
                 "a floor: the energies differ at second order in the strain");

  options.progress(0.8, "laws");
  EvidenceTable laws{"solutions under the forces of the two energies, apart by",
                     {"body", "strain", "difference", "over strain²", "over predicted"},
                     {}};
  const auto add_laws = [&](const char* body, const std::vector<LawDifferenceRow>& differences) {
    ErrorSeries series{body, {}, {}};
    for (const LawDifferenceRow& row : differences) {
      laws.rows.push_back({body, row.strain, row.difference, row.difference / (row.strain * row.strain),
                           row.predicted > 0.0 ? TableValue(row.difference / row.predicted) : TableValue("-")});
      series.h.push_back(row.strain);
      series.error.push_back(row.difference);
    }
    return series;
  };
  const std::vector<LawDifferenceRow> cube = cube_law_differences({0.08, 0.04, 0.02});
  const std::vector<LawDifferenceRow> bars = bar_law_differences({0.25, 0.125, 0.0625});
  const ErrorSeries of_cube = add_laws("turned cube", cube), of_bars = add_laws("bent bars", bars);
  evidence.tables.push_back(laws);
  evidence.claim("law_difference_order", last_order(of_cube), 1.98, 2.02, "2: V C:V + ½ C:V²");
  evidence.claim("law_difference_over_predicted", cube.back().difference / cube.back().predicted, 0.995, 1.005,
                 "linear elasticity at rest has it to first order in the strain, 0.02, times a small number");
  evidence.claim("law_difference_order_in_bars", last_order(of_bars), 1.95, 2.15,
                 "2: V C:V + ½ C:V², strains go with the thickness");
  // What is left of St. Venant's error once the cells' own is taken off, over the distance of the solutions.
  const double thickness = 0.125;
  const double floor =
      std::sqrt(std::pow(bar_S.rows.back().displacement_error, 2) - std::pow(bar_C.rows.back().displacement_error, 2));
  evidence.claim("bent_bar_floor", floor / (bars[1].difference * thickness * thickness), 0.9, 1.1,
                 "the distance of the two solutions in cells of their own; the errors' product is left out");
  return evidence;
}

}  // namespace finegauge
