#include "benchmarks/program/needle_sections.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "benchmarks/program/section_picture.hpp"
#include "core/adapt/frame_adaptivity.hpp"
#include "core/mesh/immersed_body.hpp"

namespace finegauge {
namespace {

/// The first frame in which the base has made the strokes up to the one after which it is farthest along the needle.
int deepest_frame(const SceneNeedle& needle, double time_step) {
  const Eigen::Vector3d axis = (needle.tip - needle.base).normalized();
  Eigen::Vector3d displacement = Eigen::Vector3d::Zero();
  double time = 0.0, deepest_time = 0.0, farthest = 0.0;
  for (const Stroke& stroke : needle.drive.strokes) {
    displacement += stroke.displacement;
    time += stroke.duration;
    // By more than round-off: a stroke there and back does not pass for an advance.
    if (displacement.dot(axis) <= farthest + 1e-12 * displacement.norm()) continue;
    farthest = displacement.dot(axis);
    deepest_time = time;
  }
  return static_cast<int>(std::ceil(deepest_time / time_step - 1e-6));
}

SectionPlane plane_of(const SceneNeedle& needle) {
  const Eigen::Vector3d axis = (needle.tip - needle.base).normalized();
  return plane_along(needle.base, axis, std::abs(axis.z()) > 0.9 ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ());
}

std::string length_text(double length, bool dimensionless) {
  char text[40];
  if (dimensionless)
    std::snprintf(text, sizeof text, "%.4g", length);
  else
    std::snprintf(text, sizeof text, "%.1f mm", 1e3 * length);
  return text;
}

/// Divides by the power of a thousand that leaves short numbers; its SI prefix.
std::string scale_to_prefix(Eigen::VectorXd& values) {
  const double largest = values.size() > 0 ? values.maxCoeff() : 0.0;
  const auto& [power, prefix] = largest >= 1e6   ? std::pair{1e6, "M"}
                                : largest >= 1e3 ? std::pair{1e3, "k"}
                                                 : std::pair{1.0, ""};
  values /= power;
  return prefix;
}

}  // namespace

NeedleSections::NeedleSections(const Scene& scene)
    : deepest_frame_(deepest_frame(scene.needle.value(), scene.dynamics.value().time_step)) {}

std::vector<SectionMoment> NeedleSections::moments_of(const MotionView& view, bool last) {
  if (view.frame.report.frame.eta)
    largest_energy_norm_ = std::max(largest_energy_norm_, view.tissue.estimate.energy_norm);
  std::vector<SectionMoment> moments;
  const auto add = [&](const char* stage) {
    moments.push_back({stage, view.frame.report.insertion_depth, largest_energy_norm_});
  };
  if (!started_) add("start");
  started_ = true;
  if (!deepest_drawn_ && (last || view.frame.report.frame.frame >= deepest_frame_)) {
    add("depth");
    deepest_drawn_ = true;
  }
  if (last) add("end");
  return moments;
}

std::vector<std::pair<std::string, std::string>> section_pictures(const Scene& scene, const Insertion& insertion,
                                                                  const ErrorEstimate& estimate,
                                                                  const std::vector<MaterialPoint>& surface_points,
                                                                  const SectionMoment& moment) {
  const Tissue& tissue = insertion.tissue;
  const Discretization& d = tissue.mesh.d;
  SectionPictureOptions options;
  options.plane = plane_of(scene.needle.value());
  options.dimensionless = scene.dimensionless;
  options.needle = insertion.needle.positions;
  options.needle_radius = scene.needle->properties.radius;
  if (const BaseMesh& base = tissue.forest.base(); base.body)
    options.outline = section_of_surface(
        carried_surface(base.body->surface, surface_points, tissue.forest, d.mesh, tissue.state.u), options.plane);
  char time[60];
  std::snprintf(time, sizeof time, ": t = %.4g%s, ", tissue.time, scene.dimensionless ? "" : " s");
  const std::string inserted =
      moment.depth > 0.0 ? length_text(moment.depth, scene.dimensionless) + " inserted" : "needle outside";
  options.title = scene.name + ", " + (moment.stage == "depth" ? "full depth" : moment.stage) + time + inserted;
  const double norm = estimate.energy_norm, largest_norm = std::max(moment.largest_energy_norm, norm);
  const bool at_rest = norm * norm <= energy_at_rest * largest_norm * largest_norm;
  char eta[40];
  std::snprintf(eta, sizeof eta, "η = %.3g %%", 100.0 * estimate.relative);
  options.note = at_rest ? "at rest" : eta;
  if (at_rest) options.resolution = std::numeric_limits<double>::infinity();

  const std::string name = scene.name + "_" + moment.stage;
  std::vector<std::pair<std::string, std::string>> pictures;
  Eigen::VectorXd stress = cell_von_mises(d, tissue.state.u);
  options.unit = "";
  if (!scene.dimensionless) options.unit = scale_to_prefix(stress) + "Pa";
  pictures.emplace_back(name + "_stress.svg", section_picture_svg(d.mesh, tissue.state.u, stress, options));
  // A body without energy has no error.
  const Eigen::VectorXd relative = largest_norm > 0.0 ? Eigen::VectorXd(100.0 / largest_norm * estimate.eta)
                                                      : Eigen::VectorXd::Zero(estimate.eta.size());
  options.quantity = "error of a cell, η_e";
  options.unit = "% of largest energy norm";
  pictures.emplace_back(name + "_eta.svg", section_picture_svg(d.mesh, tissue.state.u, relative, options));
  return pictures;
}

}  // namespace finegauge
