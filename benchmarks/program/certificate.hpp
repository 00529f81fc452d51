#pragma once

#include <optional>
#include <string>

#include "core/scene/scene.hpp"

namespace finegauge {

/// Between which bounds the error lies, over the energy norm of the computed solution as η is: by the estimator's
/// effectivity on those rungs of a ladder of known errors that are of the scene's kind (effectivity_range in
/// verification/studies/estimator_kinds.hpp), and a twentieth beyond, since the rungs are not all problems. Of 179
/// meshes of 48 others in full hexahedra (wedges, blocks, plates, grooves, punches; errors below a quarter) 159 kept to
/// the rungs' range and 174 to that with the margin. The others: a sheared crack refined unevenly, flat cells beside a
/// notch or a rim, and a clamped notch under a mode that is not its sharpest.
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
