#include "benchmarks/program/motion_output.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "benchmarks/program/atomic_file.hpp"
#include "benchmarks/program/mesh_picture.hpp"
#include "benchmarks/program/plots.hpp"
#include "benchmarks/program/vtu_writer.hpp"
#include "core/mesh/immersed_body.hpp"

namespace finegauge {
namespace {

std::string with_unit(const std::string& words, const char* unit, bool dimensionless) {
  return dimensionless ? words : words + " [" + unit + "]";
}

}  // namespace

MotionFiles::MotionFiles(std::filesystem::path directory, const Scene& scene, int vtu_every)
    : directory_(std::move(directory)), scene_(scene), vtu_every_(vtu_every) {
  if (scene.needle) sections_.emplace(scene);
}

const std::vector<MaterialPoint>& MotionFiles::surface_points(const BaseMesh& base) {
  if (base.body && surface_points_.empty()) surface_points_ = points_of_surface(base, base.body->surface);
  return surface_points_;
}

void MotionFiles::add_frame(const MotionView& view, bool last) {
  const FrameReport& report = view.frame.report.frame;
  largest_elastic_energy_ = std::max(largest_elastic_energy_, report.energy.elastic);
  const bool vtu = vtu_every_ > 0 && (last || report.frame % vtu_every_ == 0);
  const auto moments = sections_ ? sections_->moments_of(view, last) : std::vector<SectionMoment>{};
  if (!vtu && !last && moments.empty()) return;
  // The frame's estimate belongs to the mesh that it was solved on; what is drawn is the mesh after it.
  const Tissue& tissue = view.tissue;
  const bool current = report.eta.has_value() && report.refined == 0 && report.coarsened == 0;
  const ErrorEstimate estimate =
      current ? tissue.estimate : estimate_error(tissue.mesh.d, tissue.state.u, scene_.estimator);
  if (vtu) add_vtu(view, estimate);
  for (const SectionMoment& moment : moments)
    for (const auto& [file, svg] :
         section_pictures(scene_, *view.insertion, estimate, surface_points(tissue.forest.base()), moment))
      write_file_atomically(directory_ / file, svg);
  if (last) draw_mesh(view, estimate);
}

void MotionFiles::add_vtu(const MotionView& view, const ErrorEstimate& estimate) {
  const FrameReport& report = view.frame.report.frame;
  const Discretization& d = view.tissue.mesh.d;
  VtuFields fields = vtu_fields(d, view.tissue.state.u, estimate);
  fields.velocity = view.tissue.state.v;
  if (series_.empty())  // of an earlier run
    for (const char* series : {"", "_needle", "_surface"}) remove_vtu_series(directory_, scene_.name + series);
  const std::string name = vtu_series_file(scene_.name, report.frame);
  write_vtu(directory_ / name, d.mesh, d.hanging, fields);
  series_.emplace_back(report.time, name);
  write_pvd(directory_ / (scene_.name + ".pvd"), series_);
  if (const BaseMesh& base = view.tissue.forest.base(); base.body) {
    const TriangleSurface& rest = base.body->surface;
    const TriangleSurface surface =
        carried_surface(rest, surface_points(base), view.tissue.forest, d.mesh, view.tissue.state.u);
    const std::string file = vtu_series_file(scene_.name + "_surface", report.frame);
    write_surface_vtu(directory_ / file, surface, surface.vertices - rest.vertices);
    surface_series_.emplace_back(report.time, file);
    write_pvd(directory_ / (scene_.name + "_surface.pvd"), surface_series_);
  }
  if (!view.insertion) return;
  const std::string needle = vtu_series_file(scene_.name + "_needle", report.frame);
  write_curve_vtu(directory_ / needle, view.insertion->needle.positions);
  needle_series_.emplace_back(report.time, needle);
  write_pvd(directory_ / (scene_.name + "_needle.pvd"), needle_series_);
}

void MotionFiles::draw_mesh(const MotionView& view, const ErrorEstimate& estimate) const {
  const Mesh& mesh = view.tissue.mesh.d.mesh;
  Eigen::VectorXd stress(mesh.node_count());
  for (int i = 0; i < mesh.node_count(); ++i) stress[i] = von_mises(estimate.nodal_stress.col(i));
  const FrameReport& report = view.frame.report.frame;
  const bool at_rest = report.energy.elastic < energy_at_rest * largest_elastic_energy_;
  if (at_rest) stress.setZero();
  MeshPictureOptions options;
  char time[60];
  std::snprintf(time, sizeof time, ", t = %.4g%s%s", report.time, scene_.dimensionless ? "" : " s",
                at_rest ? ", at rest" : "");
  options.title = scene_.name + time;
  options.quantity = "von Mises stress";
  options.unit = scene_.dimensionless ? "" : "Pa";
  options.deformation_scale = 1.0;  // a needle would not meet a body drawn larger than it deforms
  if (view.insertion) options.curve = view.insertion->needle.positions;
  write_file_atomically(directory_ / (scene_.name + "_mesh.svg"),
                        mesh_picture_svg(mesh, stress, view.tissue.state.u, options));
}

std::vector<std::string> draw_motion(const Scene& scene, const MotionRun& run, const std::filesystem::path& directory) {
  std::vector<std::string> notes;
  const auto draw = [&](const Plot& plot) {
    if (const PlotReport report = draw_plot(plot, directory); !report.written) notes.push_back(report.why_not);
  };
  Plot plot;
  plot.log_x = plot.log_y = false;
  if (scene.needle) {
    plot.file = scene.name + "_force.svg";
    plot.title = scene.name + ": force over tip displacement";
    plot.x_label = with_unit("travel of the tip since first touch", "m", scene.dimensionless);
    plot.y_label = with_unit("axial force between needle and tissue", "N", scene.dimensionless);
    PlotSeries force{"force", {}, {}}, tip{"tip", {}, {}};
    for (const MotionFrame& frame : run.frames) {
      force.x.push_back(frame.report.tip_displacement), force.y.push_back(frame.report.force);
      tip.x.push_back(frame.report.tip_displacement), tip.y.push_back(frame.report.tip_force);
    }
    plot.series = {force, tip};
    draw(plot);
  }
  plot.file = scene.name + "_dofs.svg";
  plot.title = scene.name + ": degrees of freedom over time";
  plot.x_label = with_unit("time", "s", scene.dimensionless);
  plot.y_label = "degrees of freedom (3 × nodes that do not hang)";
  PlotSeries dofs{"dofs", {}, {}};
  for (const MotionFrame& frame : run.frames)
    dofs.x.push_back(frame.report.frame.time), dofs.y.push_back(frame.report.frame.dofs);
  plot.series = {dofs};
  draw(plot);
  return notes;
}

}  // namespace finegauge
