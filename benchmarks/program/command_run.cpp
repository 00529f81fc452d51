#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>

#include "benchmarks/program/atomic_file.hpp"
#include "benchmarks/program/command.hpp"
#include "benchmarks/program/interrupt.hpp"
#include "benchmarks/program/mesh_picture.hpp"
#include "benchmarks/program/plots.hpp"
#include "benchmarks/program/sha256.hpp"
#include "benchmarks/program/static_run.hpp"
#include "benchmarks/program/vtu_writer.hpp"
#include "core/scene/scene_reader.hpp"

namespace finegauge {
namespace {

constexpr int quick_dofs = 20000;  // a solve of this size takes about a second, and a loop up to it a few

/// Writes what a user can look at while the loop goes on, and keeps what the pictures at its end need.
class RunFiles {
 public:
  RunFiles(std::filesystem::path directory, const Scene& scene, int vtu_every)
      : directory_(std::move(directory)), scene_(scene), vtu_every_(vtu_every) {}

  void add_step(const StaticView& view, bool last) {
    if (vtu_every_ > 0 && (last || view.step.step % vtu_every_ == 0)) add_vtu(view);
    if (last) draw_mesh(view);
  }

 private:
  void add_vtu(const StaticView& view) {
    if (series_.empty()) remove_vtu_series(directory_, scene_.name);
    const std::string name = vtu_series_file(scene_.name, view.step.step);
    write_vtu(directory_ / name, view.discretization.mesh, view.discretization.hanging,
              vtu_fields(view.discretization, view.u, view.estimate));
    series_.emplace_back(view.step.step, name);
    write_pvd(directory_ / (scene_.name + ".pvd"), series_);
  }

  void draw_mesh(const StaticView& view) const {
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

  std::filesystem::path directory_;
  const Scene& scene_;
  int vtu_every_;
  std::vector<std::pair<double, std::string>> series_;
};

/// Share of the work done, when the cost of a step goes on growing as it did so far.
double estimated_fraction(const std::vector<double>& step_ms, int steps_left) {
  double done = 0.0, left = 0.0;
  for (const double ms : step_ms) done += ms;
  const double steps = static_cast<double>(step_ms.size() - 1),
               ratio = step_ms.back() / std::max(step_ms.front(), 1e-3);
  const double growth = steps > 0.0 ? std::clamp(std::pow(ratio, 1.0 / steps), 1.0, 8.0) : 2.0;
  double next = step_ms.back();
  for (int k = 0; k < steps_left; ++k) left += next *= growth;
  return done / (done + left);
}

Json start_max_end(const std::vector<StaticStep>& steps, auto StaticStep::*member) {
  auto largest = steps.front().*member;
  for (const StaticStep& step : steps) largest = std::max(largest, step.*member);
  return {{"start", steps.front().*member}, {"max", largest}, {"end", steps.back().*member}};
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
  PlotSeries series{"η", {}, {}};
  for (const StaticStep& step : run.steps) series.x.push_back(step.dofs), series.y.push_back(step.eta);
  plot.series = {series};
  const PlotReport report = draw_plot(plot, directory);
  if (report.written) return {};
  return report.why_not;
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

void print_steps(const Scene& scene, const StaticRun& run, const std::vector<std::string>& notes) {
  std::printf("%5s %9s %9s %9s %9s %9s %6s %17s %10s\n", "step", "cells", "nodes", "hanging", "dofs", "eta [%]", "iter",
              scene.dimensionless ? "strain energy" : "strain energy [J]", "total [ms]");
  for (const StaticStep& s : run.steps)
    std::printf("%5d %9d %9d %9d %9d %9.3f %6d %17.10g %10.1f%s\n", s.step, s.cells, s.nodes, s.hanging_nodes, s.dofs,
                100.0 * s.eta, s.iterations, s.strain_energy, s.total_ms, s.converged ? "" : "  NOT CONVERGED");
  for (const QuantityOfInterest& quantity : scene.quantities)
    std::printf("%s = %s\n", quantity.name.c_str(),
                quantity_text(quantity, run.steps.back().quantities.at(quantity.name), scene.dimensionless).c_str());
  std::printf("stopped: %s\n", run.stopped_because.c_str());
  for (const std::string& note : notes) std::printf("note: %s\n", note.c_str());
  std::fflush(stdout);
}

/// Whether max_dofs, and nothing that would have ended the loop as well, was what ended it.
bool stopped_by_dofs(const StaticRun& run, const AdaptRules& rules) {
  const StaticStep& end = run.steps.back();
  return end.converged && !end.tolerance_met && end.step < rules.steps && end.dofs >= rules.max_dofs;
}

int run_scene(const std::string& file, const CommonOptions& options) {
  const std::map<std::string, std::string> overrides = parse_overrides(options.set);
  Scene scene = read_scene(file, options.set);
  const int scene_dofs = scene.adapt ? scene.adapt->max_dofs : 0;
  if (options.quick && scene.adapt) scene.adapt->max_dofs = std::min(scene.adapt->max_dofs, quick_dofs);
  const std::filesystem::path directory = options.directory(scene.name);
  require_writable(directory);
  limit_threads(options.threads);

  Progress progress(options.quiet);
  ResultDocument document;
  document.kind = "run";
  document.name = scene.name;
  document.quick = options.quick;
  document.inputs.scene = file;
  document.inputs.sha256 = sha256_of_file(file);
  for (const auto& [key, value] : overrides) document.inputs.overrides[key] = value;
  document.environment = describe_environment(options.threads);

  RunFiles files(directory, scene, options.vtu_every);
  std::vector<double> step_ms;
  const StaticRun run = run_static(scene, [&](const StaticView& view) {
    const StaticStep& step = view.step;
    step_ms.push_back(step.total_ms);
    const bool stop = interrupt_signal() != 0;
    files.add_step(view, view.last || stop);
    char line[160];
    std::snprintf(line, sizeof line, "step %d: %d dofs, eta %.2f %%", step.step, step.dofs, 100.0 * step.eta);
    progress.update(view.last ? 1.0 : estimated_fraction(step_ms, scene.adapt->steps - step.step), line);
    return !stop;
  });

  for (const StaticStep& step : run.steps) document.rows.push_back(to_json(step));
  document.summary = summarize(run);
  document.checks.push_back(check("unconverged_frames", document.summary["unconverged_frames"], 0.0, 0.0));
  std::vector<std::string> notes = run.notes;
  if (scene.adapt && scene.adapt->tolerance > 0.0) {
    const bool quick_end = options.quick && stopped_by_dofs(run, *scene.adapt) && run.steps.back().dofs < scene_dofs;
    // A run that was cut short has not had its chance to meet the tolerance.
    if (quick_end)
      notes.push_back("tolerance not checked: --quick ended the run at " + std::to_string(quick_dofs) + " dofs");
    else if (interrupt_signal() != 0)
      notes.push_back("tolerance not checked: interrupted");
    else
      document.checks.push_back(check("eta", run.steps.back().eta, 0.0, scene.adapt->tolerance));
  }
  progress.clear();
  if (!options.json) print_steps(scene, run, notes);
  if (const std::optional<std::string> note = draw_error(run, scene.name, directory)) {
    notes.push_back(*note);
    progress.note(*note);
  }
  if (!notes.empty()) document.summary["notes"] = notes;
  return finish(document, options, directory, progress);
}

}  // namespace

void add_run_command(CLI::App& program, int& exit_code) {
  CLI::App* command =
      program.add_subcommand("run", "Runs one scene: a static problem, refined by estimated error if it asks for it");
  const auto file = std::make_shared<std::string>();
  const auto options = std::make_shared<CommonOptions>();
  command->add_option("SCENE", *file, "Scene file (finegauge help scene)")->required();
  add_common_options(*command, *options,
                     "KEY=VALUE: replaces a key of the scene, such as material.poisson_ratio=0.4; repeatable. Keys are "
                     "explained by finegauge help scene");
  command->footer(
      "Writes NAME.json, NAME.csv, NAME_mesh.svg and, after two steps or more, NAME_eta.svg.\n"
      "\n"
      "Example:\n"
      "  finegauge run reference_data/scenes/lshape.toml --set adapt.steps=4 --vtu 1 -o lshape");
  command->callback([&exit_code, file, options] { exit_code = run_scene(*file, *options); });
}

}  // namespace finegauge
