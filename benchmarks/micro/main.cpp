#include <benchmark/benchmark.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <iostream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "benchmarks/measure/cost_against_size.hpp"

using namespace finegauge;

namespace {

/// A flag of Google Benchmark as the library reads it, the last of the command line before the environment; the
/// library itself hands out neither the format nor the colour.
std::optional<std::string> flag(int argc, char** argv, const std::string& name) {
  std::optional<std::string> value;
  std::string variable = "BENCHMARK_" + name;
  std::ranges::transform(variable, variable.begin(), [](unsigned char c) { return std::toupper(c); });
  if (const char* const set = std::getenv(variable.c_str())) value = set;
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    const std::string option = "--benchmark_" + name;
    if (argument == option) value = "true";
    if (argument.starts_with(option + "=")) value = argument.substr(option.size() + 1);
  }
  return value;
}

bool is_true(const std::string& value) {
  return value == "true" || value == "yes" || value == "on" || value == "1" || value == "t" || value == "y";
}

benchmark::ConsoleReporter::OutputOptions output_options(int argc, char** argv) {
  using Reporter = benchmark::ConsoleReporter;
  const std::string color = flag(argc, argv, "color").value_or("auto");
  const char* const terminal = std::getenv("TERM");
  const bool colored =
      color == "auto" ? isatty(STDOUT_FILENO) && terminal && std::string_view(terminal) != "dumb" : is_true(color);
  const bool tabular = is_true(flag(argc, argv, "counters_tabular").value_or("false"));
  return static_cast<Reporter::OutputOptions>((colored ? Reporter::OO_Color : 0) |
                                              (tabular ? Reporter::OO_Tabular : 0));
}

/// Versions before 1.8 say `error_occurred`, later ones `skipped`.
template <class Run>
bool is_sound(const Run& run) {
  if constexpr (requires { run.error_occurred; })
    return !run.error_occurred;
  else
    return !run.skipped;
}

/// The benchmark's name without the arguments that are its size.
std::string family_of(const benchmark::BenchmarkName& name) {
  std::string family = name.function_name;
  for (std::size_t at = 0; at < name.args.size();) {
    const std::size_t end = std::min(name.args.find('/', at), name.args.size());
    const std::string argument = name.args.substr(at, end - at), label = argument.substr(0, argument.find(':'));
    if (label != "dofs" && label != "cells" && label != "scale" && label != "eta_percent") family += '/' + argument;
    at = end + 1;
  }
  return family;
}

/// The library's console, and after the last benchmark what the costs grow like. Of repetitions the median counts.
class ExponentsReporter : public benchmark::ConsoleReporter {
 public:
  using ConsoleReporter::ConsoleReporter;

  void ReportRuns(const std::vector<Run>& reports) override {
    ConsoleReporter::ReportRuns(reports);
    for (const Run& run : reports) {
      const bool counts = run.repetitions > 1 ? run.aggregate_name == "median" : run.run_type == Run::RT_Iteration;
      if (counts && is_sound(run)) add(run);
    }
  }
  void Finalize() override {
    ConsoleReporter::Finalize();
    GetOutputStream() << cost_against_size_table(results_) << std::flush;
  }

 private:
  void add(const Run& run) {
    const auto size = run.counters.find("free_dofs");
    if (size == run.counters.end()) return;
    const double to_ms = 1e3 / benchmark::GetTimeUnitMultiplier(run.time_unit);
    SizedResult result{family_of(run.run_name), size->second, to_ms * run.GetAdjustedCPUTime(), {}};
    for (const auto& [name, counter] : run.counters) result.counters.push_back({name, counter});
    results_.push_back(std::move(result));
  }

  std::vector<SizedResult> results_;
};

}  // namespace

/// BENCHMARK_MAIN with a table at the end where the console is asked for; JSON and CSV stay as the library writes them.
int main(int argc, char** argv) {
  const bool on_console = flag(argc, argv, "format").value_or("console") == "console";
  ExponentsReporter reporter(output_options(argc, argv));
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  if (on_console)
    benchmark::RunSpecifiedBenchmarks(&reporter);
  else
    benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
