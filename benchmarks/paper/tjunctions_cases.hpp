#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "benchmarks/profile/marking_patterns.hpp"
#include "benchmarks/profile/tjunction_ledger.hpp"

namespace finegauge {

/// One mesh of the study: a cube refined in part.
struct TjunctionCase {
  std::string sweep;  ///< what it varies: share, template, mesh, levels
  MarkedCube cube;
  bool counts_only = false;  ///< too large to be factored four times
};
enum class StudySize { quick, usual, full };
std::vector<TjunctionCase> tjunction_cases(StudySize size);

struct TjunctionCaseResult {
  TjunctionCase asked;
  double refined_share = 0.0;  ///< of the base cells, after rounding to whole cells
  double discretize_ms = 0.0;  ///< processor time of mesh, T, pattern
  TjunctionCounts counts;
  TjunctionTimes times;
  std::map<TjunctionHandling, HandlingCost> costs;  ///< empty with counts_only

  /// What hanging nodes cost one frame that builds its mesh anew: T, reduction, expansion [ms].
  double overhead_ms() const { return times.build_ms + times.reduce_ms + times.expand_ms + times.gather_ms; }
  /// What solving for the nodes that do not hang saves against solving for all of them: factor and solve [ms].
  double saved_ms() const;
  /// Assembly and reduction by the explicit product over the same by elements.
  double explicit_over_elementwise() const;
  /// Discretization to displacement [ms].
  double whole_ms() const { return discretize_ms + costs.at(TjunctionHandling::elementwise).total_ms(); }
};

/// The cube of a case with all its cells refined: no node hangs.
struct ConformingCube {
  int cells_per_edge = 0;
  RefinementTemplate refinement;
  int dofs = 0;
  double whole_ms = 0.0, factor_nonzeros = 0.0;
};

TjunctionCaseResult run_case(const TjunctionCase& asked, int repetitions);
ConformingCube run_conforming(int cells_per_edge, RefinementTemplate refinement, int repetitions);

/// The share of refined cells at which the cube refined in part costs as much as the whole: between two cases, linear
/// in the logarithms of cost and share. `results` of one pattern and mesh, by rising share. None where the part stays
/// cheaper up to the largest share (or is dearer from the smallest on).
std::optional<double> share_that_costs_the_whole(const std::vector<const TjunctionCaseResult*>& results,
                                                 double whole_ms);

Json to_json(const TjunctionCaseResult& result);

}  // namespace finegauge
