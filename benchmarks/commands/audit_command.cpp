#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>

#include "benchmarks/audit/audit.hpp"
#include "benchmarks/commands/commands.hpp"
#include "benchmarks/measure/overrides.hpp"
#include "benchmarks/program/command.hpp"
#include "benchmarks/program/interrupt.hpp"
#include "benchmarks/program/sha256.hpp"
#include "core/scene/scene_reader.hpp"

namespace finegauge {
namespace {

struct AuditCommand {
  std::string scene;
  double tolerance = 0.02;
  std::uint64_t seed = 1;
  CommonOptions common;
};

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(); }

Json changes(const SceneComparison& comparison) {
  Json json = Json::object();
  for (const auto& [name, change] : comparison.quantity_change) {
    json[name] = number(change);
    if (!std::isfinite(change)) json[name + "_reason"] = "nothing to compare";
  }
  return json;
}

Json to_row(const AuditedIngredient& one) {
  const SceneComparison& c = one.comparison;
  Json row = {{"ingredient", one.ingredient.name},
              {"present", one.ingredient.present},
              {"about", one.ingredient.about},
              {"overrides", one.ingredient.overrides},
              {"complete", c.complete}};
  if (!c.complete) row["why_incomplete"] = c.why_incomplete;
  row["verdict"] = to_string(one.verdict);
  if (!c.complete) {
    for (const char* key : {"qoi_change", "frame_ms_change"}) {
      row[key] = Json();
      row[std::string(key) + "_reason"] = c.why_incomplete;
    }
    return row;
  }
  row["qoi_change"] = changes(c);
  row["energy_norm_change"] = number(c.energy_norm_change);
  row["frame_ms_change"] = number(c.changed_mean_ms - c.mean_ms);
  row["frame_time_change"] = number(c.time_change());
  row["frame_ms"] = {
      {"mean", c.mean_ms}, {"changed_mean", c.changed_mean_ms}, {"p99", c.p99_ms}, {"changed_p99", c.changed_p99_ms}};
  row["unconverged_frames"] = c.unconverged;
  row["changed_unconverged_frames"] = c.changed_unconverged;
  return row;
}

std::string percent(double value, bool sign = false) {
  if (!std::isfinite(value)) return "-";
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), sign ? "%+.2g %%" : "%.2g %%", 100.0 * value);
  return text.data();
}

void print_audit(const Audit& audit, const AuditOptions& options) {
  std::printf("tolerance %s of each quantity; the scene beside itself differs in time by %s\n\n",
              percent(options.tolerance).c_str(), percent(std::abs(audit.with_itself.time_change())).c_str());
  std::printf("%-20s %-8s %-10s %10s %12s %10s  %s\n", "ingredient", "scene", "verdict", "quantities", "energy norm",
              "frame time", "");
  for (const AuditedIngredient& one : audit.ingredients) {
    const SceneComparison& c = one.comparison;
    std::printf("%-20s %-8s %-10s %10s %12s %10s  %s\n", one.ingredient.name.c_str(),
                one.ingredient.present ? "without" : "with", std::string(to_string(one.verdict)).c_str(),
                c.complete ? percent(c.largest_change()).c_str() : "-",
                c.complete ? percent(c.energy_norm_change).c_str() : "-",
                c.complete ? percent(c.time_change(), true).c_str() : "-",
                c.complete ? one.ingredient.about.c_str() : c.why_incomplete.c_str());
  }
  if (!audit.cheapest) return;
  const CheapestScene& cheapest = *audit.cheapest;
  if (cheapest.left_out.empty()) {
    std::printf("\nnothing that is spare takes time worth it: the scene is the cheapest within the tolerance\n");
    return;
  }
  std::string words;
  for (const std::string& name : cheapest.left_out) words += (words.empty() ? "" : ", ") + name;
  std::printf(
      "\ncheapest scene within the tolerance, run to verify it: without %s\n  quantities %s off, frame time %s\n  %s\n",
      words.c_str(), percent(cheapest.comparison.largest_change()).c_str(),
      percent(cheapest.comparison.time_change(), true).c_str(),
      run_command(options.scene, options.set, cheapest.overrides).c_str());
}

int audit(const AuditCommand& asked) {
  const CommonOptions& common = asked.common;
  if (!(asked.tolerance > 0.0 && std::isfinite(asked.tolerance)))
    throw UsageError("audit: --tolerance: found " + std::to_string(asked.tolerance) + ", allowed is finite and > 0");
  (void)parse_overrides(common.set);
  const Scene scene = read_scene(asked.scene, common.set);
  const std::filesystem::path directory = common.directory(scene.name + "_audit");
  require_writable(directory);
  use_threads(common.threads);
  Progress progress(common.quiet);
  AuditOptions options;
  options.scene = asked.scene;
  options.set = common.set;
  if (common.quick)
    for (std::string& one : quick_overrides(scene)) options.set.push_back(std::move(one));
  options.tolerance = asked.tolerance;
  options.seed = asked.seed;
  options.progress = [&](double fraction, const std::string& doing) { progress.update(fraction, doing); };
  options.interrupted = [] { return interrupt_signal() != 0; };

  ResultDocument document;
  document.kind = "audit";
  document.name = scene.name;
  document.quick = common.quick;
  document.inputs = {asked.scene, sha256_of_file(asked.scene), parse_overrides(options.set)};
  document.environment = describe_environment(common.threads);
  const Audit found = run_audit(options);
  progress.clear();

  for (const AuditedIngredient& one : found.ingredients) document.rows.push_back(to_row(one));
  document.summary["tolerance"] = asked.tolerance;
  document.summary["finished"] = found.finished;
  document.summary["noise"] = number(std::abs(found.with_itself.time_change()));
  // Frames in turns of one scene have the same bits; places that are looked up again are off by round-off.
  constexpr double round_off = 1e-9;
  if (found.with_itself.complete)
    document.checks.push_back(check("change_of_nothing", found.with_itself.energy_norm_change, 0.0, round_off));
  if (found.cheapest) {
    const CheapestScene& cheapest = *found.cheapest;
    document.summary["cheapest"] = {
        {"left_out", cheapest.left_out},
        {"overrides", cheapest.overrides},
        {"qoi_change", changes(cheapest.comparison)},
        {"frame_ms_change", number(cheapest.comparison.changed_mean_ms - cheapest.comparison.mean_ms)},
        {"frame_time_change", number(cheapest.comparison.time_change())},
        {"command", run_command(options.scene, options.set, cheapest.overrides)}};
    document.checks.push_back(
        check("cheapest_within_tolerance", cheapest.comparison.largest_change(), 0.0, asked.tolerance));
  }
  if (!common.json) print_audit(found, options);
  if (!found.finished) progress.note("interrupted: what was compared is kept");
  if (!common.json) std::fflush(stdout);
  return finish(document, common, directory, progress);
}

}  // namespace

void add_audit_command(CLI::App& program, int& exit_code) {
  CLI::App* command = program.add_subcommand(
      "audit", "What a scene needs: leaves out or adds one ingredient at a time, and tells what it changes and costs");
  const auto asked = std::make_shared<AuditCommand>();
  command->add_option("SCENE", asked->scene, "Scene file (finegauge help scene)")->required();
  command
      ->add_option("--tolerance", asked->tolerance,
                   "Change of the scene's quantities, relative, up to which an ingredient is spare (default 0.02)")
      ->check(CLI::PositiveNumber);
  command->add_option("--seed", asked->seed, "Of the order in which frames take turns (default 1)");
  add_common_options(*command, asked->common, "KEY=VALUE: replaces a key of the scene before the audit; repeatable");
  command->footer(
      "The scene and the changed one run side by side, a frame of each in turn. A change is judged by the quantities\n"
      "of the scene, or by the energy norm where it has none; the energy norm is told in any case. Ingredients that\n"
      "are spare and take over a hundredth of the time, and more than noise does, are then left out together, and the\n"
      "scene that is left is run to see that it stays within the tolerance. Writes NAME.json and NAME.csv.\n"
      "\n"
      "Examples:\n"
      "  finegauge audit reference_data/scenes/phantom.toml --tolerance 0.05\n"
      "  finegauge audit my_scene.toml --quick");
  command->callback([&exit_code, asked] { exit_code = audit(*asked); });
}

}  // namespace finegauge
