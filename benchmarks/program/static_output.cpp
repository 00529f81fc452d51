#include "benchmarks/program/static_output.hpp"

#include <algorithm>
#include <cstdio>
#include <span>

#include "benchmarks/program/atomic_file.hpp"
#include "benchmarks/program/certificate.hpp"
#include "benchmarks/program/mesh_picture.hpp"
#include "benchmarks/program/plots.hpp"
#include "benchmarks/program/sha256.hpp"
#include "benchmarks/program/vtu_writer.hpp"

namespace finegauge {
namespace {

Json start_max_end(const std::vector<StaticStep>& steps, auto StaticStep::*member) {
  auto largest = steps.front().*member;
  for (const StaticStep& step : steps) largest = std::max(largest, step.*member);
  return {{"start", steps.front().*member}, {"max", largest}, {"end", steps.back().*member}};
}

std::string quantity_text(const QuantityOfInterest& quantity, const Json& value, bool dimensionless) {
  std::string text;
  const auto add = [&](double number) {
    char digits[48];
    std::snprintf(digits, sizeof digits, "%s%.10g", text.empty() ? "" : ", ", number);
    text += digits;
  };
  if (quantity.kind == QuantityKind::energy) {
    add(value.get<double>());
    // The table's energy is half of it; without a word the two look like a contradiction.
    return text + (dimensionless ? "" : " J") + " (integral of strain : stress, twice the strain energy)";
  }
  for (const Json& component : value) add(component.get<double>());
  return "[" + text + "]" + (dimensionless ? "" : " m");
}

}  // namespace

StaticFiles::StaticFiles(std::filesystem::path directory, const Scene& scene, int vtu_every)
    : directory_(std::move(directory)), scene_(scene), vtu_every_(vtu_every) {}

void StaticFiles::add_step(const StaticView& view, bool last) {
  if (vtu_every_ > 0 && (last || view.step.step % vtu_every_ == 0)) add_vtu(view);
  if (last) draw_mesh(view);
}

void StaticFiles::add_vtu(const StaticView& view) {
  if (series_.empty()) remove_vtu_series(directory_, scene_.name);
  const std::string name = vtu_series_file(scene_.name, view.step.step);
  write_vtu(directory_ / name, view.discretization.mesh, view.discretization.hanging,
            vtu_fields(view.discretization, view.u, view.estimate));
  series_.emplace_back(view.step.step, name);
  write_pvd(directory_ / (scene_.name + ".pvd"), series_);
}

void StaticFiles::draw_mesh(const StaticView& view) const {
  const Mesh& mesh = view.discretization.mesh;
  Eigen::VectorXd stress(mesh.node_count());
  for (int i = 0; i < mesh.node_count(); ++i) stress[i] = von_mises(view.estimate.nodal_stress.col(i));
  MeshPictureOptions options;
  options.title = scene_.name + ", step " + std::to_string(view.step.step);
  options.quantity = "von Mises stress";
  options.unit = scene_.dimensionless ? "" : "Pa";
  options.deformation_scale = suggested_deformation_scale(mesh, view.u);
  write_file_atomically(directory_ / (scene_.name + "_mesh.svg"), mesh_picture_svg(mesh, stress, view.u, options));
}

Json summarize(const StaticRun& run) {
  const std::vector<StaticStep>& steps = run.steps;
  double iterations = 0.0;
  int unconverged = 0;
  for (const StaticStep& step : steps) iterations += step.iterations, unconverged += !step.converged;
  Json summary;
  summary["steps"] = steps.size();
  summary["dofs"] = start_max_end(steps, &StaticStep::dofs);
  summary["cells"] = start_max_end(steps, &StaticStep::cells);
  summary["hanging_nodes"] = {{"max", start_max_end(steps, &StaticStep::hanging_nodes)["max"]}};
  summary["eta"] = start_max_end(steps, &StaticStep::eta);
  summary["refined"] = run.refined;
  summary["coarsened"] = 0;
  summary["solver_iterations"] = {{"mean", iterations / static_cast<double>(steps.size())},
                                  {"max", start_max_end(steps, &StaticStep::iterations)["max"]}};
  summary["unconverged_frames"] = unconverged;
  summary["strain_energy"] = steps.back().strain_energy;
  if (!steps.back().quantities.empty()) summary["quantities"] = steps.back().quantities;
  summary["stopped_because"] = run.stopped_because;
  summary["peak_memory_mb"] = peak_memory_mb();
  summary["state_sha256"] = sha256(std::as_bytes(std::span(run.u.data(), static_cast<std::size_t>(run.u.size()))));
  return summary;
}

std::optional<std::string> draw_error(const StaticRun& run, const std::string& name,
                                      const std::filesystem::path& directory) {
  if (run.steps.size() < 2) return {};
  Plot plot;
  plot.file = name + "_eta.svg";
  plot.title = name + ": estimated error over degrees of freedom";
  plot.x_label = "degrees of freedom (3 × nodes that do not hang)";
  plot.y_label = "estimated relative error η (energy norm)";
  PlotSeries series{"η", {}, {}, PlotLine::joined_with_slope};
  for (const StaticStep& step : run.steps) series.x.push_back(step.dofs), series.y.push_back(step.eta);
  plot.series = {series};
  const PlotReport report = draw_plot(plot, directory);
  if (report.written) return {};
  return report.why_not;
}

void print_steps(const Scene& scene, const StaticRun& run, const std::vector<std::string>& notes) {
  std::printf("%5s %9s %9s %9s %9s %9s %6s %17s %10s\n", "step", "cells", "nodes", "hanging", "dofs", "eta [%]", "iter",
              scene.dimensionless ? "strain energy" : "strain energy [J]", "total [ms]");
  for (const StaticStep& s : run.steps)
    std::printf("%5d %9d %9d %9d %9d %9.3f %6d %17.10g %10.1f%s\n", s.step, s.cells, s.nodes, s.hanging_nodes, s.dofs,
                100.0 * s.eta, s.iterations, s.strain_energy, s.total_ms, s.converged ? "" : "  NOT CONVERGED");
  for (const QuantityOfInterest& quantity : scene.quantities)
    std::printf("%s = %s\n", quantity.name.c_str(),
                quantity_text(quantity, run.steps.back().quantities.at(quantity.name), scene.dimensionless).c_str());
  std::printf("error at the end: %s\n",
              certificate_text(scene, run.steps.back().eta, run.steps.back().converged).c_str());
  std::printf("stopped: %s\n", run.stopped_because.c_str());
  for (const std::string& note : notes) std::printf("note: %s\n", note.c_str());
  std::fflush(stdout);
}

}  // namespace finegauge
