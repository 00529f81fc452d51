#include "benchmarks/program/certificate.hpp"

#include <algorithm>
#include <cstdio>

#include "verification/studies/estimator_kinds.hpp"

namespace finegauge {

namespace {

/// Of a scene without a needle, in a box.
ProblemKind kind_of(const Scene& scene) {
  if (scene.dynamics) return ProblemKind::moving;
  if (scene.material.kinematics == Kinematics::corotational) return ProblemKind::rotated;
  return std::get<BoxMeshOptions>(scene.geometry).shape == CellShape::tetrahedron ? ProblemKind::tetrahedra
                                                                                  : ProblemKind::hexahedra;
}

/// What the problems with a known error are and the scene is not; empty where it is. Their loads end at edges: where
/// one ends inside of a face the stress jumps there, and the estimate is a fifth too small.
std::string what_is_missing(const Scene& scene) {
  const auto& box = std::get<BoxMeshOptions>(scene.geometry);
  const Material& material = scene.material;
  if (box.shape == CellShape::tetrahedron && (scene.dynamics || material.kinematics != Kinematics::linear))
    return "has hexahedra, or linear kinematics and is at rest";
  if (*std::min_element(box.cells.begin(), box.cells.end()) < 2) return "has two cells or more along each axis";
  if (material.dilatation == Dilatation::standard && material.poisson_ratio > 0.45)
    return "has a Poisson ratio of at most 0.45, or the mean dilatation";
  if (!scene.attachments.empty()) return "is held on surfaces";
  for (const SurfaceLoad& load : scene.loads) {
    if (load.kind == LoadKind::total_by_node) return "is loaded by tractions";
    const auto surface = std::ranges::find(scene.surfaces, load.surface, &SurfaceDefinition::name);
    if (surface != scene.surfaces.end() && surface->normal.isZero()) return "is loaded on whole faces";
  }
  return "";
}

}  // namespace

std::string why_uncertified(const Scene& scene) {
  if (scene.estimator != Estimator::spr_edges) return "the plain estimator misses up to a third at notches and rims";
  if (scene.needle)
    return "a needle's forces act on lines and points, where the exact solution has no finite energy and so the "
           "estimate no true error (finegauge verify estimator: the energy rises with every halving of the cells)";
  if (const auto* mesh = std::get_if<BaseMesh>(&scene.geometry))
    return mesh->body ? "the error is known where a problem is held on surfaces: that of cut cells is, not that at the "
                        "rim of what is held inside of a body"
                      : "the error is known where a problem is in a box";
  const std::string missing = what_is_missing(scene);
  return missing.empty() ? "" : "the error is known where a problem " + missing;
}

std::optional<CertifiedRange> certified_range(const Scene& scene, double eta, bool converged) {
  if (!converged || !why_uncertified(scene).empty()) return {};
  const std::optional<EffectivityRange> range = effectivity_range(kind_of(scene));
  if (!range) return {};
  return CertifiedRange{eta / (certificate_margin * range->high), eta * certificate_margin / range->low};
}

std::string certificate_text(const Scene& scene, double eta, bool converged) {
  const std::optional<CertifiedRange> range = certified_range(scene, eta, converged);
  if (!range) return "not certified: " + (converged ? why_uncertified(scene) : "the solve did not converge");
  char text[64];
  std::snprintf(text, sizeof text, "between %.3g %% and %.3g %%", 100.0 * range->low, 100.0 * range->high);
  return std::string(text) + " of the solution's energy norm (rests on " + rungs_of(kind_of(scene)) +
         ": finegauge verify estimator)";
}

}  // namespace finegauge
