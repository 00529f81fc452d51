#include "benchmarks/paper/tjunctions_crossover.hpp"

#include <cmath>
#include <vector>

#include "benchmarks/paper/tjunctions_cases.hpp"
#include "verification/support/catch.hpp"

using namespace finegauge;
using Catch::Matchers::WithinRel;

TEST_CASE("crossovers of power laws are where the laws cross", "[tjunctions]") {
  // Errors n^-1/6 on uniform meshes and n^-1/3 on refined ones, both from 100 dofs and error 1; a microsecond per dof
  // and, with hanging nodes, three. Equal error: n_c = 100 (n/100)². Equal time: n_c = 3 n, so n = 300.
  LshapeSequences study;
  study.reference_energy = 1.0;
  const auto add = [&](LshapeScheme scheme, double dofs, double exponent, double us) {
    LshapeStep step;
    step.scheme = scheme;
    step.dofs = static_cast<int>(dofs);
    const double error = 0.9 * std::pow(dofs / 100.0, -exponent);
    step.energy = 1.0 - error * error;
    step.topology_ms = 0.5e-3 * us * dofs, step.solve_ms = 0.5e-3 * us * dofs;
    step.eta = error, step.assemble_ms = step.reduce_ms = 0.0, step.mark_ms = 0.0;
    if (scheme == LshapeScheme::adaptive)
      step.estimate_ms = 2.0 / 3.0 * 1e-3 * us * dofs, step.solve_ms = step.topology_ms = 1e-3 / 6.0 * us * dofs;
    study.sequences[scheme].push_back(step);
  };
  for (const double dofs : {100.0, 800.0, 6400.0, 51200.0}) add(LshapeScheme::uniform, dofs, 1.0 / 6.0, 1.0);
  for (const double dofs : {100.0, 200.0, 400.0, 800.0, 1600.0}) add(LshapeScheme::adaptive, dofs, 1.0 / 3.0, 3.0);
  const std::vector<EqualError> meshes = equal_errors(study, LshapeScheme::adaptive);
  REQUIRE(meshes.size() == 5);
  CHECK_THAT(meshes[2].conforming_dofs, WithinRel(1600.0, 1e-9));
  CHECK_THAT(meshes[2].gain(), WithinRel(1600.0 / 1200.0, 1e-9));
  const auto crossover = find_crossover(meshes, &EqualError::gain);
  REQUIRE(crossover);
  CHECK_THAT(crossover->dofs, WithinRel(300.0, 1e-9));
  CHECK_THAT(crossover->true_error, WithinRel(0.9 * std::pow(3.0, -1.0 / 3.0), 1e-9));
  // With all meshes on the way, 3 (100 + ... + n) = 3 (2 n - 100): n²/100 = 6 n - 300 at n = 544.9.
  const auto with_the_way = find_crossover(meshes, &EqualError::gain_with_the_way);
  REQUIRE(with_the_way);
  CHECK_THAT(with_the_way->dofs, WithinRel(544.95, 0.02));  // the sum is no power law between two meshes

  std::vector<TjunctionCaseResult> parts(3);
  std::vector<const TjunctionCaseResult*> results;
  for (int k = 0; k < 3; ++k) {
    parts[k].refined_share = 0.1 * std::pow(2.0, k);
    parts[k].discretize_ms = 10.0 * std::pow(3.0, k);
    parts[k].costs[TjunctionHandling::elementwise] = {};
    results.push_back(&parts[k]);
  }
  CHECK_THAT(share_that_costs_the_whole(results, 30.0).value(), WithinRel(0.2, 1e-12));
  CHECK_THAT(share_that_costs_the_whole(results, 10.0 * std::sqrt(27.0)).value(),
             WithinRel(0.2 * std::sqrt(2.0), 1e-12));
  CHECK_FALSE(share_that_costs_the_whole(results, 100.0));
}
