#pragma once

#include <optional>
#include <string>

#include "core/scene/scene.hpp"

namespace finegauge {

/// Between which bounds the error lies, over the energy norm of the computed solution as η is: by the estimator's
/// effectivity on a ladder of problems with known errors (certified_effectivity in core/adapt/error_estimate.hpp), and
/// a twentieth beyond, since the ladder's rungs are not all problems.
struct CertifiedRange {
  double low, high;
};
/// None where no rung of the ladder is like the scene, or its solve did not converge; `why_uncertified` says which part
/// of the scene it is.
std::optional<CertifiedRange> certified_range(const Scene& scene, double eta, bool converged);
std::string why_uncertified(const Scene& scene);  ///< empty where a range is given

/// "between 7.2 % and 8.7 % (...)", with the rungs that it rests on, or "not certified: ...".
std::string certificate_text(const Scene& scene, double eta, bool converged);

}  // namespace finegauge
