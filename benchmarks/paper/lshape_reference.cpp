#include "benchmarks/paper/lshape_reference.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <span>
#include <stdexcept>

#include "benchmarks/paper/box_elements.hpp"
#include "core/equilibrium.hpp"

namespace finegauge {
namespace {

/// Root of a continuous function that changes sign between the ends.
double bisect(const std::function<double(double)>& f, double low, double high) {
  const bool rising = f(low) < 0.0;
  for (int step = 0; step < 60; ++step) {
    const double middle = 0.5 * (low + high);
    ((f(middle) < 0.0) == rising ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// Appends n cells between `singular` and `regular`, graded towards the first, to ascending coordinates.
void append_graded(std::vector<double>& x, double singular, double regular, int n, double grading) {
  std::vector<double> part;
  for (int i = 0; i <= n; ++i)
    part.push_back(i == n ? regular : singular + (regular - singular) * std::pow(static_cast<double>(i) / n, grading));
  if (regular < singular) std::reverse(part.begin(), part.end());
  x.insert(x.end(), part.begin() + (x.empty() ? 0 : 1), part.end());
}

/// Cell boundaries of the lower half, 0 <= z <= 1. Singular are the re-entrant edge x = y = 2 and the clamped face's
/// edges at y = 2 and z = 0; along z the stress varies fastest near the free face.
std::array<std::vector<double>, 3> graded_coordinates(int n, double grading) {
  std::array<std::vector<double>, 3> x;
  append_graded(x[0], 2.0, 0.0, n, grading);
  append_graded(x[0], 2.0, 3.0, n / 2, grading);
  append_graded(x[0], 4.0, 3.0, n / 2, grading);
  append_graded(x[1], 2.0, 0.0, n, grading);
  append_graded(x[1], 2.0, 4.0, n, grading);
  append_graded(x[2], 0.0, 1.0, n / 2, grading);
  return x;
}

LshapeReferenceRun run_core(const std::array<std::vector<double>, 3>& coordinates, const RemovedBlock& notch) {
  const RefinementForest forest(tensor_mesh(coordinates, notch));
  const std::vector<SupportCondition> supports = {
      {"x_max", std::nullopt, {}}, {"y_max", Eigen::Vector3d::UnitY(), {}}, {"z_max", Eigen::Vector3d::UnitZ(), {}}};
  const Discretization d = discretize(forest, Material{}, supports);
  const Eigen::Matrix3Xd loads =
      nodal_loads(forest.base(), d.mesh, {{"x_min", LoadKind::traction, -Eigen::Vector3d::UnitX()}});
  EquilibriumOptions options;
  options.method = LinearMethod::direct;
  const Equilibrium equilibrium =
      solve_equilibrium(d, MeshHierarchy{}, loads, Eigen::Matrix3Xd::Zero(3, d.mesh.node_count()), options);
  LshapeReferenceRun run;
  run.cells = d.mesh.cell_count(), run.dofs = d.dof_count();
  run.energy = 2.0 * equilibrium.energy;
  run.relative_residual = equilibrium.relative_residual, run.converged = equilibrium.converged;
  return run;
}

LshapeReferenceRun run_box_elements(const std::array<std::vector<double>, 3>& coordinates, const RemovedBlock& notch,
                                    int order) {
  BoxElementProblem problem;
  problem.coordinates = coordinates, problem.removed = notch, problem.order = order;
  problem.traction = -Eigen::Vector3d::UnitX();
  problem.held = [](const Eigen::Vector3d& X) {
    const bool clamped = X.x() == 4.0;
    return std::array<bool, 3>{clamped, clamped || X.y() == 4.0, clamped || X.z() == 1.0};
  };
  const BoxElementSolution solution = solve_box_elements(problem);
  LshapeReferenceRun run;
  run.cells = solution.cells, run.dofs = solution.dofs;
  run.energy = 2.0 * solution.energy;
  run.relative_residual = solution.relative_residual;
  // Direct solves of these graded meshes leave 1e-9 at most; the energy is off by about the square.
  run.converged = solution.relative_residual <= 1e-6;
  return run;
}

/// Orders in 1/n of the energy's error, ascending: of the strongest singularity at each kind of edge as far as the
/// grading resolves it, and of the smooth part.
std::vector<double> error_exponents(int order, double grading) {
  std::vector<double> exponents = {2.0 * grading * reentrant_edge_exponent(), 2.0 * grading * clamped_edge_exponent(),
                                   2.0 * order};
  std::sort(exponents.begin(), exponents.end());
  return exponents;
}

/// The constant of E - sum_k a_k n^-s_k through the last meshes, one more than exponents.
double fit_limit(std::span<const LshapeReferenceRun> runs, std::span<const double> exponents) {
  const Eigen::Index m = static_cast<Eigen::Index>(exponents.size()) + 1;
  const std::span<const LshapeReferenceRun> last = runs.last(static_cast<std::size_t>(m));
  Eigen::MatrixXd A(m, m);
  Eigen::VectorXd energies(m);
  for (Eigen::Index i = 0; i < m; ++i) {
    const double ratio = static_cast<double>(last[i].cells_per_edge) / last.front().cells_per_edge;
    A(i, 0) = 1.0;
    for (Eigen::Index k = 1; k < m; ++k) A(i, k) = -std::pow(ratio, -exponents[k - 1]);
    energies[i] = last[i].energy;
  }
  return A.fullPivLu().solve(energies)[0];
}

/// s of E - a n^-s through three meshes; zero when the energies do not rise as such a power.
double observed_exponent(const LshapeReferenceRun& a, const LshapeReferenceRun& b, const LshapeReferenceRun& c) {
  const double ratio = (b.energy - a.energy) / (c.energy - b.energy);
  const auto mismatch = [&](double s) {
    const double ab = std::pow(a.cells_per_edge, -s) - std::pow(b.cells_per_edge, -s);
    const double bc = std::pow(b.cells_per_edge, -s) - std::pow(c.cells_per_edge, -s);
    return ab / bc - ratio;
  };
  constexpr double low = 0.05, high = 20.0;
  if (!(mismatch(low) < 0.0 && mismatch(high) > 0.0)) return 0.0;
  return bisect(mismatch, low, high);
}

void check_sequence(const ReferenceSequence& sequence) {
  const bool ascending =
      std::adjacent_find(sequence.cells.begin(), sequence.cells.end(), std::greater_equal<>{}) == sequence.cells.end();
  if (sequence.cells.size() < 3 || !ascending)
    throw std::invalid_argument("a reference sequence needs three or more meshes, coarse to fine");
}

}  // namespace

double reentrant_edge_exponent() {
  // sin(lambda omega) = -lambda sin(omega) at omega = 270 degrees, the symmetric mode.
  return bisect([](double lambda) { return std::sin(1.5 * std::numbers::pi * lambda) - lambda; }, 0.5, 0.9);
}

double clamped_edge_exponent(double poisson_ratio) {
  // 4 kappa sin²(lambda omega) = (kappa + 1)² - 4 lambda² sin²(omega) at omega = 90 degrees.
  const double kappa = 3.0 - 4.0 * poisson_ratio;
  return bisect(
      [kappa](double lambda) {
        const double sine = std::sin(0.5 * std::numbers::pi * lambda);
        return 4.0 * kappa * sine * sine - (kappa + 1.0) * (kappa + 1.0) + 4.0 * lambda * lambda;
      },
      0.3, 1.0);
}

LshapeReferenceRun lshape_reference_run(int order, double grading, int cells_per_edge) {
  const int n = cells_per_edge;
  if (!(n > 0 && n % 2 == 0))
    throw std::invalid_argument("cells_per_edge is " + std::to_string(n) + ", but must be even and positive");
  if (!(grading >= 1.0 && std::isfinite(grading)))
    throw std::invalid_argument("grading is " + std::to_string(grading) + ", but must be finite and at least 1");
  const std::array<std::vector<double>, 3> coordinates = graded_coordinates(n, grading);
  const RemovedBlock notch = {{n, 0, 0}, {2 * n, n, n / 2}};
  LshapeReferenceRun run = order == 1 ? run_core(coordinates, notch) : run_box_elements(coordinates, notch, order);
  run.cells_per_edge = n;
  return run;
}

ExtrapolatedSequence extrapolate(const ReferenceSequence& sequence, std::vector<LshapeReferenceRun> runs) {
  check_sequence(sequence);
  ExtrapolatedSequence result;
  result.order = sequence.order, result.grading = sequence.grading;
  result.exponents = error_exponents(sequence.order, sequence.grading);
  result.exponents.resize(std::min(result.exponents.size(), runs.size() - 1));
  result.extrapolated = fit_limit(runs, result.exponents);
  const std::size_t fewer = std::min(result.exponents.size(), runs.size() - 2);
  result.without_finest = fit_limit(std::span(runs).first(runs.size() - 1), std::span(result.exponents).first(fewer));
  result.observed_exponent = observed_exponent(runs[runs.size() - 3], runs[runs.size() - 2], runs.back());
  result.runs = std::move(runs);
  return result;
}

LshapeReferenceEnergy lshape_reference_energy(const LshapeReferenceOptions& options) {
  // The finest meshes take nearly all of the time, which grows with about the square of the dofs.
  const auto work = [](int order, int n) { return std::pow(static_cast<double>(order) * n, 6); };
  double all = 0.0, done = 0.0;
  for (const ReferenceSequence& sequence : options.sequences) {
    check_sequence(sequence);
    for (const int n : sequence.cells) all += work(sequence.order, n);
  }
  LshapeReferenceEnergy result;
  result.converged = !options.sequences.empty();
  int highest = 0;
  for (const ReferenceSequence& sequence : options.sequences) {
    std::vector<LshapeReferenceRun> runs;
    for (const int n : sequence.cells) {
      options.progress(done / all, "reference energy, order " + std::to_string(sequence.order) + ", " +
                                       std::to_string(n) + " cells per edge");
      runs.push_back(lshape_reference_run(sequence.order, sequence.grading, n));
      result.converged = result.converged && runs.back().converged;
      result.lower_bound = std::max(result.lower_bound, runs.back().energy);
      done += work(sequence.order, n);
    }
    result.sequences.push_back(extrapolate(sequence, std::move(runs)));
    highest = std::max(highest, sequence.order);
  }
  int used = 0;
  for (const ExtrapolatedSequence& sequence : result.sequences)
    if (sequence.order == highest) {
      result.value += sequence.extrapolated;
      ++used;
    }
  if (used > 0) result.value /= used;
  for (const ExtrapolatedSequence& sequence : result.sequences) {
    result.uncertainty = std::max(result.uncertainty, std::abs(sequence.extrapolated - result.value));
    if (sequence.order == highest)
      result.uncertainty = std::max(result.uncertainty, std::abs(sequence.extrapolated - sequence.without_finest));
  }
  return result;
}

StoredReference read_lshape_reference(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) throw std::runtime_error(file.string() + ": cannot be opened");
  try {
    const nlohmann::json document = nlohmann::json::parse(stream);
    return {document.at("value").get<double>(), document.at("uncertainty").get<double>()};
  } catch (const nlohmann::json::exception& error) {
    throw std::runtime_error(file.string() + ": " + error.what());
  }
}

}  // namespace finegauge
