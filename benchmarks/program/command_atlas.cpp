#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
#include <optional>

#include "benchmarks/program/atomic_file.hpp"
#include "benchmarks/program/command.hpp"
#include "benchmarks/program/interrupt.hpp"
#include "benchmarks/program/safe_box_picture.hpp"
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

/// Every N-th job, from the I-th on; I from 1 to N.
struct Shard {
  int number = 1, of = 1;
};

Shard parse_shard(const std::string& text) {
  if (text.empty()) return {};
  Shard shard;
  const char *first = text.data(), *last = text.data() + text.size();
  const auto number = std::from_chars(first, last, shard.number);
  const bool slash = number.ec == std::errc() && number.ptr != last && *number.ptr == '/';
  const auto of = slash ? std::from_chars(number.ptr + 1, last, shard.of) : number;
  if (!slash || of.ec != std::errc() || of.ptr != last || !(shard.number >= 1 && shard.number <= shard.of))
    throw UsageError("--shard " + text + ": expected I/N, whole numbers with 1 <= I <= N");
  return shard;
}

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

std::string file_name(const AtlasAxis& axis, const AtlasPoint& point) {
  return axis.name + "_" + brief_number(point.value) + ".toml";
}

Json to_json(const AtlasAxis& axis, const AtlasPoint& point) {
  Json row = {{"axis", axis.name}, {"value", point.value}, {"ok", point.ok}, {"refused", point.refused}};
  row["measure"] = point.measure;
  if (!std::isfinite(point.measure)) row["measure_reason"] = point.why;
  row["why"] = point.why;
  return row;
}

Json to_json(const std::optional<AtlasRange>& range) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  return {{"low", range ? range->low : none}, {"high", range ? range->high : none}};
}

/// Limits must not shrink.
void add_checks(const AtlasAxis& axis, const std::string& what, const std::optional<AtlasRange>& found,
                const AtlasRange& asked, const std::vector<AtlasPoint>& tried, Json& checks) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  checks.push_back(check(axis.name + "." + what + ".low", found ? found->low : none, tried.front().value, asked.low));
  checks.push_back(check(axis.name + "." + what + ".high", found ? found->high : none, asked.high, tried.back().value));
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
    AtlasPoint point;
    point.value = row.at("value").get<double>();
    point.ok = row.at("ok").get<bool>();
    point.refused = row.at("refused").get<bool>();
    point.measure =
        row.at("measure").is_number() ? row.at("measure").get<double>() : std::numeric_limits<double>::quiet_NaN();
    point.why = row.at("why").get<std::string>();
    finished[{row.at("axis").get<std::string>(), point.value}] = point;
  }
  return finished;
}

std::string range_text(const std::optional<AtlasRange>& range) {
  return range ? brief_number(range->low) + " to " + brief_number(range->high) : "none";
}

void print_row(const SafeBoxRow& row) {
  const AtlasAxis& axis = *row.axis;
  std::printf("%-36s answered %-18s sound %-18s%s\n", axis.name.c_str(), range_text(row.found.answered).c_str(),
              range_text(row.found.safe).c_str(), axis.unit.empty() ? "" : (" [" + axis.unit + "]").c_str());
  std::printf("  %s; against %s\n", axis.about.c_str(), axis.truth.c_str());
  std::printf("  %s\n", axis.reason.c_str());
  for (const AtlasPoint& point : row.found.first_failing)
    std::printf("  FAILS at %s: %s\n", brief_number(point.value).c_str(), point.why.c_str());
}

/// Scenes of the first failing points, and the files that they read. A point that was resumed has lost its scene, and
/// is tried again where its file is not there.
Json save_failing(const SafeBoxRow& row, double seconds, const std::filesystem::path& directory) {
  Json saved = Json::array();
  for (AtlasPoint point : row.found.first_failing) {
    const std::filesystem::path file = directory / file_name(*row.axis, point);
    if (point.scene.empty() && !std::filesystem::exists(file))
      if (const auto again = try_value_apart(*row.axis, point.value, seconds)) point = *again;
    if (!point.scene.empty()) {
      write_file_atomically(file, "# " + point.why + "\n" + point.scene);
      for (const AtlasFile& part : point.files) write_file_atomically(directory / part.name, part.content);
    }
    Json entry = {{"axis", row.axis->name}, {"value", point.value}, {"why", point.why}};
    if (std::filesystem::exists(file)) entry["scene"] = file.filename().string();
    saved.push_back(entry);
  }
  return saved;
}

int atlas(const AtlasCommand& asked) {
  const CommonOptions& options = asked.common;
  if (!parse_overrides(options.set).empty()) throw UsageError("atlas: --set: the atlas has no keys");
  const Shard shard = parse_shard(asked.shard);
  const std::vector<const AtlasAxis*> axes = chosen_axes(asked.names);
  const std::filesystem::path directory = options.directory("atlas");
  require_writable(directory);
  use_one_blas_thread();
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
  std::vector<SafeBoxRow> rows;
  bool whole = shard.of == 1;
  for (const AtlasAxis* axis : axes) {
    std::vector<AtlasPoint> points;
    for (const double value : atlas_values(*axis, options.full)) {
      const auto number = static_cast<int>(job++ % static_cast<std::size_t>(shard.of));
      if (number != shard.number - 1) continue;
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
      document.rows.push_back(to_json(*axis, *point));
      points.push_back(std::move(*point));
      if (!finished.contains({axis->name, value})) write_result(document, directory);  // a kill loses one value at most
    }
    rows.push_back({axis, judge(*axis, std::move(points))});
  }
  progress.clear();

  if (shard.of > 1) document.summary["shard"] = asked.shard;
  Json failing = Json::array();
  for (const SafeBoxRow& row : rows) {
    for (const Json& entry : save_failing(row, seconds, directory)) failing.push_back(entry);
    const AtlasAxis& axis = *row.axis;
    document.summary["axes"][axis.name] = {{"unit", axis.unit},     {"about", axis.about},   {"truth", axis.truth},
                                           {"normal", axis.normal}, {"reason", axis.reason}, {"group", axis.group}};
    if (!whole) continue;  // a part of the values says nothing of the limits
    document.summary["safe"][axis.name] = to_json(row.found.safe);
    document.summary["answered"][axis.name] = to_json(row.found.answered);
    add_checks(axis, "safe", row.found.safe, axis.safe, row.found.points, document.checks);
    add_checks(axis, "answered", row.found.answered, axis.answered, row.found.points, document.checks);
    if (!options.json) print_row(row);
  }
  document.summary["first_failing"] = failing;
  document.summary["peak_memory_mb"] = peak_memory_mb();
  if (whole) {
    std::string note = std::to_string(document.rows.size()) + " values on " + std::to_string(rows.size()) + " axes";
    note += ", version " + document.environment.version + " (" + document.environment.commit + ")";
    write_file_atomically(directory / "safe_box.svg", safe_box_svg(rows, note));
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
