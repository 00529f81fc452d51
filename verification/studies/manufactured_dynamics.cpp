#include "verification/studies/manufactured_dynamics.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "core/tissue_forces.hpp"
#include "verification/support/tissue_samples.hpp"

namespace finegauge {

namespace {

using std::numbers::pi;
constexpr int instants = 8;  // at which a motion is compared, evenly over its duration

Jets trilinear_formula(const Jets& x) {
  const Jet xy = x[0] * x[1], yz = x[1] * x[2], zx = x[2] * x[0], xyz = xy * x[2];
  return {0.1 * (0.3 + x[0] - 0.5 * x[1] + 0.7 * yz - xyz), 0.1 * (0.2 + x[2] + 0.6 * zx + 0.4 * xy + xyz),
          0.1 * (x[1] - 0.8 * xy + 0.5 * x[0] - 0.6 * xyz)};
}

TissueProblem problem_of(const MovingCase& the_case) {
  TissueProblem problem;
  problem.material = the_case.material;
  problem.density = the_case.density;
  problem.mass_damping = the_case.mass_damping;
  problem.stiffness_damping = the_case.stiffness_damping;
  for (const char* surface : {"x_min", "x_max", "y_min", "y_max", "z_min", "z_max"})
    problem.supports.push_back({surface, std::nullopt,
                                [field = the_case.field](const Eigen::Vector3d& X) { return displacement(field, X); },
                                [course = the_case.course](double t) { return course(t); }});
  return problem;
}

/// Forces by the factors of time that they go with, reduced [N].
struct SpatialForces {
  Eigen::VectorXd inertia;  // of ρ f
  Eigen::VectorXd elastic;  // of -div σ(f)
};
SpatialForces spatial_forces(const MovingCase& the_case, const RefinementForest& forest, const TissueMesh& mesh) {
  const auto integrate = [&](const BodyForce& force) {
    return reduce_forces(mesh.d.hanging, nodal_loads(forest.base(), mesh.d.mesh, {}, force, 3));
  };
  SpatialForces forces;
  if (the_case.lumped_inertia)
    forces.inertia = mass_times(mesh.mass, gather(mesh.d.hanging, interpolant(mesh.d, the_case.field.formula)));
  else
    forces.inertia = integrate([&](const Eigen::Vector3d& X) -> Eigen::Vector3d {
      return the_case.density * displacement(the_case.field, X);
    });
  forces.elastic =
      integrate([&](const Eigen::Vector3d& X) { return body_force(the_case.field, the_case.material, X); });
  return forces;
}

FieldFormula scaled(const ManufacturedSolution& field, double size) {
  return [formula = field.formula, size](const Jets& X) -> Jets {
    const Jets f = formula(X);
    return {size * f[0], size * f[1], size * f[2]};
  };
}

void add_squares(const FormulaErrors& errors, FormulaErrors& sum) {
  for (double FormulaErrors::*member : {&FormulaErrors::displacement, &FormulaErrors::displacement_norm,
                                        &FormulaErrors::energy, &FormulaErrors::energy_norm})
    sum.*member += errors.*member * errors.*member;
}

double mass_norm(const TissueMesh& mesh, const Eigen::VectorXd& reduced) {
  return std::sqrt(reduced.dot(mass_times(mesh.mass, reduced)));
}

ErrorSeries series(const std::string& quantity, const std::vector<SpaceRow>& rows, double SpaceRow::*error) {
  ErrorSeries result{quantity, {}, {}};
  for (const SpaceRow& row : rows) {
    result.h.push_back(1.0 / row.n);
    result.error.push_back(row.*error);
  }
  return result;
}

}  // namespace

double TimeCourse::operator()(double t, int derivative) const {
  std::complex<double> factor = size;
  for (int k = 0; k < derivative; ++k) factor *= rate;
  return (factor * std::exp(rate * t)).real();
}

ManufacturedSolution trilinear_solution() { return {"trilinear", trilinear_formula}; }

MovedBody run_manufactured_motion(const MovingCase& the_case, int n, int steps, const StepObserver& observe) {
  const RefinementForest forest = refined_cube(the_case.mesh, n);
  const TissueProblem problem = problem_of(the_case);
  MovedBody body;
  body.mesh = build_tissue_mesh(forest, problem);
  const SpatialForces forces = spatial_forces(the_case, forest, body.mesh);
  const Eigen::Matrix3Xd f = interpolant(body.mesh.d, the_case.field.formula);
  const TimeCourse& g = the_case.course;
  body.state = {g(0.0) * f, g(0.0, 1) * f};
  FactorCache factors;
  TissueSystem system;
  const double tau = the_case.duration / steps;
  for (int step = 0; step < steps; ++step) {
    const double end = (step + 1) * tau;  // loads of an implicit step are those at its end
    body.mesh.loads = (g(end, 2) + the_case.mass_damping * g(end, 1)) * forces.inertia +
                      (g(end) + the_case.stiffness_damping * g(end, 1)) * forces.elastic;
    const TissueStepReport report =
        step_tissue(body.mesh, problem, step * tau, tau, {}, direct_linear_solve(factors), system, body.state);
    if (!report.converged) throw std::runtime_error(the_case.name + ": a step did not converge");
    body.largest_equilibrium_error = std::max(body.largest_equilibrium_error, report.equilibrium_error);
    if (observe) observe(step + 1, body.mesh, body.state);
  }
  return body;
}

double first_order_error(const MovingCase& the_case, int n) {
  const TissueMesh mesh = build_tissue_mesh(refined_cube(the_case.mesh, n), problem_of(the_case));
  const Discretization& d = mesh.d;
  const Eigen::VectorXd f = gather(d.hanging, interpolant(d, the_case.field.formula));
  const BlockMatrix<double> stiffness = assemble_stiffness(d, Eigen::Matrix3Xd::Zero(3, d.mesh.node_count()));
  Eigen::VectorXd Kf;
  multiply(stiffness, f, Kf);
  const Eigen::VectorXd Mf = mass_times(mesh.mass, f);
  const Eigen::VectorXd Cf = the_case.mass_damping * Mf + the_case.stiffness_damping * Kf;
  std::vector<int> free;
  for (int i = 0, s = 0; i < d.hanging.reduced_count(); ++i) {
    if (s < static_cast<int>(d.supports.reduced.size()) && d.supports.reduced[s] == i) {
      ++s;
      continue;
    }
    for (int axis = 0; axis < 3; ++axis) free.push_back(3 * i + axis);
  }
  Eigen::VectorXd root(free.size());
  for (std::size_t k = 0; k < free.size(); ++k) root[k] = std::sqrt(mesh.mass[free[k] / 3]);
  const Eigen::MatrixXd K = to_sparse(stiffness).toDense();
  const Eigen::MatrixXd K_free = K(free, free);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(root.cwiseInverse().asDiagonal() * K_free *
                                                             root.cwiseInverse().asDiagonal());
  const auto in_modes = [&](const Eigen::VectorXd& force) -> Eigen::ArrayXd {
    return (modes.eigenvectors().transpose() * force(free).cwiseQuotient(root)).array();
  };
  const Eigen::ArrayXd a = in_modes(Mf), c = in_modes(Cf), square = modes.eigenvalues().array();
  const Eigen::ArrayXd damping = the_case.mass_damping + the_case.stiffness_damping * square;
  const TimeCourse& g = the_case.course;
  // y: displacement and velocity per mode.
  using Pair = Eigen::Array<double, Eigen::Dynamic, 2>;
  const auto slope = [&](double t, const Pair& y) {
    Pair result(y.rows(), 2);
    result.col(0) = y.col(1);
    result.col(1) = a * g(t, 3) + 0.5 * c * g(t, 2) - damping * y.col(1) - square * y.col(0);
    return result;
  };
  Pair y = Pair::Zero(a.size(), 2);
  y.col(1) = 0.5 * g(0.0, 2) * a;
  constexpr int steps = 2000;  // a hundred or more in the shortest period
  const double dt = the_case.duration / steps;
  for (int step = 0; step < steps; ++step) {
    const double t = step * dt;
    const Pair k1 = slope(t, y), k2 = slope(t + 0.5 * dt, y + 0.5 * dt * k1);
    const Pair k3 = slope(t + 0.5 * dt, y + 0.5 * dt * k2), k4 = slope(t + dt, y + dt * k3);
    y += dt / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }
  return y.col(0).matrix().norm();
}

std::vector<TimeRow> time_rows(const MovingCase& the_case, int n, int coarsest_steps, int grids) {
  const double factor = first_order_error(the_case, n);
  std::vector<TimeRow> rows;
  Eigen::VectorXd before;
  for (int grid = 0, steps = coarsest_steps; grid < grids; ++grid, steps *= 2) {
    const MovedBody body = run_manufactured_motion(the_case, n, steps);
    const Discretization& d = body.mesh.d;
    const Eigen::VectorXd exact =
        the_case.course(the_case.duration) * gather(d.hanging, interpolant(d, the_case.field.formula));
    const Eigen::VectorXd error = gather(d.hanging, body.state.u) - exact;
    const double norm = mass_norm(body.mesh, exact);
    TimeRow row;
    row.steps = steps;
    row.tau = the_case.duration / steps;
    row.error = mass_norm(body.mesh, error) / norm;
    row.predicted = row.tau * factor / norm;
    if (grid > 0) row.space_error = mass_norm(body.mesh, 2.0 * error - before) / norm;
    before = error;
    rows.push_back(row);
  }
  return rows;
}

SpaceRow space_row(const MovingCase& the_case, int n, int steps) {
  if (steps % instants != 0) throw std::invalid_argument("the steps of " + the_case.name + " miss the instants");
  SpaceRow row;
  row.n = n;
  row.steps = steps;
  FormulaErrors u, v;  // squares, summed over the instants
  double courses = 0.0;
  const auto observe = [&](int done, const TissueMesh& mesh, const TissueState& state) {
    if (done % (steps / instants) != 0) return;
    const double t = the_case.duration * done / steps, size = the_case.course(t);
    add_squares(formula_errors(mesh.d, scaled(the_case.field, size), state.u), u);
    add_squares(formula_errors(mesh.d, scaled(the_case.field, the_case.course(t, 1)), state.v), v);
    courses += size * size;
  };
  const MovedBody body = run_manufactured_motion(the_case, n, steps, observe);
  const Discretization& d = body.mesh.d;
  row.dofs = d.dof_count();
  row.hanging_nodes = d.hanging.hanging_count();
  row.displacement_error = std::sqrt(u.displacement / u.displacement_norm);
  row.velocity_error = std::sqrt(v.displacement / v.displacement_norm);
  row.energy_error = std::sqrt(u.energy / u.energy_norm);
  if (the_case.mesh.shape == CellShape::hexahedron && the_case.mesh.perturbation == 0.0)
    row.energy_over_leading =
        std::sqrt(u.energy / courses) / leading_energy_error(d.mesh, the_case.material, the_case.field.formula);
  row.equilibrium_error = body.largest_equilibrium_error;
  return row;
}

ErrorSeries SpaceTable::displacement() const { return series(name + ", L2", rows, &SpaceRow::displacement_error); }
ErrorSeries SpaceTable::velocity() const { return series(name + ", velocity", rows, &SpaceRow::velocity_error); }
ErrorSeries SpaceTable::energy() const { return series(name + ", energy", rows, &SpaceRow::energy_error); }

namespace {
/// τ proportional to h².
int steps_on(int n, int coarsest, int coarsest_steps) {
  const double finer = static_cast<double>(n) / coarsest;
  return static_cast<int>(std::lround(coarsest_steps * finer * finer));
}
}  // namespace

SpaceTable space_table(const MovingCase& the_case, const std::vector<int>& grids, int coarsest_steps) {
  SpaceTable table{the_case.name, {}};
  for (const int n : grids) table.rows.push_back(space_row(the_case, n, steps_on(n, grids.front(), coarsest_steps)));
  return table;
}

std::vector<StandingWaveRow> standing_waves(const std::vector<int>& cells) {
  std::vector<StandingWaveRow> rows;
  for (const int n : cells) {
    TissueProblem problem;
    BoxMeshOptions box;
    box.cells = {n, 1, 1};
    box.size = {1.0, 1.0 / n, 1.0 / n};
    for (const char* surface : {"x_min", "x_max"}) problem.supports.push_back({surface, std::nullopt, {}, {}});
    for (const char* surface : {"y_min", "y_max"})
      problem.supports.push_back({surface, Eigen::Vector3d::UnitY(), {}, {}});
    for (const char* surface : {"z_min", "z_max"})
      problem.supports.push_back({surface, Eigen::Vector3d::UnitZ(), {}, {}});
    const TissueMesh mesh = build_tissue_mesh(RefinementForest(box_mesh(box)), problem);
    Eigen::VectorXd x = Eigen::VectorXd::Zero(mesh.d.dof_count());
    for (int i = 0; i < mesh.d.hanging.reduced_count(); ++i)
      x[3 * i] = std::sin(pi * mesh.d.mesh.nodes(0, mesh.d.hanging.node_of[i]));
    project(mesh.d.supports, x);
    Eigen::VectorXd Kx;
    multiply(assemble_stiffness(mesh.d, Eigen::Matrix3Xd::Zero(3, mesh.d.mesh.node_count())), x, Kx);
    project(mesh.d.supports, Kx);
    const Eigen::VectorXd Mx = mass_times(mesh.mass, x);
    const double square = x.dot(Kx) / x.dot(Mx);
    const Material& material = problem.material;
    const double speed = std::sqrt((material.lambda() + 2.0 * material.mu()) / problem.density);
    StandingWaveRow row;
    row.cells = n;
    row.frequency = std::sqrt(square) / (pi * speed);
    row.closed_form = std::sin(0.5 * pi / n) / (0.5 * pi / n);
    row.shape_residual = (Kx - square * Mx).norm() / Kx.norm();
    rows.push_back(row);
  }
  return rows;
}

std::vector<LumpingRow> lumping_shifts(const MovingCase& the_case, const std::vector<int>& grids, int coarsest_steps) {
  std::vector<LumpingRow> rows;
  for (const int n : grids) {
    const int steps = steps_on(n, grids.front(), coarsest_steps);
    std::vector<Eigen::Matrix3Xd> displacements[2];
    TissueMesh mesh;
    for (const bool lumped : {false, true}) {
      MovingCase one = the_case;
      one.lumped_inertia = lumped;
      const auto observe = [&](int done, const TissueMesh&, const TissueState& state) {
        if (done % (steps / instants) == 0) displacements[lumped].push_back(state.u);
      };
      mesh = run_manufactured_motion(one, n, steps, observe).mesh;
    }
    double square = 0.0, norm = 0.0;
    for (int k = 0; k < instants; ++k) {
      const double size = the_case.course(the_case.duration * (k + 1) / instants);
      const Eigen::Matrix3Xd difference = displacements[1][k] - displacements[0][k];
      square += std::pow(formula_errors(mesh.d, scaled(the_case.field, 0.0), difference).displacement, 2);
      norm += std::pow(formula_errors(mesh.d, scaled(the_case.field, size), difference).displacement_norm, 2);
    }
    rows.push_back({n, std::sqrt(square / norm)});
  }
  return rows;
}

std::vector<MovingCase> moving_cases() {
  std::vector<MovingCase> cases(4);
  for (MovingCase& the_case : cases) the_case.field = smooth_solution();
  cases[0].name = "hexahedra";
  cases[1].name = "hexahedra_with_lumped_inertia";
  cases[1].lumped_inertia = true;
  cases[2].name = "hexahedra_octant_2x2x2";
  cases[2].mesh.levels = {{{{2, 2, 2}}}};
  cases[3].name = "tetrahedra_damped";
  cases[3].mesh.shape = CellShape::tetrahedron;
  cases[3].mass_damping = 0.8;
  cases[3].stiffness_damping = 0.05;
  return cases;
}

Evidence manufactured_dynamics_evidence(const EvidenceOptions& options) {
  Evidence evidence;
  EvidenceTable in_time{"backward Euler in a field that the cells represent: errors at the end",
                        {"case", "steps", "tau [s]", "error", "over predicted", "error at tau -> 0"},
                        {}};
  MovingCase plain;
  plain.name = "undamped";
  plain.field = trilinear_solution();
  MovingCase damped = plain;
  damped.name = "damped";
  damped.mass_damping = 0.8;
  damped.stiffness_damping = 0.05;
  for (const MovingCase& the_case : {plain, damped}) {
    if (options.interrupted()) return evidence;
    options.progress(the_case.name == plain.name ? 0.0 : 0.1, the_case.name);
    const std::vector<TimeRow> rows = time_rows(the_case, 4, 40, options.full ? 6 : 4);
    ErrorSeries errors{the_case.name, {}, {}}, rest{the_case.name + ", extrapolated", {}, {}};
    for (const TimeRow& row : rows) {
      in_time.rows.push_back({the_case.name, static_cast<double>(row.steps), row.tau, row.error,
                              row.error / row.predicted,
                              row.space_error > 0.0 ? TableValue(row.space_error) : TableValue("-")});
      errors.h.push_back(row.tau);
      errors.error.push_back(row.error);
      if (row.space_error == 0.0) continue;
      rest.h.push_back(row.tau);
      rest.error.push_back(row.space_error);
    }
    const TimeRow &last = rows.back(), &before = rows[rows.size() - 2];
    evidence.claim(the_case.name + "_time_order", last_order(errors), 0.97, 1.01,
                   "1; the next term takes a share of the error that is a few τ/s");
    evidence.claim(the_case.name + "_time_slope", fitted_order(errors), 0.94, 1.02,
                   "1 on all grids, with more of the next term");
    evidence.claim(the_case.name + "_error_over_predicted",
                   2.0 * last.error / last.predicted - before.error / before.predicted, 0.997, 1.003,
                   "extrapolated to τ = 0: the modified equation's constant, to the square of the last ratio's error");
    evidence.claim(the_case.name + "_second_order", last_order(rest), 1.9, 2.1,
                   "what extrapolation leaves is of order 2 in τ: nothing of the cells' size is in the error");
  }
  evidence.tables.push_back(in_time);

  EvidenceTable in_space{
      "a smooth field with τ proportional to h²: root mean squares over eight instants",
      {"case", "n", "steps", "dofs", "hanging", "L2 error", "velocity error", "energy error", "over leading"},
      {}};
  EvidenceTable orders{"orders in h",
                       {"case", "L2, last", "L2, all grids", "velocity, last", "velocity, all grids", "energy, last",
                        "energy, all grids"},
                       {}};
  const std::vector<int> grids = options.full ? std::vector{4, 8, 12, 16} : std::vector{4, 6, 8};
  constexpr int coarsest_steps = 32;
  double balance = 0.0, done = 0.2;
  for (const MovingCase& the_case : moving_cases()) {
    if (options.interrupted()) return evidence;
    options.progress(done += 0.15, the_case.name);
    const SpaceTable table = space_table(the_case, grids, coarsest_steps);
    for (const SpaceRow& row : table.rows) {
      in_space.rows.push_back({table.name, static_cast<double>(row.n), static_cast<double>(row.steps),
                               static_cast<double>(row.dofs), static_cast<double>(row.hanging_nodes),
                               row.displacement_error, row.velocity_error, row.energy_error,
                               row.energy_over_leading > 0.0 ? TableValue(row.energy_over_leading) : TableValue("-")});
      balance = std::max(balance, row.equilibrium_error);
    }
    orders.rows.push_back({table.name, last_order(table.displacement()), fitted_order(table.displacement()),
                           last_order(table.velocity()), fitted_order(table.velocity()), last_order(table.energy()),
                           fitted_order(table.energy())});
    const auto claim = [&](const char* quantity, double value, double low, double high, const char* reason) {
      evidence.claim(the_case.name + quantity, value, low, high, reason);
    };
    claim("_displacement_order", last_order(table.displacement()), 1.9, 2.1, "2, and what still rings from the start");
    claim("_displacement_slope", fitted_order(table.displacement()), 1.85, 2.15, "the same on all grids");
    claim("_velocity_order", last_order(table.velocity()), 1.75, 2.1,
          "2, reached from below: ringing has higher frequencies than the motion");
    claim("_energy_order", last_order(table.energy()), 0.97, 1.08, "1; ringing is of order 2 and still felt");
    if (table.rows.back().energy_over_leading > 0.0)
      claim("_energy_over_leading", table.rows.back().energy_over_leading, 1.0, 1.04,
            "the static solution's first term in closed form, and ringing, which adds squares of higher order");
  }
  evidence.tables.push_back(in_space);
  evidence.tables.push_back(orders);
  evidence.claim("step_out_of_balance", balance, 0.0, 1e-11, "a linear step is one solve: round-off times condition");

  options.progress(0.9, "lumped mass");
  EvidenceTable shifts{"the force of inertia by the lumped mass, not by integration", {"n", "shift of u"}, {}};
  ErrorSeries shift{"lumping", {}, {}};
  const std::vector<int> shift_grids = options.full ? std::vector{4, 6, 8, 12, 16} : std::vector{4, 6, 8};
  for (const LumpingRow& row : lumping_shifts(moving_cases().front(), shift_grids, coarsest_steps)) {
    shifts.rows.push_back({static_cast<double>(row.n), row.shift});
    shift.h.push_back(1.0 / row.n);
    shift.error.push_back(row.shift);
  }
  evidence.tables.push_back(shifts);
  evidence.claim("lumping_order", last_order(shift), 1.5, 2.1,
                 "2: the corners' mean is off the integral by h²/12 times second derivatives; reached from below, by "
                 "1.63, 1.82 and 1.91 up to n = 16");
  evidence.claim("lumping_shift_over_h2", shift.error.back() / std::pow(shift.h.back(), 2), 0.2, 0.3,
                 "found, without a source of its own: a sixth of the error that the cells themselves make");

  EvidenceTable waves{"standing waves: frequency over exact", {"cells", "found", "closed form", "shape residual"}, {}};
  double worst_frequency = 0.0, worst_shape = 0.0;
  ErrorSeries slow{"frequency", {}, {}};
  for (const StandingWaveRow& row : standing_waves({4, 8, 16, 32})) {
    waves.rows.push_back({static_cast<double>(row.cells), row.frequency, row.closed_form, row.shape_residual});
    worst_frequency = std::max(worst_frequency, std::abs(row.frequency / row.closed_form - 1.0));
    worst_shape = std::max(worst_shape, row.shape_residual);
    slow.h.push_back(1.0 / row.cells);
    slow.error.push_back(1.0 - row.frequency);
  }
  evidence.tables.push_back(waves);
  evidence.claim("standing_wave_frequency", worst_frequency, 0.0, 1e-12,
                 "sin(k h/2) / (k h/2), to round-off times (2/kh)²");
  evidence.claim("standing_wave_shape", worst_shape, 0.0, 1e-11,
                 "a sine is an eigenvector, to round-off times (2/kh)²");
  evidence.claim("standing_wave_lag", slow.error.back() / std::pow(pi * slow.h.back(), 2) * 24.0, 0.999, 1.001,
                 "waves are late, by (k h)²/24 to first order");
  return evidence;
}

}  // namespace finegauge
