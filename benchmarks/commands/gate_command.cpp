#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <random>

#include "benchmarks/commands/commands.hpp"
#include "benchmarks/gate/budget.hpp"
#include "benchmarks/gate/gate.hpp"
#include "benchmarks/program/command.hpp"
#include "benchmarks/program/interrupt.hpp"
#include "benchmarks/program/sha256.hpp"

namespace finegauge {
namespace {

struct GateArguments {
  std::string budgets, base;
  std::vector<std::string> only;
  std::optional<std::uint32_t> seed;
  bool list = false, counters = false;
  CommonOptions common;
};

std::string short_number(double value, int digits = 4) {
  char text[40];
  // Counts whole, whatever their size.
  const bool whole = std::abs(value) < 1e15 && value == std::floor(value);
  std::snprintf(text, sizeof text, "%.*g", whole ? 15 : digits, value);
  return text;
}

std::string bounds_text(const Judgement& judgement) {
  if (judgement.low == judgement.high) return "= " + short_number(judgement.high);
  if (judgement.low == 0.0 && judgement.kind == "time") return "up to " + short_number(judgement.high);
  return short_number(judgement.low) + " to " + short_number(judgement.high);
}

std::string how_text(const Judgement& judgement) {
  const Json& details = judgement.details;
  std::string how = judgement.judged;
  char text[120];
  if (details.contains("p_value")) {
    std::snprintf(text, sizeof text, ": %d blocks, 95 %% within %.3f to %.3f, p = %.2g", details["blocks"].get<int>(),
                  details["ratio_low"].get<double>(), details["ratio_high"].get<double>(),
                  details["p_value"].get<double>());
    how += text;
    if (!details["frame_by_frame"].get<bool>()) how += ", other frames than the base";
  } else if (details.contains("kernel_ms")) {
    std::snprintf(text, sizeof text, ": %d runs within %.2f to %.2f, kernel %.2f ms", details["runs"].get<int>(),
                  details["ratio_low"].get<double>(), details["ratio_high"].get<double>(),
                  details["kernel_ms"].get<double>());
    how += text;
  } else if (details.contains("instructions")) {
    std::snprintf(text, sizeof text, ": %.4g million instructions over %.4g million",
                  1e-6 * details["instructions"].get<double>(), 1e-6 * details["instructions_over"].get<double>());
    how += text;
  }
  return how;
}

void print_judgements(const GateResult& result) {
  std::size_t widest = 0;
  for (const Judgement& judgement : result.judgements) widest = std::max(widest, judgement.name.size());
  const int width = static_cast<int>(widest);
  std::printf("        %-*s  %10s  %-18s  %s\n", width, "budget", "value", "bounds", "judged");
  for (const Judgement& judgement : result.judgements) {
    const char* verdict = judgement.skipped ? "skipped" : judgement.ok ? "ok" : "FAILS";
    std::printf("%-7s %-*s  %10s  %-18s  %s\n", verdict, width, judgement.name.c_str(),
                judgement.value ? short_number(*judgement.value).c_str() : "-", bounds_text(judgement).c_str(),
                how_text(judgement).c_str());
    if (!judgement.why.empty()) std::printf("          %s\n", judgement.why.c_str());
    if (!judgement.ok)
      std::printf("          bounds: %s\n          finegauge %s\n", judgement.reason.c_str(), judgement.run.c_str());
  }
}

void print_list(const std::vector<Budget>& budgets) {
  for (const Budget& budget : budgets) {
    std::printf("%s\n    %s of finegauge %s\n", budget.name.c_str(), to_string(budget.kind),
                to_string(budget.run).c_str());
    if (!budget.value.empty())
      std::printf("    %s within %s to %s\n", budget.value.c_str(), short_number(budget.low).c_str(),
                  short_number(budget.high).c_str());
    else if (budget.kind == BudgetKind::time && budget.against_base)
      std::printf("    p%d of %s at most %.0f %% above the base's\n", budget.percentile, budget.frames.c_str(),
                  100.0 * budget.slower);
    else if (budget.kind == BudgetKind::time)
      std::printf("    p%d of %s within %s to %s frames of the calibration kernel\n", budget.percentile,
                  budget.frames.c_str(), short_number(budget.low).c_str(), short_number(budget.high).c_str());
    else
      std::printf("    %s%s%s to %s times those of %s\n", budget.within.empty() ? "" : "within ",
                  budget.within.empty() ? "" : (budget.within + ": ").c_str(), short_number(budget.low).c_str(),
                  short_number(budget.high).c_str(),
                  budget.over.empty() ? "the base" : ("finegauge " + to_string(budget.over)).c_str());
    std::printf("    %s\n", budget.reason.c_str());
  }
}

/// The budgets whose name or kind is asked for, in the file's order.
std::vector<Budget> chosen_budgets(std::vector<Budget> budgets, const std::vector<std::string>& only) {
  if (only.empty()) return budgets;
  for (const std::string& word : only)
    if (std::ranges::none_of(budgets, [&](const Budget& b) { return b.name == word || word == to_string(b.kind); })) {
      std::string known;
      for (const Budget& budget : budgets) known.append(known.empty() ? "" : ", ").append(budget.name);
      throw UsageError(std::string("gate: --only ")
                           .append(word)
                           .append(": no budget has this name or kind; there are: ")
                           .append(known));
    }
  std::erase_if(budgets, [&](const Budget& budget) {
    return std::ranges::none_of(only,
                                [&](const std::string& w) { return budget.name == w || w == to_string(budget.kind); });
  });
  return budgets;
}

std::optional<std::filesystem::path> base_program(const std::string& given) {
  if (given.empty()) return {};
  std::error_code error;
  const std::filesystem::path program = std::filesystem::absolute(given, error);
  if (!std::filesystem::is_regular_file(program, error) || ::access(program.c_str(), X_OK) != 0)
    throw UsageError("gate: --base " + given + ": found no program, allowed the finegauge of another build");
  return program;
}

/// The counters of the program itself, as a result that budgets read.
int write_counters(const CommonOptions& options) {
  const std::filesystem::path directory = options.directory("counters");
  require_writable(directory);
  use_threads(options.threads);
  Progress progress(options.quiet);
  ResultDocument document;
  document.kind = "gate";
  document.name = "counters";
  document.environment = describe_environment(options.threads);
  document.summary = exact_counters();
  for (const auto& [mesh, counters] : document.summary.items()) {
    Json row = {{"mesh", mesh}};
    row.update(counters);
    document.rows.push_back(std::move(row));
  }
  if (!options.json) std::printf("%s", to_csv(document.rows).c_str());
  return finish(document, options, directory, progress);
}

ResultDocument document_of(const GateArguments& asked, const GateResult& result, std::uint32_t seed) {
  ResultDocument document;
  document.kind = document.name = "gate";
  document.quick = asked.common.quick;
  document.inputs.scene = asked.budgets;
  document.inputs.sha256 = sha256_of_file(asked.budgets);
  int held = 0, skipped = 0;
  for (const Judgement& judgement : result.judgements) {
    document.rows.push_back(to_row(judgement));
    document.checks.push_back(to_check(judgement));
    skipped += judgement.skipped;
    held += judgement.ok && !judgement.skipped;
  }
  const int judged = static_cast<int>(result.judgements.size());
  // Of a file of which all was skipped nothing was compared.
  document.checks.push_back(check("budgets_compared", judged - skipped, 1.0, std::max(1, judged)));
  document.summary["budgets"] = judged;
  document.summary["held"] = held;
  document.summary["failed"] = judged - held - skipped;
  document.summary["skipped"] = skipped;
  document.summary["seed"] = seed;
  document.summary["base"] = asked.base.empty() ? Json(nullptr) : Json(asked.base);
  if (asked.base.empty()) document.summary["base_reason"] = "none was given";
  Json jobs = Json::array();
  for (const GateJob& job : result.jobs) {
    jobs.push_back({{"run", job.run}, {"exit_code", job.exit_code}, {"seconds", job.seconds}});
    // What a command itself finds wrong is wrong, whether or not a budget reads it.
    if (job.exit_code != 0) document.checks.push_back(check("exit code of " + job.run, job.exit_code, 0.0, 0.0));
  }
  document.summary["jobs"] = std::move(jobs);
  return document;
}

int gate(const GateArguments& asked) {
  const CommonOptions& options = asked.common;
  if (!options.set.empty()) throw UsageError("gate: --set has nothing to set; the budgets name their commands whole");
  if (options.vtu_every > 0) throw UsageError("gate: --vtu has nothing to write");
  if (asked.counters) {
    if (!asked.budgets.empty()) throw UsageError("gate: --counters takes no budgets");
    return write_counters(options);
  }
  if (asked.budgets.empty()) throw UsageError("gate: BUDGETS.toml is required, such as ci/budgets.toml");
  const std::vector<Budget> budgets = chosen_budgets(read_budgets(asked.budgets), asked.only);
  if (asked.list) {
    print_list(budgets);
    return exit_ok;
  }
  GateOptions gate_options;
  gate_options.base = base_program(asked.base);
  gate_options.quick = options.quick;
  gate_options.seed = asked.seed ? *asked.seed : std::random_device{}();
  const std::filesystem::path directory = result_directory(options, "gate", "gate");
  require_writable(directory);
  use_threads(options.threads);
  Progress progress(options.quiet);
  gate_options.progress = [&](double fraction, const std::string& doing) { progress.update(fraction, doing); };
  Environment environment = describe_environment(options.threads);
  const GateResult result = run_gate(budgets, gate_options);
  progress.clear();

  ResultDocument document = document_of(asked, result, gate_options.seed);
  document.environment = std::move(environment);
  if (!options.json) {
    print_judgements(result);
    std::printf("%d of %d budgets hold, %d fail, %d skipped; seed %u\n", document.summary["held"].get<int>(),
                document.summary["budgets"].get<int>(), document.summary["failed"].get<int>(),
                document.summary["skipped"].get<int>(), gate_options.seed);
    std::fflush(stdout);
  }
  return finish(document, options, directory, progress);
}

}  // namespace

void add_gate_command(CLI::App& program, int& exit_code) {
  CLI::App* command = program.add_subcommand(
      "gate", "Runs what a file of budgets names and fails on a breach: accuracy, counts, times");
  const auto asked = std::make_shared<GateArguments>();
  command->add_option("BUDGETS", asked->budgets, "File of [[budget]] sections, such as ci/budgets.toml");
  command
      ->add_option("--base", asked->base,
                   "The finegauge of another build: its frame times and instructions are compared with this one's")
      ->type_name("PROGRAM");
  command->add_option("--only", asked->only, "Budgets by name or kind (accuracy, counter, instructions, time)")
      ->type_name("NAME");
  command
      ->add_option("--seed", asked->seed,
                   "Of the order in which the two builds run (default: another each time; it is printed)")
      ->type_name("N");
  command->add_flag("--list", asked->list, "Prints the budgets and runs nothing");
  command->add_flag("--counters", asked->counters,
                    "Instead of a gate: counts of the L-shape's matrix and factor, for budgets to read");
  add_common_options(*command, asked->common, "not for this command: the budgets name their commands whole");
  command->footer(
      "Each command that the budgets name runs once, as a process of its own. Frame times are judged against the\n"
      "--base build, run in turns with this one in random order: slower by more than 10 % (Hodges-Lehmann) and by a\n"
      "signed-rank test (p < 0.01); or against a calibration kernel that runs in between. No budget is in\n"
      "milliseconds. A budget whose number is missing fails; one that may be skipped here (optional) says so.\n"
      "--quick leaves out instruction counts and slow budgets, and says so too.\n"
      "\n"
      "Examples:\n"
      "  finegauge gate ci/budgets.toml\n"
      "  finegauge gate ci/budgets.toml --only time --base ../before/build/program/benchmarks/finegauge\n"
      "  finegauge gate ci/budgets.toml --list");
  command->callback([&exit_code, asked] { exit_code = gate(*asked); });
}

}  // namespace finegauge
