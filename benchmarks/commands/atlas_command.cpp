#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <memory>
#include <optional>

#include "benchmarks/commands/commands.hpp"
#include "benchmarks/program/atlas_result.hpp"
#include "benchmarks/program/atomic_file.hpp"
#include "benchmarks/program/command.hpp"
#include "benchmarks/program/interrupt.hpp"
#include "benchmarks/program/shard.hpp"
#include "verification/studies/atlas.hpp"

namespace finegauge {
namespace {

constexpr double seconds_for_a_value = 60.0, seconds_in_full = 1800.0;  // a million frames take minutes

struct AtlasCommand {
  std::vector<std::string> names;
  std::string shard;  // "I/N"
  bool resume = false;
  CommonOptions common;
};

/// The axes asked for, each once, in the order of the atlas.
std::vector<const AtlasAxis*> chosen_axes(const std::vector<std::string>& names) {
  std::string known;
  for (const AtlasAxis& axis : atlas_axes()) known.append(known.empty() ? "" : ", ").append(axis.name);
  for (const std::string& name : names)
    if (name != "all" && std::ranges::find(atlas_axes(), name, &AtlasAxis::name) == atlas_axes().end())
      throw UsageError("atlas: no axis \"" + name + "\"; there are: all, " + known);
  std::vector<const AtlasAxis*> chosen;
  for (const AtlasAxis& axis : atlas_axes())
    if (names.empty() || std::ranges::find(names, axis.name) != names.end() ||
        std::ranges::find(names, "all") != names.end())
      chosen.push_back(&axis);
  return chosen;
}

/// What an interrupted or killed run of the same kind left behind, by axis and value.
using Finished = std::map<std::pair<std::string, double>, AtlasPoint>;
Finished read_finished(const std::filesystem::path& file, const ResultDocument& document) {
  Finished finished;
  std::ifstream in(file);
  const Json old = Json::parse(in, nullptr, false);
  if (old.is_discarded() || !old.contains("rows")) return finished;  // there is none, or not one of ours
  const Json now = finegauge::to_json(document);
  for (const char* key : {"version", "commit", "compiler", "flags"})
    if (old.at("environment").at(key) != now.at("environment").at(key))
      throw UsageError("--resume: " + file.string() + " is of another build of the program, by its " + key);
  for (const Json& row : old.at("rows")) {
    const AtlasPoint point = atlas_point(row);
    finished[{row.at("axis").get<std::string>(), point.value}] = point;
  }
  return finished;
}

/// Scenes of the first failing points, and the files that they read. A point that was resumed has lost its scene, and
/// is tried again where its file is not there.
Json save_failing(const SafeBoxRow& row, double seconds, const std::filesystem::path& directory) {
  Json saved = Json::array();
  for (AtlasPoint point : row.found.first_failing) {
    const std::filesystem::path file = directory / atlas_scene_name(*row.axis, point);
    if (point.scene.empty() && !std::filesystem::exists(file))
      if (const auto again = try_value_apart(*row.axis, point.value, seconds)) point = *again;
    if (!point.scene.empty()) {
      write_file_atomically(file, "# " + point.why + "\n" + point.scene);
      for (const AtlasFile& part : point.files) write_file_atomically(directory / part.name, part.content);
    }
    Json entry = {{"axis", row.axis->name}, {"value", point.value}, {"why", point.why}};
    if (std::filesystem::exists(file)) entry["scene"] = file.filename().string();
    for (const AtlasFile& part : point.files) entry["files"].push_back(part.name);  // that the scene reads
    saved.push_back(entry);
  }
  return saved;
}

int atlas(const AtlasCommand& asked) {
  const CommonOptions& options = asked.common;
  if (!parse_overrides(options.set).empty()) throw UsageError("atlas: --set: the atlas has no keys");
  const Shard shard = parse_shard(asked.shard);
  const std::vector<const AtlasAxis*> axes = chosen_axes(asked.names);
  const std::filesystem::path directory = result_directory(options, "atlas", "atlas");
  require_writable(directory);
  use_threads(options.threads);
  Progress progress(options.quiet);
  ResultDocument document;
  document.kind = "atlas";
  document.name = "atlas";
  document.quick = options.quick;
  document.environment = describe_environment(options.threads);
  Finished finished;
  if (asked.resume) finished = read_finished(directory / "atlas.json", document);
  const double seconds = options.full ? seconds_in_full : seconds_for_a_value;

  std::size_t jobs = 0, job = 0;
  for (const AtlasAxis* axis : axes) jobs += atlas_values(*axis, options.full).size();
  // First, so that a part that was killed can be told from one that is whole.
  document.summary["jobs"] = jobs;
  if (shard.of > 1) document.summary["shard"] = std::to_string(shard.number) + "/" + std::to_string(shard.of);
  std::vector<SafeBoxRow> rows;
  bool whole = shard.of == 1;
  for (const AtlasAxis* axis : axes) {
    std::vector<AtlasPoint> points;
    for (const double value : atlas_values(*axis, options.full)) {
      if (!shard.has(job++)) continue;
      progress.update(static_cast<double>(job) / static_cast<double>(jobs), axis->name + " = " + brief_number(value));
      std::optional<AtlasPoint> point;
      if (const auto done = finished.find({axis->name, value}); done != finished.end())
        point = done->second;
      else if (interrupt_signal() == 0)
        point = try_value_apart(*axis, value, seconds, [] { return interrupt_signal() != 0; });
      if (!point) {
        whole = false;
        continue;
      }
      document.rows.push_back(atlas_row(*axis, *point));
      points.push_back(std::move(*point));
      if (!finished.contains({axis->name, value})) write_result(document, directory);  // a kill loses one value at most
    }
    rows.push_back({axis, judge(*axis, std::move(points))});
  }
  progress.clear();

  Json failing = Json::array();
  summarize_axes(rows, whole, document);
  for (const SafeBoxRow& row : rows) {
    for (const Json& entry : save_failing(row, seconds, directory)) failing.push_back(entry);
    if (whole && !options.json) print_axis(row);
  }
  document.summary["first_failing"] = failing;
  document.summary["peak_memory_mb"] = peak_memory_mb();
  if (whole) {
    write_safe_box(rows, document, directory);
  } else {
    progress.note("not all values were tried: no limits, no picture");
  }
  if (!options.json) std::fflush(stdout);
  return finish(document, options, directory, progress);
}

}  // namespace

void add_atlas_command(CLI::App& program, int& exit_code) {
  CLI::App* command = program.add_subcommand(
      "atlas", "Numerical extremes, an axis at a time over decades: the box in which the simulation is sound");
  const auto asked = std::make_shared<AtlasCommand>();
  command->add_option("AXIS", asked->names, "Axes by name, or all (default)");
  add_common_options(*command, asked->common, "The atlas has no keys");
  command
      ->add_option("--shard", asked->shard, "Every N-th value only, from the I-th on; finegauge merge joins the parts")
      ->type_name("I/N");
  command->add_flag("--resume", asked->resume, "Takes the values that are finished from --out's atlas.json");
  command->footer(
      "Writes atlas.json, atlas.csv, safe_box.svg, and of the failures that are nearest to the usual value the "
      "scenes,\n"
      "AXIS_VALUE.toml, for finegauge run. Each value is tried in a process of its own: one that crashes, or is not\n"
      "done within a minute (half an hour with --full), is a failure. A limit that is narrower than the tests' fails.\n"
      "--quick is what the tests try; --full adds values far beyond any use and a million frames of decay.\n"
      "\n"
      "Examples:\n"
      "  finegauge atlas\n"
      "  finegauge atlas time_step density -o extremes\n"
      "  finegauge atlas --full --shard 2/8 -o extremes_2");
  command->callback([&exit_code, asked] { exit_code = atlas(*asked); });
}

}  // namespace finegauge
