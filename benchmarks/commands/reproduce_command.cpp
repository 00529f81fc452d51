#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>

#include "benchmarks/commands/commands.hpp"
#include "benchmarks/paper/displacement_field_study.hpp"
#include "benchmarks/paper/liver_phantom_study.hpp"
#include "benchmarks/paper/liver_study.hpp"
#include "benchmarks/paper/lshape_study.hpp"
#include "benchmarks/paper/phantom_study.hpp"
#include "benchmarks/paper/tjunctions_study.hpp"
#include "benchmarks/program/atomic_file.hpp"
#include "benchmarks/program/command.hpp"
#include "benchmarks/program/interrupt.hpp"
#include "benchmarks/program/shard.hpp"
#include "benchmarks/program/study.hpp"

namespace finegauge {
namespace {

/// The studies asked for, each once, in the order asked for. Throws UsageError for a name that is none.
std::vector<const Study*> chosen_studies(const std::vector<std::string>& names) {
  std::vector<const Study*> chosen;
  const auto choose = [&](const Study& study) {
    if (std::ranges::find(chosen, &study) == chosen.end()) chosen.push_back(&study);
  };
  std::string built;
  for (const Study& study : paper_studies()) built += (built.empty() ? "" : ", ") + study.name;
  for (const std::string& name : names) {
    if (name == "all") {
      for (const Study& study : paper_studies()) choose(study);
      continue;
    }
    const auto found = std::ranges::find(paper_studies(), name, &Study::name);
    if (found != paper_studies().end()) {
      choose(*found);
      continue;
    }
    throw UsageError("reproduce: no study \"" + name + "\"; there are: " + built);
  }
  return chosen;
}

/// With several studies --out is the directory of them all.
std::filesystem::path directory_of(const Study& study, const CommonOptions& options, bool several) {
  return several && !options.out.empty() ? std::filesystem::path(options.out) / study.name
                                         : result_directory(options, study.name, "reproduce");
}

int run_study(const Study& study, const CommonOptions& options, bool several) {
  Progress progress(options.quiet);
  ResultDocument document;
  document.kind = "reproduce";
  document.name = study.name;
  document.quick = options.quick;
  document.environment = describe_environment(options.threads);
  StudyContext context;
  context.quick = options.quick, context.full = options.full, context.quiet = options.quiet;
  context.vtu_every = options.vtu_every;
  context.out = directory_of(study, options, several);
  context.overrides = parse_overrides(options.set);
  for (const auto& [key, value] : context.overrides) document.inputs.overrides[key] = value;
  context.progress = [&](double fraction, const std::string& doing) {
    progress.update(fraction, study.name + ": " + doing);
  };
  context.interrupted = [] { return interrupt_signal() != 0; };

  StudyResult result = study.run(context);
  document.inputs.scene = result.scene, document.inputs.sha256 = result.sha256;
  document.rows = std::move(result.rows);
  document.summary = std::move(result.summary);
  document.checks = std::move(result.checks);
  document.summary["peak_memory_mb"] = peak_memory_mb();
  for (const StudyFile& file : result.files) write_file_atomically(context.out / file.name, file.content);
  Json notes = Json::array();
  for (const Plot& plot : result.plots)
    if (const PlotReport report = draw_plot(plot, context.out); !report.written) {
      notes.push_back(report.why_not);
      progress.note(report.why_not);
    }
  if (!notes.empty()) document.summary["notes"] = notes;
  progress.clear();
  if (!options.json) {
    std::printf("%s: %s%s\n\n", study.name.c_str(), study.about.c_str(), options.quick ? " (quick version)" : "");
    for (const std::string& line : result.table) std::printf("%s\n", line.c_str());
    std::printf("\n");
    std::fflush(stdout);
  }
  return finish(document, options, context.out, progress);
}

int reproduce(const std::vector<std::string>& names, const std::string& shard_text, const CommonOptions& options) {
  const Shard shard = parse_shard(shard_text);
  const std::vector<const Study*> studies = chosen_studies(names);
  if (options.json && studies.size() > 1)
    throw UsageError("reproduce: --json prints one document, so it takes one study");
  parse_overrides(options.set);
  for (const Study* study : studies) require_writable(directory_of(*study, options, studies.size() > 1));
  use_threads(options.threads);
  int worst = exit_ok;
  if (static_cast<std::size_t>(shard.number) > studies.size())
    std::fprintf(stderr, "part %s of %zu: no study is left for it\n", shard_text.c_str(), studies.size());
  for (std::size_t job = 0; job < studies.size(); ++job) {
    if (!shard.has(job)) continue;
    const Study* study = studies[job];
    const int code = run_study(*study, options, studies.size() > 1);
    if (interrupt_signal()) return code;
    worst = std::max(worst, code);
  }
  return worst;
}

}  // namespace

std::span<const Study> paper_studies() {
  static const std::vector<Study> studies = {
      {"lshape", "error over degrees of freedom on the L-shape: uniform, adaptive, directional (Table 1)",
       &lshape_study},
      {"tjunctions", "hanging nodes: how many by pattern, three ways to handle them, against conforming meshes",
       &tjunctions_study},
      {"displacement-field", "how far a needle drags tissue by friction, on four meshes", &displacement_field_study},
      {"phantom", "needle into a gel block: force over travel on coarse, fine and adaptive meshes, frame rates",
       &phantom_study},
      {"liver", "needle into a liver that breathes: dofs, error and frame rates, unrefined and within a tolerance",
       &liver_study},
      {"liver-phantom", "needle into a liver and out again: the loop of the force on four meshes",
       &liver_phantom_study}};
  return studies;
}

void add_reproduce_command(CLI::App& program, int& exit_code) {
  CLI::App* command = program.add_subcommand("reproduce", "The paper's studies: columns paper, here, why they differ");
  const auto names = std::make_shared<std::vector<std::string>>();
  const auto shard = std::make_shared<std::string>();
  const auto options = std::make_shared<CommonOptions>();
  command->add_option("STUDY", *names, "Studies by name (finegauge list), or all")->required();
  command
      ->add_option("--shard", *shard,
                   "Every N-th of these studies only, from the I-th on. Each is whole in its own directory, so that "
                   "all parts can have the same --out")
      ->type_name("I/N");
  add_common_options(
      *command, *options,
      "KEY=VALUE: replaces a key of the study, such as notch=lower_left; repeatable. Keys of lshape: "
      "notch (lower_left, lower_right, upper_left, upper_right), the surfaces clamped, roller and loaded "
      "(x_min to z_max), theta and directional_theta (above 0, at most 1). Keys of displacement-field and phantom: "
      "those "
      "of their scenes in reference_data/scenes (finegauge help scene), but for what the study itself varies");
  command->footer(
      "Writes STUDY.json, STUDY.csv, plots and pictures of meshes; the needle studies also a CSV of the frames of "
      "each\n"
      "case. --full of liver-phantom adds a hundred insertions and withdrawals, with what they leave behind (ten\n"
      "minutes). --vtu is for lshape; finegauge run writes the VTU files of a needle's scene.\n"
      "\n"
      "Examples:\n"
      "  finegauge reproduce lshape --set theta=0.5\n"
      "  finegauge reproduce phantom displacement-field\n"
      "  finegauge reproduce all --quick -o paper");
  command->callback([&exit_code, names, shard, options] { exit_code = reproduce(*names, *shard, *options); });
}

}  // namespace finegauge
