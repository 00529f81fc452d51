#include "verification/studies/manufactured_static.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>
#include <utility>

#include "core/equilibrium.hpp"
#include "verification/support/field_errors.hpp"
#include "verification/support/scrambled_mesh.hpp"

namespace finegauge {

namespace {

struct VolumePoint {
  std::array<double, max_corners> N;
  Gradients dN;  // by natural coordinates
  double weight;
};

std::vector<VolumePoint> volume_points(CellShape shape) {
  std::vector<VolumePoint> points;
  const auto add = [&](const Eigen::Vector3d& xi, double weight) {
    points.push_back({shape_functions(shape, xi), shape_gradients(shape, xi), weight});
  };
  if (shape == CellShape::tetrahedron) {
    for (const TetrahedronPoint& point : tetrahedron_rule()) add(point.xi, point.weight);
    return points;
  }
  const double offset = 0.5 * std::sqrt(0.6);
  const std::array<double, 3> x = {0.5 - offset, 0.5, 0.5 + offset}, w = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i) add({x[i], x[j], x[k]}, w[i] * w[j] * w[k]);
  return points;
}

Eigen::Vector3d values(const Jets& u) { return {u[0].value, u[1].value, u[2].value}; }
Eigen::Matrix3d gradient(const Jets& u) {
  Eigen::Matrix3d H;
  for (int i = 0; i < 3; ++i) H.row(i) = u[i].gradient.transpose();
  return H;
}

/// Stress [Pa] of a displacement gradient; `dilatation` is its trace, or what stands for it.
Eigen::Matrix3d linear_stress(const Material& material, const Eigen::Matrix3d& H, double dilatation) {
  Eigen::Matrix3d sigma = material.mu() * (H + H.transpose());
  sigma.diagonal().array() += material.bulk() * dilatation - 2.0 / 3.0 * material.mu() * H.trace();
  return sigma;
}

double complementary_square(const Material& material, const Eigen::Matrix3d& sigma) {
  const double nu = material.poisson_ratio, trace = sigma.trace();
  return ((1.0 + nu) * sigma.squaredNorm() - nu * trace * trace) / material.youngs_modulus;
}

bool is_box(const CubeMesh& mesh) { return mesh.shape == CellShape::hexahedron && mesh.perturbation == 0.0; }

ErrorSeries series(const std::string& quantity, const std::vector<StaticRow>& rows, double StaticRow::*error) {
  ErrorSeries result{quantity, {}, {}};
  for (const StaticRow& row : rows) {
    result.h.push_back(1.0 / row.n);
    result.error.push_back(row.*error);
  }
  return result;
}

}  // namespace

RefinementForest refined_cube(const CubeMesh& mesh, int n) {
  BoxMeshOptions options;
  options.cells = {n, n, n};
  options.shape = mesh.shape;
  std::mt19937 generator(mesh.seed);
  RefinementForest forest(distorted_box(options, mesh.perturbation, generator));
  // Where a leaf lies is asked of the cube before its nodes were moved: handles are the same in both.
  RefinementForest straight(box_mesh(options));
  double zone = 1.0;
  for (const std::vector<RefinementTemplate>& templates : mesh.levels) {
    zone *= 0.5;
    const Mesh leaves = straight.leaf_mesh();
    for (int cell = 0; cell < leaves.cell_count(); ++cell) {
      const CellVectors X = corner_values(leaves, cell, leaves.nodes);
      const Eigen::Vector3d centre = X.rowwise().sum() / corner_count(mesh.shape);
      if (centre.maxCoeff() > zone * (1.0 - 1e-9)) continue;
      const Eigen::Vector3d size = X.col(corner_count(mesh.shape) - 1) - X.col(0);
      const int turn = templates.size() == 1
                           ? 0
                           : static_cast<int>(std::floor(centre.x() / size.x()) + std::floor(centre.y() / size.y()) +
                                              std::floor(centre.z() / size.z()));
      const RefinementTemplate refinement = templates[turn % templates.size()];
      straight.refine(leaves.forest_cell[cell], refinement);
      forest.refine(leaves.forest_cell[cell], refinement);
    }
  }
  return forest;
}

Eigen::Matrix3Xd interpolant(const Discretization& d, const FieldFormula& exact) {
  Eigen::Matrix3Xd nodal(3, d.mesh.node_count());
  for (int node = 0; node < d.mesh.node_count(); ++node)
    nodal.col(node) = values(exact(coordinates_at(d.mesh.nodes.col(node))));
  return expand(d.hanging, gather(d.hanging, nodal));
}

std::vector<TetrahedronPoint> tetrahedron_rule() {
  // Degree 2 s + 1 with s = 2 in three dimensions: weights (-1)^i 2^(-2s) (2s + 4 - 2i)^(2s + 1) / (i! (2s + 4 - i)!),
  // points with barycentric coordinates (2 b + 1) / (2s + 4 - 2i), b whole numbers with sum s - i.
  std::vector<TetrahedronPoint> points;
  constexpr int s = 2;
  for (int i = 0; i <= s; ++i) {
    const double denominator = 2 * s + 4 - 2 * i;
    const double weight = (i % 2 == 0 ? 1.0 : -1.0) * std::pow(denominator, 2 * s + 1) /
                          (std::pow(2.0, 2 * s) * std::tgamma(i + 1.0) * std::tgamma(2.0 * s + 5.0 - i));
    for (int a = 0; a <= s - i; ++a)
      for (int b = 0; a + b <= s - i; ++b)
        for (int c = 0; a + b + c <= s - i; ++c)
          points.push_back({Eigen::Vector3d(2 * a + 1, 2 * b + 1, 2 * c + 1) / denominator, weight});
  }
  return points;
}

FormulaErrors formula_errors(const Discretization& d, const FieldFormula& exact, const Eigen::Matrix3Xd& u) {
  const Mesh& mesh = d.mesh;
  const Material& material = d.shapes.material();
  const bool linear = material.kinematics == Kinematics::linear, mean = material.dilatation == Dilatation::mean;
  const int corners = corner_count(mesh.shape);
  const std::vector<VolumePoint> points = volume_points(mesh.shape);
  FormulaErrors sum;  // of squares, until the end
  CellGeometry scratch;
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    const CellVectors X = corner_values(mesh, cell, mesh.nodes), u_h = corner_values(mesh, cell, u);
    const double cell_dilatation =
        mean ? u_h.cwiseProduct(d.shapes.geometry(mesh, cell, scratch).mean_gradients).sum() : 0.0;
    // The error itself is fitted, not u: u_h is one of the fits, and no digits are lost.
    Eigen::Matrix<double, max_corners, max_corners> mass = decltype(mass)::Zero();
    Eigen::Matrix<double, max_corners, 3> moments = decltype(moments)::Zero();
    double square = 0.0;
    for (const VolumePoint& point : points) {
      const Eigen::Matrix3d J = X * point.dN.transpose();
      const double dV = point.weight * std::abs(J.determinant());
      const Gradients gradients = J.inverse().transpose() * point.dN;
      const Eigen::Map<const Eigen::Matrix<double, max_corners, 1>> N(point.N.data());
      const Eigen::Vector3d at = X * N;
      const Jets u_exact = exact(coordinates_at(at));
      const Eigen::Vector3d value = values(u_exact), error = u_h * N - value;
      square += dV * error.squaredNorm();
      mass += dV * N * N.transpose();
      moments += dV * N * error.transpose();
      sum.displacement_norm += dV * value.squaredNorm();
      const Eigen::Matrix3d H = gradient(u_exact), H_h = u_h * gradients.transpose();
      sum.gradient += dV * (H_h - H).squaredNorm();
      sum.gradient_norm += dV * H.squaredNorm();
      if (!linear) continue;
      const Eigen::Matrix3d sigma = linear_stress(material, H, H.trace());
      const Eigen::Matrix3d sigma_h = linear_stress(material, H_h, mean ? cell_dilatation : H_h.trace());
      sum.energy += dV * complementary_square(material, sigma_h - sigma);
      sum.energy_norm += dV * complementary_square(material, sigma);
    }
    sum.displacement += square;
    const Eigen::MatrixXd used = mass.topLeftCorner(corners, corners), right = moments.topRows(corners);
    sum.best_displacement += square - right.cwiseProduct(used.ldlt().solve(right)).sum();
  }
  for (double* total : {&sum.displacement, &sum.displacement_norm, &sum.best_displacement, &sum.gradient,
                        &sum.gradient_norm, &sum.energy, &sum.energy_norm})
    *total = std::sqrt(*total);
  return sum;
}

double leading_energy_error(const Mesh& mesh, const Material& material, const FieldFormula& exact) {
  // In a box with edges h_j and coordinates ξ_j from its centre a trilinear field follows u to second order but for
  // ½ Σ_j u_,jj ξ_j²; what the interpolant leaves has the strain ½ (u_i,jj ξ_j + u_j,ii ξ_i), and the mean of ξ_i ξ_j
  // is δ_ij h_j²/12. Galerkin's solution is the interpolant to this order: on a mesh that is its own translate the
  // residual of that error is the same at every inner node, and a constant test function shows that it is none
  // (superconvergence; Křížek & Neittaanmäki 1987). With the mean dilatation the pressure error is that of a constant
  // fit to K div u, and the rest is deviatoric.
  const bool mean = material.dilatation == Dilatation::mean;
  const double mu = material.mu();
  const double along = mean ? 4.0 / 3.0 * mu : material.lambda() + 2.0 * mu;
  double sum = 0.0;
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    const CellVectors X = corner_values(mesh, cell, mesh.nodes);
    const Eigen::Vector3d size = X.col(7) - X.col(0);
    const Eigen::Vector3d square = size.cwiseAbs2();
    for (int q = 0; q < 8; ++q) {
      const Eigen::Vector3d at =
          X.col(0) + quadrature_point(CellShape::hexahedron, q).cwiseProduct(size);  // 2 × 2 × 2 Gauss
      const Jets u = exact(coordinates_at(at));
      double density = 0.0;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          density += (i == j ? along : mu) * square[j] * u[i].hessian(j, j) * u[i].hessian(j, j);
      if (mean)
        for (int j = 0; j < 3; ++j) {
          const double slope = u[0].hessian(0, j) + u[1].hessian(1, j) + u[2].hessian(2, j);
          density += material.bulk() * square[j] * slope * slope;
        }
      sum += size.prod() / 8.0 * density / 12.0;
    }
  }
  return std::sqrt(sum);
}

StaticRow solve_static_case(const StaticCase& the_case, int n) {
  const RefinementForest forest = refined_cube(the_case.mesh, n);
  const std::vector<SupportCondition> supports = held_all_around(the_case.exact);
  const Discretization d = discretize(forest, the_case.material, supports);
  const MeshHierarchy hierarchy = build_hierarchy(forest, d, supports);
  const auto force = [&](const Eigen::Vector3d& X) { return body_force(the_case.exact, the_case.material, X); };
  const Eigen::Matrix3Xd loads = nodal_loads(forest.base(), d.mesh, {}, force, 3);
  EquilibriumOptions options;
  options.linear.relative_residual = 1e-9;  // far below the smallest error here, 1e-3
  const Eigen::Matrix3Xd start = Eigen::Matrix3Xd::Zero(3, d.mesh.node_count());
  const Equilibrium solved = solve_equilibrium(d, hierarchy, loads, start, options);
  if (!solved.converged)
    throw std::runtime_error(the_case.name + ", n = " + std::to_string(n) + ": the solve did not converge");

  const FieldFormula formula = the_case.exact.formula;
  const FormulaErrors errors = formula_errors(d, formula, solved.u);
  const Eigen::Matrix3Xd conforming = interpolant(d, formula);
  StaticRow row;
  row.n = n;
  row.cells = d.mesh.cell_count();
  row.hanging_nodes = d.hanging.hanging_count();
  row.dofs = d.dof_count();
  row.displacement_error = errors.displacement / errors.displacement_norm;
  row.energy_error = errors.energy / errors.energy_norm;
  row.displacement_over_best = errors.displacement / errors.best_displacement;
  if (the_case.material.dilatation == Dilatation::standard)
    row.energy_over_interpolant = errors.energy / formula_errors(d, formula, conforming).energy;
  if (is_box(the_case.mesh))
    row.energy_over_leading = errors.energy / leading_energy_error(d.mesh, the_case.material, formula);
  double square = 0.0, norm = 0.0;
  for (int node = 0; node < d.mesh.node_count(); ++node) {
    if (d.mesh.on_boundary[node]) continue;
    square += (solved.u.col(node) - conforming.col(node)).squaredNorm();
    norm += conforming.col(node).squaredNorm();
  }
  row.nodal_error = std::sqrt(square / norm);
  return row;
}

ErrorSeries StaticTable::displacement() const {
  return series(the_case.name + ", L2", rows, &StaticRow::displacement_error);
}
ErrorSeries StaticTable::nodal() const { return series(the_case.name + ", nodal", rows, &StaticRow::nodal_error); }
ErrorSeries StaticTable::energy() const { return series(the_case.name + ", energy", rows, &StaticRow::energy_error); }

StaticTable static_table(const StaticCase& the_case) {
  StaticTable table{the_case, {}};
  for (const int n : the_case.grids) table.rows.push_back(solve_static_case(the_case, n));
  return table;
}

std::vector<StaticCase> static_cases(bool full) {
  const RefinementTemplate half{{2, 2, 2}}, third{{3, 3, 3}}, mixed{{2, 3, 3}}, flat{{4, 1, 2}};
  std::vector<StaticCase> cases;
  const auto add = [&](const std::string& name, const CubeMesh& mesh, const std::vector<int>& grids) {
    StaticCase& next = cases.emplace_back();
    next.name = name;
    next.mesh = mesh;
    next.grids = grids;
  };
  const std::vector<int> finest = {4, 8, 16, 24};
  const std::vector<int> fine = full ? finest : std::vector<int>{4, 8, 16},
                         usual = full ? finest : std::vector{4, 8, 12};
  const std::vector<int> few = full ? std::vector<int>{4, 8, 16} : std::vector<int>{4, 6, 8};
  add("hexahedra", {}, fine);
  add("hexahedra_perturbed", {.perturbation = 0.2}, usual);
  add("hexahedra_octant_2x2x2", {.levels = {{half}}}, few);
  add("hexahedra_octant_4x1x2", {.levels = {{flat}}}, few);
  add("hexahedra_perturbed_octant_2x3x3", {.perturbation = 0.2, .levels = {{mixed}}}, few);
  add("hexahedra_nested_twice", {.levels = {{half}, {third}}}, few);
  add("hexahedra_nested_three_times", {.levels = {{half}, {half}, {half}}}, few);
  add("hexahedra_mixed", {.levels = {{half, third, mixed}}}, few);
  add("hexahedra_mixed_and_nested", {.levels = {{half, third}, {mixed, half}}}, few);
  add("tetrahedra", {.shape = CellShape::tetrahedron}, usual);
  add("tetrahedra_perturbed", {.shape = CellShape::tetrahedron, .perturbation = 0.15}, usual);
  add("tetrahedra_nested_twice", {.shape = CellShape::tetrahedron, .levels = {{half}, {half}}}, few);
  if (!full) return cases;
  for (std::uint8_t a = 1; a <= max_divisions; ++a)
    for (std::uint8_t b = a; b <= max_divisions; ++b)
      for (std::uint8_t c = b; c <= max_divisions; ++c) {
        const RefinementTemplate refinement{{a, b, c}};
        if (c > 1 && refinement != half)
          add("hexahedra_octant_" + to_string(refinement), {.levels = {{refinement}}}, {4, 6, 8});
      }
  return cases;
}

std::vector<StaticCase> near_incompressible_cases(bool full) {
  std::vector<StaticCase> cases;
  const auto add = [&](Dilatation dilatation, double nu, const std::string& nu_name, double perturbation) {
    StaticCase& next = cases.emplace_back();
    next.name = std::string(dilatation == Dilatation::mean ? "mean" : "standard") + "_dilatation_nu_" + nu_name +
                (perturbation > 0.0 ? "_perturbed" : "");
    next.exact = isochoric_solution();
    next.material.poisson_ratio = nu;
    next.material.dilatation = dilatation;
    next.mesh.perturbation = perturbation;
    next.grids = full ? std::vector<int>{4, 8, 16, 24} : std::vector<int>{4, 8, 12};
  };
  for (const Dilatation dilatation : {Dilatation::standard, Dilatation::mean}) {
    add(dilatation, 0.4, "0.4", 0.0);
    add(dilatation, 0.499, "0.499", 0.0);
    add(dilatation, 0.4999, "0.4999", 0.0);
    add(dilatation, 0.4999, "0.4999", 0.2);
  }
  // Of this one an independent code's figures are known, on these grids.
  cases.front().grids = {4, 8, 16};
  return cases;
}

namespace {

EvidenceTable error_table(const std::string& title, const std::vector<StaticTable>& tables) {
  EvidenceTable text{title,
                     {"case", "n", "dofs", "hanging", "L2 error", "over best", "nodal error", "energy error",
                      "over interpolant", "over leading"},
                     {}};
  const auto or_none = [](double value) { return value > 0.0 ? TableValue(value) : TableValue("-"); };
  for (const StaticTable& table : tables)
    for (const StaticRow& row : table.rows)
      text.rows.push_back({table.the_case.name, static_cast<double>(row.n), static_cast<double>(row.dofs),
                           static_cast<double>(row.hanging_nodes), row.displacement_error, row.displacement_over_best,
                           row.nodal_error, row.energy_error, or_none(row.energy_over_interpolant),
                           or_none(row.energy_over_leading)});
  return text;
}

EvidenceTable order_table(const std::string& title, const std::vector<StaticTable>& tables) {
  EvidenceTable text{title, {"case", "L2, last", "L2, all grids", "energy, last", "energy, all grids"}, {}};
  for (const StaticTable& table : tables)
    text.rows.push_back({table.the_case.name, last_order(table.displacement()), fitted_order(table.displacement()),
                         last_order(table.energy()), fitted_order(table.energy())});
  return text;
}

struct Band {
  double low, high;
  const char* reason;
};

void claim_orders(Evidence& evidence, const StaticTable& table, const Band& displacement, const Band& energy) {
  const auto claim = [&](const char* quantity, double value, const Band& band) {
    evidence.claim(table.the_case.name + quantity, value, band.low, band.high, band.reason);
  };
  // Slopes over all grids hold more of the next terms: bands twice as wide.
  const auto wider = [](const Band& band) {
    const double more = 0.5 * (band.high - band.low);
    return Band{band.low - more, band.high + more, "the same on all grids, with more of the next terms"};
  };
  claim("_displacement_order", last_order(table.displacement()), displacement);
  claim("_displacement_slope", fitted_order(table.displacement()), wider(displacement));
  claim("_energy_order", last_order(table.energy()), energy);
  claim("_energy_slope", fitted_order(table.energy()), wider(energy));
}

constexpr double integration = 2e-4;  // what the points of errors and loads may add to an inequality
constexpr const char* cea_close =
    "at most 1 (Céa 1964); from below 1 - O(h²), as the interpolant is Galerkin's solution to first order";
constexpr const char* cea_unlike =
    "at most 1 (Céa 1964); below it by what the interpolant is off where cells are not their neighbours' translates";
constexpr const char* at_least_best = "no conforming field is nearer than each cell's own fit; ";

void claim_static(Evidence& evidence, const StaticTable& table, const StaticTable& regular) {
  const CubeMesh& mesh = table.the_case.mesh;
  const StaticRow& last = table.rows.back();
  const std::string& name = table.the_case.name;
  const auto interpolant_claim = [&](double low, const char* reason) {
    evidence.claim(name + "_energy_over_interpolant", last.energy_over_interpolant, low, 1.0 + integration, reason);
  };
  const auto best_claim = [&](double low, double high, const char* reason) {
    evidence.claim(name + "_displacement_over_best", last.displacement_over_best, low, high, reason);
  };
  if (mesh.shape == CellShape::tetrahedron) {
    claim_orders(evidence, table, {1.88, 2.03, "2, reached from below: the next term is felt on these grids"},
                 {0.97, 1.02, "1"});
    if (mesh.perturbation > 0.0)
      interpolant_claim(0.98, cea_unlike);
    else
      interpolant_claim(0.99, cea_close);
    best_claim(
        3.9, 4.4,
        "found, without a source of its own; a field's own fit in each cell is the least, 1, the interpolant has "
        "3.7 and nodes that are off by second order too");
    return;
  }
  if (mesh.perturbation > 0.0) {
    claim_orders(evidence, table, {1.92, 2.08, "2, and the chance of the perturbation"},
                 {0.97, 1.03, "1, and the chance of the perturbation"});
    interpolant_claim(0.96, cea_unlike);
  } else {
    claim_orders(evidence, table, {1.98, 2.02, "2"}, {0.99, 1.03, "1, and the layer at the front on refined meshes"});
    const bool one_template = std::ranges::all_of(mesh.levels, [](const auto& level) { return level.size() == 1; });
    if (mesh.levels.empty()) {
      interpolant_claim(0.997, cea_close);
      evidence.claim(name + "_energy_over_leading", last.energy_over_leading, 0.998, 1.003,
                     "the closed form of the first term in h; the next is of relative order h²");
    } else if (one_template) {
      interpolant_claim(0.98, cea_unlike);
      evidence.claim(
          name + "_energy_over_leading", last.energy_over_leading, 1.0, 1.015,
          "the closed form cell by cell; fine cells at the front follow the coarse ones, a layer of order h");
    } else {
      interpolant_claim(0.97, cea_unlike);
      evidence.claim(
          name + "_energy_over_leading", last.energy_over_leading, 1.0, 1.04,
          "the closed form cell by cell; every refined cell has neighbours of other templates to agree with");
    }
    for (const StaticRow& row : regular.rows)
      if (row.n == last.n && !mesh.levels.empty())
        evidence.claim(
            name + "_energy_over_unrefined", last.energy_error / row.energy_error, 0.951, 1.0,
            "at most 1, as a larger space has the smaller error; at least what the rest of the body has by the "
            "closed form, 0.951");
  }
  best_claim(2.7, 3.0, "found, without a source of its own; between each cell's own fit, 1, and the interpolant, 3.2");
}

void claim_near_incompressible(Evidence& evidence, const StaticTable& table) {
  const std::string& name = table.the_case.name;
  const StaticRow& last = table.rows.back();
  const double nu = table.the_case.material.poisson_ratio;
  const bool perturbed = table.the_case.mesh.perturbation > 0.0;
  if (table.the_case.material.dilatation == Dilatation::mean) {
    if (perturbed)
      claim_orders(evidence, table, {1.92, 2.08, "2 whatever nu, and the chance of the perturbation"},
                   {0.97, 1.05, "1 whatever nu, and the chance of the perturbation"});
    else
      claim_orders(evidence, table, {1.98, 2.02, "2 whatever nu"}, {0.98, 1.03, "1 whatever nu"});
    evidence.claim(name + "_displacement_over_best", last.displacement_over_best, 3.05, 3.55,
                   "found, without a source of its own; between each cell's own fit, 1, and the interpolant, 3.9");
    if (!perturbed)
      evidence.claim(name + "_energy_over_leading", last.energy_over_leading, 0.998, 1.01,
                     "the closed form of the first term, in which nu is no more; the next is of relative order h²");
    return;
  }
  evidence.claim(name + "_energy_over_interpolant", last.energy_over_interpolant, nu < 0.45 ? 0.997 : 0.8,
                 1.0 + integration, nu < 0.45 ? cea_close : "at most 1 (Céa 1964), and hardly better: it locks");
  if (nu < 0.45) {
    claim_orders(evidence, table, {1.97, 2.03, "2"}, {0.98, 1.02, "1"});
    evidence.claim(name + "_energy_over_leading", last.energy_over_leading, 0.996, 1.003,
                   "the closed form of the first term in h; the next is of relative order h²");
    evidence.claim(name + "_nodal_order", last_order(table.nodal()), 2.074, 2.086,
                   "2.08 of an independent code on these grids, to its digits");
    evidence.claim(name + "_nodal_error", last.nodal_error, 4.684e-4, 4.696e-4,
                   "4.69e-4 of an independent code on this grid, to its digits");
    return;
  }
  if (nu < 0.4995) {
    evidence.claim(name + "_displacement_order", last_order(table.displacement()), 0.4, 1.2,
                   "between locked, 0, and free, 2: free only once h² is small beside mu / lambda, 1/500");
    evidence.claim(name + "_displacement_error", last.displacement_error, 0.05, 0.3, "locked: tens of percent");
    return;
  }
  evidence.claim(name + "_displacement_order", last_order(table.displacement()), 0.0, 0.5,
                 "locked: h² is not small beside mu / lambda, 1/5000, on any of these grids");
  evidence.claim(name + "_displacement_error", last.displacement_error, 0.1, 0.3,
                 "locked: tens of percent at n = 16 by an independent code, and no less on coarser grids");
  evidence.claim(name + "_energy_order", last_order(table.energy()), 0.9, 1.05, "1: the energy norm looks perfect");
}

/// That the rules are what they are said to be.
void claim_integration(Evidence& evidence) {
  // ∫ x^a y^b z^c over the reference tetrahedron is a! b! c! / (a + b + c + 3)!.
  double worst = 0.0;
  for (int a = 0; a <= 5; ++a)
    for (int b = 0; a + b <= 5; ++b)
      for (int c = 0; a + b + c <= 5; ++c) {
        const double exact =
            std::tgamma(a + 1.0) * std::tgamma(b + 1.0) * std::tgamma(c + 1.0) / std::tgamma(a + b + c + 4.0);
        double sum = 0.0;
        for (const TetrahedronPoint& point : tetrahedron_rule())
          sum += point.weight * std::pow(point.xi.x(), a) * std::pow(point.xi.y(), b) * std::pow(point.xi.z(), c);
        worst = std::max(worst, std::abs(sum / exact - 1.0));
      }
  evidence.claim("tetrahedron_rule_degree_5", worst, 0.0, 1e-12,
                 "round-off: weights of either sign, up to 20 times 1/6");

  StaticCase the_case;
  the_case.mesh.perturbation = 0.15;
  const FieldFormula formula = the_case.exact.formula;
  FormulaErrors by_shape[2];
  for (const CellShape shape : {CellShape::hexahedron, CellShape::tetrahedron}) {
    the_case.mesh.shape = shape;
    const Discretization d = discretize(refined_cube(the_case.mesh, 8), the_case.material, {});
    const Eigen::Matrix3Xd u = interpolant(d, formula);
    FormulaErrors& errors = by_shape[shape == CellShape::tetrahedron];
    errors = formula_errors(d, formula, u);
    if (shape == CellShape::tetrahedron) continue;
    const Eigen::Matrix<double, 6, Eigen::Dynamic> none = Eigen::MatrixXd::Zero(6, d.mesh.node_count());
    const FieldErrors other = field_errors(d, the_case.exact, u, none);
    evidence.claim("displacement_error_by_more_points", errors.displacement / other.displacement, 1.0 - 1e-4,
                   1.0 + 1e-4,
                   "an integration of its own with 4 × 4 × 4 points: e² is a quartic but for higher orders");
    evidence.claim("energy_error_by_more_points", errors.energy / other.energy, 1.0 - 1e-4, 1.0 + 1e-4,
                   "an integration of its own with 4 × 4 × 4 points: e² is a quadratic but for higher orders");
  }
  evidence.claim("displacement_norm_in_tetrahedra_and_hexahedra",
                 by_shape[1].displacement_norm / by_shape[0].displacement_norm, 1.0 - 1e-6, 1.0 + 1e-6,
                 "one field, one body, two rules of degree 5 in cells of an eighth");
  evidence.claim("energy_norm_in_tetrahedra_and_hexahedra", by_shape[1].energy_norm / by_shape[0].energy_norm,
                 1.0 - 1e-6, 1.0 + 1e-6, "one field, one body, two rules of degree 5 in cells of an eighth");
}

}  // namespace

Evidence manufactured_static_evidence(const EvidenceOptions& options) {
  Evidence evidence;
  std::vector<StaticTable> tables, incompressible;
  const std::vector<StaticCase> cases = static_cases(options.full), near = near_incompressible_cases(options.full);
  double done = 0.0;
  const auto run = [&](const std::vector<StaticCase>& some, std::vector<StaticTable>& into) {
    for (const StaticCase& the_case : some) {
      if (options.interrupted()) return;
      options.progress(done++ / static_cast<double>(cases.size() + near.size()), the_case.name);
      into.push_back(static_table(the_case));
    }
  };
  run(cases, tables);
  run(near, incompressible);
  evidence.tables = {error_table("errors, nu = 0.3", tables), order_table("orders, nu = 0.3", tables),
                     error_table("errors of an isochoric field near incompressibility", incompressible),
                     order_table("orders for an isochoric field near incompressibility", incompressible)};
  claim_integration(evidence);
  for (const StaticTable& table : tables) claim_static(evidence, table, tables.front());
  for (const StaticTable& table : incompressible) claim_near_incompressible(evidence, table);
  // What nu does to the mean dilatation: nothing, from 0.4 to 0.4999.
  const auto row_of = [&](const char* name) -> const StaticRow* {
    for (const StaticTable& table : incompressible)
      if (table.the_case.name == name) return &table.rows.back();
    return nullptr;
  };
  const StaticRow *compressible = row_of("mean_dilatation_nu_0.4"), *nearly = row_of("mean_dilatation_nu_0.4999");
  if (compressible && nearly)
    evidence.claim(
        "mean_dilatation_error_at_nu_0.4999_over_0.4", nearly->displacement_error / compressible->displacement_error,
        0.99, 1.01,
        "the solution does not depend on nu, and a method free of locking has its error by a constant that does not");
  return evidence;
}

}  // namespace finegauge
