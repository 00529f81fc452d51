#include "benchmarks/paper/lshape_reference.hpp"

#include <cmath>
#include <stdexcept>

#include "benchmarks/paper/box_elements.hpp"
#include "benchmarks/paper/lshape_problem.hpp"
#include "core/equilibrium.hpp"
#include "verification/support/catch.hpp"

using namespace finegauge;

namespace {

StoredReference stored_reference() {
  return read_lshape_reference(std::string(FINEGAUGE_SOURCE_DIR) + "/reference_data/exact/lshape.json");
}

/// Energy norm of the error over that of the solution, by orthogonality.
double true_error(const LshapeReferenceRun& run, double exact_energy) {
  return std::sqrt(1.0 - run.energy / exact_energy);
}

}  // namespace

TEST_CASE("box elements of every order are exact in uniform tension", "[reference]") {
  BoxElementProblem problem;
  problem.order = GENERATE(1, 2, 3, 5);
  CAPTURE(problem.order);
  problem.coordinates = {{{0.0, 0.1, 0.7, 2.0}, {0.0, 0.4, 1.0}, {0.0, 0.3, 3.0}}};
  problem.traction = {-2.0, 0.0, 0.0};
  problem.held = [](const Eigen::Vector3d& X) { return std::array<bool, 3>{X.x() == 2.0, X.y() == 0.0, X.z() == 0.0}; };
  const BoxElementSolution solution = solve_box_elements(problem);
  const int nodes = (3 * problem.order + 1) * (2 * problem.order + 1) * (2 * problem.order + 1);
  CHECK(solution.dofs == 3 * nodes);
  const double exact = 2.0 * 2.0 / problem.material.youngs_modulus * 6.0;  // stress² / E × volume
  CHECK_THAT(solution.energy, WithinRel(exact, 1e-11));                    // round-off times condition
}

TEST_CASE("box elements of order one and the core's hexahedra have the same energy", "[reference]") {
  BoxElementProblem problem;
  problem.coordinates = {{{0.0, 0.875, 1.5, 1.875, 2.0, 2.25, 3.0, 3.75, 4.0},
                          {0.0, 0.875, 1.5, 1.875, 2.0, 2.125, 2.5, 3.125, 4.0},
                          {0.0, 0.25, 1.0}}};
  problem.removed = RemovedBlock{{4, 0, 0}, {8, 4, 2}};
  problem.traction = {-1.0, 0.0, 0.0};
  problem.held = [](const Eigen::Vector3d& X) {
    const bool clamped = X.x() == 4.0;
    return std::array<bool, 3>{clamped, clamped || X.y() == 4.0, clamped || X.z() == 1.0};
  };
  const LshapeReferenceRun core = lshape_reference_run(1, 2.0, 4);
  const BoxElementSolution boxes = solve_box_elements(problem);
  CHECK(boxes.cells == core.cells);
  CHECK(boxes.dofs == core.dofs);
  CHECK_THAT(2.0 * boxes.energy, WithinRel(core.energy, 1e-11));
}

TEST_CASE("half the thickness with a plane of symmetry stands for the whole L-shape", "[reference]") {
  const LshapeProblem whole = lshape_problem();
  const Discretization d = discretize(whole.forest, whole.material, whole.supports);
  EquilibriumOptions options;
  options.method = LinearMethod::direct;
  const Equilibrium equilibrium =
      solve_equilibrium(d, MeshHierarchy{}, nodal_loads(whole.forest.base(), d.mesh, whole.loads),
                        Eigen::Matrix3Xd::Zero(3, d.mesh.node_count()), options);
  REQUIRE(equilibrium.converged);
  const LshapeReferenceRun half = lshape_reference_run(1, 1.0, 4);  // grading 1: the same cells
  REQUIRE(2 * half.cells == d.mesh.cell_count());
  CHECK_THAT(half.energy, WithinRel(equilibrium.energy, 1e-11));
}

TEST_CASE("energies rise with nested cells and with the order and stay below the reference", "[reference]") {
  const double grading = GENERATE(1.0, 2.0, 4.0);
  CAPTURE(grading);
  const double coarse = lshape_reference_run(1, grading, 2).energy;
  const double fine = lshape_reference_run(1, grading, 4).energy;
  const double quadratic = lshape_reference_run(2, grading, 4).energy;
  const double cubic = lshape_reference_run(3, grading, 4).energy;
  CHECK(coarse < fine);
  CHECK(fine < quadratic);
  CHECK(quadratic < cubic);
  CHECK(cubic < stored_reference().value);
}

TEST_CASE("the edges of the L-shape have the exponents of plane strain", "[reference]") {
  CHECK_THAT(reentrant_edge_exponent(), WithinAbs(0.544483737, 1e-8));
  CHECK_THAT(clamped_edge_exponent(0.3), WithinAbs(0.7112, 5e-5));
  // As nu -> 1/2 the equation becomes cos(pi lambda / 2) = lambda.
  const double incompressible = clamped_edge_exponent(0.5);
  CHECK_THAT(std::cos(0.5 * std::acos(-1.0) * incompressible), WithinAbs(incompressible, 1e-12));
}

TEST_CASE("extrapolation is exact for errors of the form that it assumes", "[reference]") {
  const ReferenceSequence sequence = {3, 2.0, {2, 4, 6, 8}};
  const double s = 4.0 * reentrant_edge_exponent(), t = 4.0 * clamped_edge_exponent();
  std::vector<LshapeReferenceRun> runs;
  for (const int n : sequence.cells) {
    LshapeReferenceRun run;
    run.cells_per_edge = n;
    run.energy = 0.09 - 0.3 * std::pow(n, -s) + 0.2 * std::pow(n, -t) - 0.1 * std::pow(n, -6.0);
    runs.push_back(run);
  }
  const ExtrapolatedSequence result = extrapolate(sequence, runs);
  REQUIRE(result.exponents.size() == 3);
  CHECK_THAT(result.extrapolated, WithinAbs(0.09, 1e-14));
  CHECK(std::abs(result.without_finest - 0.09) > 1e-8);  // one exponent less: not exact here

  for (LshapeReferenceRun& run : runs) run.energy = 0.09 - 0.3 * std::pow(run.cells_per_edge, -2.5);
  CHECK_THAT(extrapolate(sequence, runs).observed_exponent, WithinAbs(2.5, 1e-9));
}

TEST_CASE("coarse cubic meshes converge at the notch's order and extrapolate to the stored energy", "[reference]") {
  const StoredReference stored = stored_reference();
  CHECK(stored.uncertainty > 0.0);
  CHECK(stored.uncertainty < 1e-5 * stored.value);  // five digits
  LshapeReferenceOptions options;
  options.sequences = {{3, 2.0, {2, 4, 6}}};
  const LshapeReferenceEnergy energy = lshape_reference_energy(options);
  REQUIRE(energy.converged);
  const ExtrapolatedSequence& sequence = energy.sequences.front();
  CAPTURE(sequence.runs[0].energy, sequence.runs[1].energy, sequence.runs[2].energy, energy.value);
  // Grading 2 is too weak for cubic elements: the re-entrant edge dominates, and the order is twice 2 × its exponent.
  CHECK_THAT(sequence.observed_exponent, WithinRel(4.0 * reentrant_edge_exponent(), 0.01));
  // Next to it the clamped edge's order is fitted, what remains is of still higher order: far less than the error of
  // the finest mesh.
  const double finest_error = stored.value - energy.lower_bound;
  REQUIRE(finest_error > 100.0 * stored.uncertainty);
  CHECK(std::abs(energy.value - stored.value) < 0.05 * finest_error);
  CHECK(std::abs(energy.value - stored.value) < 2e-5 * stored.value);
}

TEST_CASE("against the stored energy uniform trilinear meshes converge at the notch's exponent", "[reference]") {
  const double exact = stored_reference().value;
  const double h2 = true_error(lshape_reference_run(1, 1.0, 4), exact);
  const double h4 = true_error(lshape_reference_run(1, 1.0, 8), exact);
  const double h8 = true_error(lshape_reference_run(1, 1.0, 16), exact);
  CAPTURE(h2, h4, h8);
  CHECK_THAT(h2, WithinAbs(0.246, 0.003));
  // Over two halvings; the smooth part, of order one, still adds a little to the exponent of 0.544.
  const double slope = 0.5 * std::log2(h2 / h8);
  CHECK(slope > reentrant_edge_exponent());
  CHECK(slope < 0.60);
}

TEST_CASE("the reference study refuses what it cannot compute", "[reference]") {
  CHECK_THROWS_AS(lshape_reference_run(1, 2.0, 3), std::invalid_argument);
  CHECK_THROWS_AS(lshape_reference_run(1, std::nan(""), 4), std::invalid_argument);
  CHECK_THROWS_AS(lshape_reference_run(0, 2.0, 4), std::invalid_argument);
  LshapeReferenceOptions options;
  options.sequences = {{1, 2.0, {2, 4}}};
  CHECK_THROWS_AS(lshape_reference_energy(options), std::invalid_argument);
  CHECK_THROWS_AS(read_lshape_reference("no/such/file.json"), std::runtime_error);
}
