#include "benchmarks/program/certificate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
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

constexpr std::array<std::array<const char*, 2>, 3> faces = {
    {{"x_min", "x_max"}, {"y_min", "y_max"}, {"z_min", "z_max"}}};

bool is_clamped(const Scene& scene, const char* face) {
  return std::ranges::any_of(scene.supports, [&](const SceneSupport& support) {
    return support.surface == face && !support.normal && (support.components.empty() || support.components.size() == 3);
  });
}

/// Whether a singular edge may see cells that are twice as long as wide: across the rim of a clamped face, or across
/// the edge of a notch.
bool has_stretched_edge(const Scene& scene, const BoxMeshOptions& box) {
  const auto stretched = [&](std::size_t a, std::size_t b) {
    const double ratio = (box.size[static_cast<Eigen::Index>(a)] / box.cells[a]) /
                         (box.size[static_cast<Eigen::Index>(b)] / box.cells[b]);
    constexpr double twice = 2.0 - 1e-9;
    return std::max(ratio, 1.0 / ratio) >= twice;
  };
  const auto ends_inside = [&](std::size_t axis) {
    return box.removed && (box.removed->first[axis] > 0 || box.removed->last[axis] < box.cells[axis]);
  };
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t b = (a + 1) % 3, c = (a + 2) % 3;
    if (ends_inside(a) && ends_inside(b) && stretched(a, b)) return true;
    if ((is_clamped(scene, faces[a][0]) || is_clamped(scene, faces[a][1])) && (stretched(a, b) || stretched(a, c)))
      return true;
  }
  return false;
}

/// Whether opposite faces are clamped and one beside them is loaded.
bool is_pressed_between(const Scene& scene) {
  for (std::size_t a = 0; a < 3; ++a)
    if (is_clamped(scene, faces[a][0]) && is_clamped(scene, faces[a][1]))
      for (const SurfaceLoad& load : scene.loads)
        if (load.surface != faces[a][0] && load.surface != faces[a][1]) return true;
  return false;
}

/// What the problems with a known error are and the scene is not; empty where it is. Their loads end at edges: where
/// one ends inside of a face the stress jumps there, and the estimate is a fifth too small.
std::string what_is_missing(const Scene& scene) {
  const auto& box = std::get<BoxMeshOptions>(scene.geometry);
  const Material& material = scene.material;
  if (box.shape == CellShape::tetrahedron && (scene.dynamics || material.kinematics != Kinematics::linear))
    return "has hexahedra, or linear kinematics and is at rest";
  if (*std::min_element(box.cells.begin(), box.cells.end()) < 2) return "has two cells or more along each axis";
  if (box.shape == CellShape::tetrahedron && material.poisson_ratio > 0.35)
    return "has hexahedra, or a Poisson ratio of at most 0.35, above which tetrahedra lock";
  if (material.dilatation == Dilatation::standard && material.poisson_ratio > 0.45)
    return "has a Poisson ratio of at most 0.45, or the mean dilatation";
  if (!scene.attachments.empty()) return "is held on surfaces";
  for (const SurfaceLoad& load : scene.loads) {
    if (load.kind == LoadKind::total_by_node) return "is loaded by tractions";
    const auto surface = std::ranges::find(scene.surfaces, load.surface, &SurfaceDefinition::name);
    if (surface != scene.surfaces.end() && surface->normal.isZero()) return "is loaded on whole faces";
  }
  if (box.shape == CellShape::hexahedron && has_stretched_edge(scene, box))
    return "has cells less than twice as long as wide where it is clamped or notched";
  if (is_pressed_between(scene)) return "is not loaded on a face between clamped ones";
  return "";
}

std::string what_is_not_of_a_rung(const Scene& scene) {
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

/// Under loads alone what a coarse body lacks of its amplitude is part of the estimate, up to bent rungs that are half
/// wrong and more; elsewhere few rungs are as coarse.
double largest_estimate(const Scene& scene) {
  const bool is_moved = std::ranges::any_of(scene.supports, [](const SceneSupport& support) {
    return !support.displacement.isZero(0.0) || !support.gradient.isZero(0.0);
  });
  return is_moved || scene.dynamics || scene.material.kinematics == Kinematics::corotational ? 0.3 : 0.5;
}

}  // namespace

std::string why_uncertified(const Scene& scene, double eta, bool converged) {
  if (!converged) return "the solve did not converge";
  if (const std::string why = what_is_not_of_a_rung(scene); !why.empty()) return why;
  if (const double largest = largest_estimate(scene); eta > largest)
    return "the estimate is above " + std::to_string(std::lround(100.0 * largest)) +
           " %, where so coarse a body may lack more than it shows";
  return eta > 0.0 ? "" : "the estimate is zero, and a range is a multiple of it";
}

std::optional<CertifiedRange> certified_range(const Scene& scene, double eta, bool converged) {
  if (!why_uncertified(scene, eta, converged).empty()) return {};
  const std::optional<EffectivityRange> range = effectivity_range(kind_of(scene));
  if (!range) return {};
  return CertifiedRange{eta / (certificate_margin * range->high), eta * certificate_margin / range->low};
}

std::string certificate_text(const Scene& scene, double eta, bool converged) {
  const std::optional<CertifiedRange> range = certified_range(scene, eta, converged);
  if (!range) return "not certified: " + why_uncertified(scene, eta, converged);
  char text[64];
  std::snprintf(text, sizeof text, "between %.3g %% and %.3g %%", 100.0 * range->low, 100.0 * range->high);
  return std::string(text) + " of the solution's energy norm (rests on " + rungs_of(kind_of(scene)) +
         ": finegauge verify estimator)";
}

}  // namespace finegauge
