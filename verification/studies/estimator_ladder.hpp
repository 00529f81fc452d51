#pragma once

#include <map>
#include <string>
#include <vector>

#include "verification/studies/estimator_rungs.hpp"
#include "verification/support/evidence.hpp"

namespace finegauge {

/// Problems whose true error is known, and what each estimator makes of it.
///
/// Estimators: `spr`, the paper's; `spr_edges`, which recovers twice over and weighs the cells at singular edges and is
/// what scenes use; and `equilibrated` (core/equilibrated_estimate.hpp), which is meant never to be below the error.
/// These rungs are of linear strains in hexahedra full of material; estimator_kinds.hpp has the others.

/// Of one estimator on one rung.
struct Effectivity {
  double global = 0.0;                    ///< estimated over true error, both absolute
  double p5 = 0.0, p50 = 0.0, p95 = 0.0;  ///< over cells; zero where only the energy is known
  double at_front = 0.0;                  ///< of the cells with a hanging corner; zero without
  double microseconds_per_cell = 0.0;
};

struct LadderRow {
  std::string rung;
  int cells = 0, dofs = 0, hanging_nodes = 0;
  double true_error = 0.0;  ///< relative
  std::map<std::string, Effectivity> of;
};

/// Solves a rung and estimates. Throws std::runtime_error when the solve fails.
LadderRow climb(LadderRung& rung);

/// The estimate of one corotational state, turned by angles from 10 to 180 degrees: the largest relative change of η
/// and of η_e. And of one problem in metres and millimetres: the largest relative change of anything dimensionless.
double largest_change_under_rotation();
double largest_change_under_units();

Evidence estimator_ladder_evidence(const EvidenceOptions& options);

}  // namespace finegauge
