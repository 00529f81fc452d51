#include "benchmarks/program/certificate.hpp"

#include <algorithm>
#include <cstdio>

namespace finegauge {

namespace {

constexpr double margin = 1.05;

std::string why_geometry(const Scene& scene) {
  if (std::holds_alternative<BaseMesh>(scene.geometry)) return "is in a box";  // imported meshes and organs
  const auto& box = std::get<BoxMeshOptions>(scene.geometry);
  if (box.shape == CellShape::tetrahedron) return "has hexahedra";
  if (*std::min_element(box.cells.begin(), box.cells.end()) < 2) return "has two cells or more along each axis";
  return "";
}

}  // namespace

std::string why_uncertified(const Scene& scene) {
  if (scene.estimator != Estimator::spr_edges) return "the plain estimator misses up to a third at notches and rims";
  const Material& material = scene.material;
  std::string known = why_geometry(scene);
  if (scene.needle)
    known = "has no needle";
  else if (scene.dynamics)
    known = "is at rest";
  else if (material.kinematics != Kinematics::linear)
    known = "is linear";
  else if (material.dilatation == Dilatation::standard && material.poisson_ratio > 0.4)
    known = "has a Poisson ratio of at most 0.4, or the mean dilatation";
  else if (!scene.attachments.empty())
    known = "is held on surfaces";
  for (const SurfaceLoad& load : scene.loads)
    if (load.kind == LoadKind::total_by_node) known = "is loaded by tractions";
  return known.empty() ? "" : "the error is known where a problem " + known;
}

std::optional<CertifiedRange> certified_range(const Scene& scene, double eta, bool converged) {
  if (!converged || !why_uncertified(scene).empty()) return {};
  return CertifiedRange{eta / (margin * certified_effectivity.high), eta * margin / certified_effectivity.low};
}

std::string certificate_text(const Scene& scene, double eta, bool converged) {
  const std::optional<CertifiedRange> range = certified_range(scene, eta, converged);
  if (!range) return "not certified: " + (converged ? why_uncertified(scene) : "the solve did not converge");
  char text[64];
  std::snprintf(text, sizeof text, "between %.3g %% and %.3g %%", 100.0 * range->low, 100.0 * range->high);
  return std::string(text) +
         " of the solution's energy norm (rests on smooth fields, notches, cracks and clamped rims, regular, "
         "perturbed, "
         "flat and hanging cells, nu to 0.4999: finegauge verify estimator)";
}

}  // namespace finegauge
