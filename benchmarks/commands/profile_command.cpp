#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <stdexcept>

#include "benchmarks/commands/commands.hpp"
#include "benchmarks/profile/frame_profile.hpp"
#include "benchmarks/profile/instrumentation.hpp"
#include "benchmarks/profile/processor_clock.hpp"
#include "benchmarks/profile/profile_tjunctions.hpp"
#include "benchmarks/program/atomic_file.hpp"
#include "benchmarks/program/command.hpp"
#include "benchmarks/program/frame_rows.hpp"
#include "benchmarks/program/frame_statistics.hpp"
#include "benchmarks/program/interrupt.hpp"
#include "benchmarks/program/sha256.hpp"
#include "core/scene/scene_reader.hpp"

namespace finegauge {
namespace {

constexpr int quick_pass_frames = 150, quick_pass_dofs = 8000;
constexpr double quick_pass_seconds = 12.0;  // of each of the passes over the scene
constexpr int instrumentation_frames = 400;  // more tell no more

/// Frames or steps that --quick or the user does not let run.
struct Limits {
  bool quick;
  const Progress& progress;
  double started;
  bool reached(int frames) const {
    return interrupt_signal() != 0 ||
           (quick && (frames >= quick_pass_frames || progress.seconds() - started > quick_pass_seconds));
  }
};

void keep_the_most_hanging(std::optional<MeshMoment>& most, const RefinementForest& forest, const Discretization& d,
                           const Eigen::Matrix3Xd& u) {
  const int hanging = d.hanging.hanging_count();
  if (hanging == 0 || (most && most->d.hanging.hanging_count() >= hanging)) return;
  most.emplace(MeshMoment{forest, d, u});
}

/// What the rows and the summary are made of.
struct Profiled {
  std::optional<FrameProfile> frames;
  std::optional<MeshMoment> most;
  std::optional<TjunctionOverhead> overhead;
  std::optional<Instrumentation> instrumentation;
  int count = 0;
  std::string stopped_because;
};

void profile_moving(const Scene& scene, const CommonOptions& options, Progress& progress, StageRecorder& recorder,
                    Profiled& result) {
  result.frames.emplace(scene, &recorder);
  const auto pass = [&](double begin, double end, const char* doing, const StageClock& clock, const auto& observe) {
    const Limits limits{options.quick, progress, progress.seconds()};
    int frames = 0;
    return run_motion(
        scene,
        [&](const MotionView& view) {
          observe(view);
          ++frames;
          const int planned = options.quick ? std::min(view.frames, quick_pass_frames) : view.frames;
          if (frames % std::max(1, planned / 7) == 0)
            progress.update(begin + (end - begin) * std::min(1.0, static_cast<double>(frames) / planned), doing);
          return !limits.reached(frames);
        },
        clock);
  };
  const MotionRun run = pass(0.0, 0.4, "frames and their stages", recorder.clock(),
                             [&](const MotionView& view) { result.frames->add(view); });
  if (run.frames.empty()) throw std::runtime_error(run.stopped_because);
  result.count = static_cast<int>(run.frames.size());
  result.stopped_because = run.stopped_because;
  if (interrupt_signal() != 0) return;
  result.overhead.emplace(options.quick ? 3 : 7);
  pass(0.4, 0.7, "what hanging nodes cost", processor_clock(), [&](const MotionView& view) {
    result.overhead->observe(view);
    keep_the_most_hanging(result.most, view.tissue.forest, view.tissue.mesh.d, view.tissue.state.u);
  });
  if (interrupt_signal() != 0) return;
  progress.update(0.7, "what the timing costs");
  result.instrumentation = measure_instrumentation(scene, std::min(result.count, instrumentation_frames));
}

void profile_static(const Scene& given, const CommonOptions& options, Progress& progress, Profiled& result) {
  Scene scene = given;
  if (options.quick && scene.adapt) scene.adapt->max_dofs = std::min(scene.adapt->max_dofs, quick_pass_dofs);
  result.frames.emplace(given, nullptr);
  const StaticRun run = run_static(scene, [&](const StaticView& view) {
    result.frames->add(view);
    keep_the_most_hanging(result.most, view.forest, view.discretization, view.u);
    const int steps = scene.adapt ? scene.adapt->steps + 1 : 1;
    progress.update(0.6 * (view.step.step + 1.0) / steps, "step " + std::to_string(view.step.step));
    return interrupt_signal() == 0;
  });
  result.count = static_cast<int>(run.steps.size());
  result.stopped_because = run.stopped_because;
}

std::string text_of(const Json& value, const char* format) {
  if (!value.is_number()) return "-";
  char text[48];
  std::snprintf(text, sizeof text, format, value.get<double>());
  return text;
}
std::string percent_of(const Json& value) {
  return value.is_number() ? text_of(100.0 * value.get<double>(), "%.1f %%") : "-";
}

void print_handlings(const Json& t) {
  std::printf("\n%-12s %9s %11s %11s %9s %9s %9s %9s %9s %10s\n", "handling", "unknowns", "nonzeros", "of factor",
              "assemble", "reduce", "symbolic", "numeric", "total", "iterations");
  for (const char* key : {"elementwise", "explicit", "multiplier", "ignored", "conforming"}) {
    if (!t.contains(key) || !t.at(key).is_object() || !t.at(key).contains("total_ms")) continue;
    const Json& h = t.at(key);
    std::printf("%-12s %9d %11.0f %11.0f %9.3f %9.3f %9.3f %9.3f %9.3f %10d\n", key, h.at("unknowns").get<int>(),
                h.at("matrix_nonzeros").get<double>(), h.at("factor_nonzeros").get<double>(),
                h.at("assemble_ms").get<double>(), h.at("reduce_ms").get<double>(), h.at("symbolic_ms").get<double>(),
                h.at("numeric_ms").get<double>(), h.at("total_ms").get<double>(), h.at("iterations").get<int>());
  }
  std::printf("times in ms of the processor; \"ignored\" lets the field gape, \"conforming\" is uniformly fine\n");
}

void print_tjunctions(const Json& t) {
  if (t.at("hanging_nodes").get<int>() == 0) {
    std::printf("\nNo node of the run hung.\n");
    return;
  }
  std::printf("\nHanging nodes, on the mesh that has the most: %d of %d nodes (%s), %d of %d cells have one\n",
              t.at("hanging_nodes").get<int>(), t.at("nodes").get<int>(), percent_of(t.at("hanging_share")).c_str(),
              t.at("hanging_cells").get<int>(), t.at("cells").get<int>());
  std::printf(
      "chains of %s levels: %s nodes; rows of the reduced matrix touched: %d of %d; blocks per row %.1f, of the "
      "matrix of all nodes %.1f\n",
      "0, 1, ...", t.at("chain_lengths").dump().c_str(), t.at("rows_touched").get<int>(), t.at("dofs").get<int>(),
      t.at("blocks_per_row").get<double>(), t.at("nodal_blocks_per_row").get<double>());
  if (t.contains("of_frames")) {
    const Json& f = t.at("of_frames");
    const Json &all = f.at("share"), &hanging = f.at("share_of_frames_with_hanging_nodes");
    std::printf(
        "of all frames: %s (building T %s, reducing %s, expanding %s); of the %d frames with hanging nodes: %s\n",
        percent_of(all.at("all")).c_str(), percent_of(all.at("build")).c_str(), percent_of(all.at("reduce")).c_str(),
        percent_of(all.at("expand")).c_str(), f.at("frames_with_hanging_nodes").get<int>(),
        percent_of(hanging.at("all")).c_str());
  }
  print_handlings(t);
}

void print_profile(const ResultDocument& document, const Scene& scene) {
  const Json& s = document.summary;
  std::printf("%s: %d %s, median %s ms, 99th percentile %s ms\n\n", scene.name.c_str(), s.at("frames").get<int>(),
              scene.dynamics ? "frames" : "steps", text_of(s.at("frame_ms").at("p50"), "%.4g").c_str(),
              text_of(s.at("frame_ms").at("p99"), "%.4g").c_str());
  std::printf("%-10s %9s %9s %8s %12s %10s %10s %10s %10s\n", "stage", "p50 [ms]", "p99 [ms]", "share", "allocations",
              "Gflop/s", "of machine", "GB/s", "of machine");
  for (const Json& row : document.rows) {
    const auto giga = [&](const char* key) {
      return row.at(key).is_number() ? text_of(1e-9 * row.at(key).get<double>(), "%.2f") : std::string("-");
    };
    std::printf("%-10s %9s %9s %8s %12s %10s %10s %10s %10s\n", row.at("stage").get<std::string>().c_str(),
                text_of(row.at("p50_ms"), "%.4f").c_str(), text_of(row.at("p99_ms"), "%.4f").c_str(),
                percent_of(row.at("share")).c_str(), text_of(row.at("allocations_p50"), "%.0f").c_str(),
                giga("flops_per_second").c_str(), percent_of(row.at("flops_of_machine")).c_str(),
                giga("bytes_per_second").c_str(), percent_of(row.at("bytes_of_machine")).c_str());
  }
  const Json& m = s.at("machine");
  std::printf(
      "machine, one core, measured now: %s Gflop/s, %s GB/s. Flops and bytes are counted where formulas from "
      "exact\ncounts exist, and are lower bounds (benchmarks/README.md)\n",
      text_of(1e-9 * m.at("flops_per_second").get<double>(), "%.1f").c_str(),
      text_of(1e-9 * m.at("bytes_per_second").get<double>(), "%.1f").c_str());
  if (s.at("instrumentation").is_object()) {
    const Json& i = s.at("instrumentation");
    std::printf(
        "timing the stages: %.1f readings a frame of %.0f ns, %s of a median frame; measured in turns %s (95 %%: "
        "%s to %s)\n",
        i.at("readings_per_frame").get<double>(), i.at("reading_ns").get<double>(),
        text_of(100.0 * i.at("share").get<double>(), "%.4f %%").c_str(),
        text_of(100.0 * i.at("paired_difference").at("median").get<double>(), "%+.2f %%").c_str(),
        text_of(100.0 * i.at("paired_difference").at("low").get<double>(), "%+.2f %%").c_str(),
        text_of(100.0 * i.at("paired_difference").at("high").get<double>(), "%+.2f %%").c_str());
  }
  if (s.contains("tjunctions")) print_tjunctions(s.at("tjunctions"));
  std::printf("\n");
  std::fflush(stdout);
}

void summarize(const Profiled& profiled, const MachineRates& machine, const CommonOptions& options,
               ResultDocument& document) {
  const FrameProfile& frames = *profiled.frames;
  document.rows = profile_rows(frames, machine);
  const FrameStatistics ms = frame_times(frames.frame_ms());
  Json& summary = document.summary;
  summary["frames"] = profiled.count;
  summary["frame_ms"] = {{"p50", ms.p50}, {"p95", ms.p95}, {"p99", ms.p99}, {"max", ms.max}};
  summary["machine"] = to_json(machine);
  summary["instrumentation"] = nullptr;
  if (profiled.instrumentation)
    summary["instrumentation"] = to_json(*profiled.instrumentation);
  else
    summary["instrumentation_reason"] = "the scene has no [dynamics], or the run was interrupted";
  if (interrupt_signal() == 0)
    summary["tjunctions"] =
        tjunction_summary(profiled.most, profiled.overhead ? &*profiled.overhead : nullptr, options.quick ? 3 : 7);
  summary["stopped_because"] = profiled.stopped_because;
  summary["trace"] = document.name + "_trace.json";

  double shares = 0.0;
  for (const Json& row : document.rows) shares += row.at("share").is_number() ? row.at("share").get<double>() : 0.0;
  document.checks.push_back(check("shares of the stages, sum", shares, 1.0 - 1e-9, 1.0 + 1e-9));
  document.checks.push_back(check("stages told apart in every frame", frames.laps_known() ? 1.0 : 0.0, 1.0, 1.0));
  if (profiled.instrumentation) {
    const Instrumentation& i = *profiled.instrumentation;
    // Below the lower bound nothing was read or no time measured.
    document.checks.push_back(check("timing the stages, share of a median frame", i.share(), 1e-7, 0.01));
    document.checks.push_back(check("stage times without a clock [ms]", i.stage_ms_when_off, 0.0, 0.0));
    document.checks.push_back(check("same states with and without", i.same_states ? 1.0 : 0.0, 1.0, 1.0));
  }
  if (!summary.contains("tjunctions")) return;
  if (const std::optional<double> difference = handling_difference(summary.at("tjunctions")))
    document.checks.push_back(check("displacements of the handlings differ by", *difference, 0.0, 1e-7));
}

int profile_scene(const std::string& file, const CommonOptions& options) {
  (void)parse_overrides(options.set);
  const Scene scene = read_scene(file, options.set);
  const std::filesystem::path directory = options.directory(scene.name + "_profile");
  require_writable(directory);
  use_threads(options.threads);
  Progress progress(options.quiet);
  ResultDocument document;
  document.kind = "profile";
  document.name = scene.name + "_profile";
  document.quick = options.quick;
  document.inputs.scene = file;
  document.inputs.sha256 = sha256_of_file(file);
  for (const auto& [key, value] : parse_overrides(options.set)) document.inputs.overrides[key] = value;
  document.environment = describe_environment(options.threads);

  StageRecorder recorder;
  Profiled profiled;
  if (scene.dynamics)
    profile_moving(scene, options, progress, recorder, profiled);
  else
    profile_static(scene, options, progress, profiled);
  const double peak = peak_memory_mb();  // before the calibration's arrays
  progress.update(0.9, "what the machine can do, and the handlings of hanging nodes");
  summarize(profiled, measure_machine(options.quick ? 3 : 9), options, document);
  document.summary["peak_memory_mb"] = peak;
  const Json notes = {
      {"scene", file},
      {"clock", scene.dynamics ? "wall clock, stages where they were"
                               : "stages one after the other in their order, with their measured lengths"},
      {"commit", document.environment.commit}};
  std::filesystem::create_directories(directory);
  write_file_atomically(directory / (document.name + "_trace.json"), profiled.frames->trace().text(notes));
  progress.clear();
  if (!options.json) print_profile(document, scene);
  return finish(document, options, directory, progress);
}

}  // namespace

void add_profile_command(CLI::App& program, int& exit_code) {
  CLI::App* command = program.add_subcommand(
      "profile", "Where a frame's time goes, stage by stage, and what hanging nodes cost (the T-junction ledger)");
  const auto file = std::make_shared<std::string>();
  const auto options = std::make_shared<CommonOptions>();
  command->add_option("SCENE", *file, "Scene file (finegauge help scene)")->required();
  add_common_options(
      *command, *options,
      "KEY=VALUE: replaces a key of the scene, such as adapt.max_depth=2; repeatable. Keys are explained "
      "by finegauge help scene");
  command->footer(
      "Writes NAME_profile.json, NAME_profile.csv and NAME_profile_trace.json; open the last one in\n"
      "https://ui.perfetto.dev or chrome://tracing to see every stage of every frame. A moving scene is run four\n"
      "times: recorded, for what hanging nodes cost, and twice in turns for what the recording costs. --quick ends\n"
      "each pass after 150 frames or 12 seconds, and a static scene at 8000 degrees of freedom.\n"
      "\n"
      "Examples:\n"
      "  finegauge profile reference_data/scenes/phantom.toml\n"
      "  finegauge profile reference_data/scenes/lshape.toml --quick -o lshape_profile");
  command->callback([&exit_code, file, options] { exit_code = profile_scene(*file, *options); });
}

}  // namespace finegauge
