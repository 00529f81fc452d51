#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>

#include "benchmarks/commands/commands.hpp"
#include "benchmarks/program/command.hpp"
#include "benchmarks/program/interrupt.hpp"
#include "verification/studies/evidence_studies.hpp"

namespace finegauge {
namespace {

std::vector<const EvidenceStudy*> chosen_evidence(const std::vector<std::string>& names) {
  std::string known = "all";
  for (const EvidenceStudy& study : evidence_studies()) known.append(", ").append(study.name);
  for (const std::string& name : names)
    if (name != "all" && std::ranges::find(evidence_studies(), name, &EvidenceStudy::name) == evidence_studies().end())
      throw UsageError(std::string("verify: no study \"").append(name).append("\"; there are: ").append(known));
  const bool all = names.empty() || std::ranges::find(names, "all") != names.end();
  std::vector<const EvidenceStudy*> chosen;
  for (const EvidenceStudy& study : evidence_studies())
    if (all || std::ranges::find(names, study.name) != names.end()) chosen.push_back(&study);
  return chosen;
}

/// What one study showed, or why it showed nothing.
struct StudyOutcome {
  Evidence evidence;
  std::string failure;  ///< of a study that threw
  double seconds = 0.0;
};

StudyOutcome run_study(const EvidenceStudy& study, const EvidenceOptions& options) {
  StudyOutcome outcome;
  const auto started = std::chrono::steady_clock::now();
  try {
    outcome.evidence = study.run(options);
  } catch (const std::exception& error) {
    outcome.failure = error.what();  // a solve that fails takes its study along, not the others
  }
  outcome.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  return outcome;
}

void print_outcome(const EvidenceStudy& study, const StudyOutcome& outcome) {
  std::printf("%s: %s (%.1f s)\n\n", study.name.c_str(), study.about.c_str(), outcome.seconds);
  if (!outcome.failure.empty()) std::printf("  FAILS  %s\n", outcome.failure.c_str());
  std::printf("%s\n", to_text(outcome.evidence).c_str());
  std::fflush(stdout);
}

Json to_json(const EvidenceTable& table) {
  Json rows = Json::array();
  for (const std::vector<TableValue>& values : table.rows) {
    Json row = Json::array();
    for (const TableValue& value : values) std::visit([&](const auto& content) { row.push_back(content); }, value);
    rows.push_back(std::move(row));
  }
  return {{"title", table.title}, {"columns", table.columns}, {"rows", std::move(rows)}};
}

void record(const EvidenceStudy& study, const StudyOutcome& outcome, ResultDocument& document) {
  const std::string factor = to_string(study.factor);
  for (const Claim& claim : outcome.evidence.claims) {
    document.rows.push_back({{"study", study.name},
                             {"factor", factor},
                             {"claim", claim.name},
                             {"value", claim.value},
                             {"low", claim.low},
                             {"high", claim.high},
                             {"ok", claim.holds()},
                             {"reason", claim.reason}});
    document.checks.push_back(check(study.name + "." + claim.name, claim.value, claim.low, claim.high));
  }
  Json tables = Json::array();
  for (const EvidenceTable& table : outcome.evidence.tables) tables.push_back(to_json(table));
  document.summary["studies"][study.name] = {{"factor", factor},
                                             {"seconds", outcome.seconds},
                                             {"claims", outcome.evidence.claims.size()},
                                             {"tables", std::move(tables)}};
  if (outcome.failure.empty() && !outcome.evidence.claims.empty()) return;
  // A study that showed nothing has not held.
  document.summary["studies"][study.name]["failure"] = outcome.failure.empty() ? "no claims" : outcome.failure;
  document.checks.push_back(check(study.name + ".ran", 0.0, 1.0, 1.0));
}

int verify(const std::vector<std::string>& names, const CommonOptions& options) {
  const std::vector<const EvidenceStudy*> studies = chosen_evidence(names);
  if (!options.set.empty()) throw UsageError("verify: --set has nothing to set; the studies bring their own problems");
  if (options.quick) throw UsageError("verify: there is no --quick; name the studies that you want (finegauge list)");
  const std::filesystem::path directory = result_directory(options, "verify", "verify");
  require_writable(directory);
  use_threads(options.threads);
  Progress progress(options.quiet);
  ResultDocument document;
  document.kind = document.name = "verify";
  document.environment = describe_environment(options.threads);

  std::optional<CredibilityFactor> heading;
  for (std::size_t k = 0; k < studies.size() && interrupt_signal() == 0; ++k) {
    EvidenceOptions of_study;
    of_study.full = options.full;
    of_study.interrupted = [] { return interrupt_signal() != 0; };
    of_study.progress = [&](double fraction, const std::string& doing) {
      progress.update((static_cast<double>(k) + fraction) / static_cast<double>(studies.size()),
                      studies[k]->name + ": " + doing);
    };
    of_study.progress(0.0, "starts");
    const StudyOutcome outcome = run_study(*studies[k], of_study);
    if (interrupt_signal() != 0) break;  // half a study is no evidence
    record(*studies[k], outcome, document);
    progress.clear();
    if (options.json) continue;
    if (heading != studies[k]->factor) {
      const std::string title = to_string(studies[k]->factor);
      std::printf("%s\n%s\n\n", title.c_str(), std::string(title.size(), '=').c_str());
    }
    heading = studies[k]->factor;
    print_outcome(*studies[k], outcome);
  }
  const auto held = std::ranges::count_if(document.checks, [](const Json& one) { return one.at("ok").get<bool>(); });
  document.summary["claims"] = document.checks.size();
  document.summary["claims_that_hold"] = held;
  document.summary["peak_memory_mb"] = peak_memory_mb();
  if (!options.json) std::printf("%zu of %zu claims hold\n", static_cast<std::size_t>(held), document.checks.size());
  return finish(document, options, directory, progress);
}

}  // namespace

void add_verify_command(CLI::App& program, int& exit_code) {
  CLI::App* command = program.add_subcommand(
      "verify", "The evidence for trusting a number: orders, published problems, effectivity, reversibility");
  const auto names = std::make_shared<std::vector<std::string>>();
  const auto options = std::make_shared<CommonOptions>();
  command->add_option("STUDY", *names, "Studies by name (finegauge list); all without one");
  add_common_options(*command, *options, "not for this command: the studies bring their own problems");
  command->footer(
      "Prints tables, and the claims that the tests gate, each with its bounds and their reason, under the headings "
      "of\n"
      "ASME V&V 40. Takes some minutes; --full adds finer grids and says so in its progress. A claim that does not\n"
      "hold ends the command with exit code 1.\n"
      "\n"
      "Examples:\n"
      "  finegauge verify\n"
      "  finegauge verify estimator friction\n"
      "  finegauge verify solid-problems --full --json");
  command->callback([&exit_code, names, options] { exit_code = verify(*names, *options); });
}

}  // namespace finegauge
