#pragma once

#include <functional>
#include <string>

#include "benchmarks/paper/lshape_problem.hpp"
#include "benchmarks/program/result_document.hpp"

namespace finegauge {

/// The L-shape's uniform mesh of 42,483 dofs solved in two ways in turn, medians over the passes [ms].
struct DirectComparison {
  int dofs = 0;
  double multigrid_ms = 0.0;       ///< assembly, coarse meshes, set-up, conjugate gradients to a true residual of 1e-6
  double direct_ms = 0.0;          ///< CHOLMOD: analyze + factor + solve of the same matrix, assembly not counted
  double topology_ms = 0.0;        ///< mesh, T and patterns of that mesh, without the hierarchy
  double relative_residual = 0.0;  ///< the true one of conjugate gradients
  int iterations = 0;

  double ratio() const { return multigrid_ms / direct_ms; }
};
DirectComparison compare_with_direct(const LshapeOptions& problem, int passes,
                                     const std::function<void(double, const std::string&)>& progress);
Json to_json(const DirectComparison& comparison);

}  // namespace finegauge
