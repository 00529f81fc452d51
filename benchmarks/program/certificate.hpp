#pragma once

#include <optional>
#include <string>

#include "core/scene/scene.hpp"

namespace finegauge {

/// Between which bounds the error lies, over the energy norm of the computed solution as η is: by the estimator's
/// effectivity on those rungs of a ladder of known errors that are of the scene's kind (effectivity_range in
/// verification/studies/estimator_kinds.hpp), and a twentieth beyond, since the rungs are not all problems. What that
/// is worth off the ladder is a study of its own (verification/studies/holdout.hpp): of 99 meshes of 28 other problems
/// that get a range (errors below a quarter) 95 keep to the rungs' range and all to that with the margin; of 16 of 4
/// that were drawn blind all to both. Two refusals were made after that study's first look, which found 6 of 138
/// outside: cells twice as long as wide or more at a notch or a rim, and a load on a face between clamped ones.
struct CertifiedRange {
  double low, high;
};
/// None where no rung of the ladder is like the scene, its solve did not converge, the estimate is above 50 % (30 %
/// where supports move the body, it turns or it moves), or zero, as of a body that nothing deforms.
std::optional<CertifiedRange> certified_range(const Scene& scene, double eta, bool converged);
/// Which of these it is, and which part of the scene; empty where a range is given.
std::string why_uncertified(const Scene& scene, double eta, bool converged);

/// "between 7.2 % and 8.7 % (...)", with the rungs that it rests on, or "not certified: ...".
std::string certificate_text(const Scene& scene, double eta, bool converged);

}  // namespace finegauge
