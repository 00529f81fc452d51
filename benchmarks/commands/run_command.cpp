#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <stdexcept>

#include "benchmarks/commands/commands.hpp"
#include "benchmarks/program/command.hpp"
#include "benchmarks/program/frame_rows.hpp"
#include "benchmarks/program/interrupt.hpp"
#include "benchmarks/program/motion_output.hpp"
#include "benchmarks/program/motion_run.hpp"
#include "benchmarks/program/sha256.hpp"
#include "benchmarks/program/static_output.hpp"
#include "benchmarks/program/static_run.hpp"
#include "core/scene/scene_reader.hpp"

namespace finegauge {
namespace {

constexpr int quick_dofs = 20000;  // a solve of this size takes about a second, and a loop up to it a few
constexpr int quick_frames = 200;
constexpr double quick_seconds = 45.0;  // the rest of the minute is for what is written at the end

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

/// Whether max_dofs, and nothing that would have ended the loop as well, was what ended it.
bool stopped_by_dofs(const StaticRun& run, const AdaptRules& rules) {
  const StaticStep& end = run.steps.back();
  return end.converged && !end.tolerance_met && end.step < rules.steps && end.dofs >= rules.max_dofs;
}

ResultDocument begin_document(const std::string& file, const Scene& scene, const CommonOptions& options) {
  ResultDocument document;
  document.kind = "run";
  document.name = scene.name;
  document.quick = options.quick;
  document.inputs.scene = file;
  document.inputs.sha256 = sha256_of_file(file);
  for (const auto& [key, value] : parse_overrides(options.set)) document.inputs.overrides[key] = value;
  document.environment = describe_environment(options.threads);
  return document;
}

int run_static_scene(const Scene& given, const CommonOptions& options, const std::filesystem::path& directory,
                     ResultDocument document, Progress& progress) {
  Scene scene = given;
  const int scene_dofs = scene.adapt ? scene.adapt->max_dofs : 0;
  if (options.quick && scene.adapt) scene.adapt->max_dofs = std::min(scene.adapt->max_dofs, quick_dofs);
  StaticFiles files(directory, scene, options.vtu_every);
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

int run_moving_scene(const Scene& scene, const CommonOptions& options, const std::filesystem::path& directory,
                     ResultDocument document, Progress& progress) {
  MotionFiles files(directory, scene, options.vtu_every);
  // A line that is rewritten may follow every frame; lines that stay are about twenty.
  const bool terminal = isatty(STDERR_FILENO) != 0;
  bool quick_end = false;
  MotionRun run = run_motion(scene, [&](const MotionView& view) {
    const FrameReport& frame = view.frame.report.frame;
    quick_end = options.quick && !view.last && (frame.frame >= quick_frames || progress.seconds() > quick_seconds);
    const bool stop = interrupt_signal() != 0 || quick_end;
    files.add_frame(view, view.last || stop);
    if (terminal || frame.frame % std::max(1, view.frames / 20) == 0) {
      char line[160];
      std::snprintf(line, sizeof line, "frame %d of %d: t = %.4g, %d dofs", frame.frame, view.frames, frame.time,
                    frame.dofs);
      const int planned = options.quick ? std::min(view.frames, quick_frames) : view.frames;
      progress.update(static_cast<double>(frame.frame) / planned, line);
    }
    return !stop;
  });
  if (run.frames.empty()) throw std::runtime_error(run.stopped_because);

  for (const MotionFrame& frame : run.frames) document.rows.push_back(to_json(frame, scene));
  std::vector<std::string> notes = run_notes(scene, run);
  if (quick_end) {
    run.stopped_because = "--quick";
    notes.push_back("--quick ended the run after " + std::to_string(run.frames.size()) + " of " +
                    std::to_string(run.planned_frames) + " frames");
  }
  document.summary = summarize(scene, run);
  document.checks = motion_checks(run, quick_end || interrupt_signal() != 0);
  progress.clear();
  if (!options.json) print_motion(scene, run, document.summary, notes);
  for (const std::string& note : draw_motion(scene, run, directory)) {
    notes.push_back(note);
    progress.note(note);
  }
  if (!notes.empty()) document.summary["notes"] = notes;
  if (run.failed) std::fprintf(stderr, "%s\n", run.stopped_because.c_str());
  const int code = finish(document, options, directory, progress);
  if (const std::string failure = convergence_failure(run); !failure.empty())
    std::fprintf(stderr, "%s\n", failure.c_str());
  return code;
}

int run_scene(const std::string& file, const CommonOptions& options) {
  (void)parse_overrides(options.set);  // its messages say more of a --set without a key than the scene's can
  const Scene scene = read_scene(file, options.set);
  const std::filesystem::path directory = result_directory(options, scene.name, "run");
  require_writable(directory);
  use_threads(options.threads);
  Progress progress(options.quiet);
  const auto run = scene.dynamics ? run_moving_scene : run_static_scene;
  return run(scene, options, directory, begin_document(file, scene, options), progress);
}

}  // namespace

void add_run_command(CLI::App& program, int& exit_code) {
  CLI::App* command = program.add_subcommand(
      "run", "Runs one scene: a static problem, a body that moves, or a needle that is driven into it");
  const auto file = std::make_shared<std::string>();
  const auto options = std::make_shared<CommonOptions>();
  command->add_option("SCENE", *file, "Scene file (finegauge help scene)")->required();
  add_common_options(*command, *options,
                     "KEY=VALUE: replaces a key of the scene, such as material.poisson_ratio=0.4; repeatable. Keys are "
                     "explained by finegauge help scene");
  command->footer(
      "Writes NAME.json, NAME.csv and NAME_mesh.svg; of a static scene with two steps or more NAME_eta.svg; of a\n"
      "moving one NAME_dofs.svg and, with a needle, NAME_force.svg and the body cut open along the needle, coloured\n"
      "by stress and by error: NAME_start_stress.svg, NAME_start_eta.svg, the same of depth and of end. --quick ends\n"
      "a moving scene after 200 frames or 45 seconds.\n"
      "\n"
      "Examples:\n"
      "  finegauge run reference_data/scenes/lshape.toml --set adapt.steps=4 --vtu 1 -o lshape\n"
      "  finegauge run reference_data/scenes/phantom.toml --vtu 20");
  command->callback([&exit_code, file, options] { exit_code = run_scene(*file, *options); });
}

}  // namespace finegauge
